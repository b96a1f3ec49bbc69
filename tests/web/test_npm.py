"""The npm package: contents, types, and its use in Node.js, vite, React and import maps."""

import gzip
import json
import re
import shutil
import socket
import subprocess
import time
from base64 import b64decode
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from torch.nn.functional import normalize

from mobilegs import __version__
from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import decode_mgs, encode_mgs, read_mgs
from tests.support.browser import Tab, polled
from tests.support.node import assert_close, node_program
from tests.support.npm_package import EXAMPLES, MODULES, hosted, packed, project, run, vite
from tests.support.scene_cases import CASES, make_scene
from tests.support.viewer_page import MGS, STRICT, screen, still, until

pytestmark = pytest.mark.thorough

SOURCES = Path(__file__).parent / "npm"
TRAINED = Path(__file__).parents[1] / "support" / "trained.mgs"
LIMIT = 280_000  # bytes of the unpacked package
# "loaded", or the sentence that the element shows; null before, also while it is not defined
SETTLED = """() => {
  const element = document.querySelector("mobile-gs");
  const message = element?.shadowRoot?.querySelector(".message");
  if (message && !message.hidden) return message.querySelector("p").textContent;
  return element?.dataset.state === "loaded" ? "loaded" : null;
}"""
STATE = "document.querySelector('mobile-gs').getAttribute('data-state')"


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The tarball, and what `npm pack` tells of it."""
    return packed(tmp_path_factory.mktemp("npm"))


@pytest.fixture(scope="module")
def fresh(
    package: tuple[Path, dict[str, Any]], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[int], Path]:
    """A function that gives a project with React 19 or 18, the examples and sources of tests."""
    folder, made = tmp_path_factory.mktemp("projects"), {}

    def give(react: int = 19) -> Path:
        if react not in made:
            made[react] = project(folder / f"react{react}", package[0], react)
            for path in [*SOURCES.iterdir(), *EXAMPLES.iterdir()]:
                if path.name != "package.json":
                    shutil.copy(path, made[react])
            (made[react] / "scene.mgs").write_bytes(MGS)
        return made[react]

    return give


# --- the tarball


def test_the_tarball_has_scripts_and_types_and_nothing_else(
    package: tuple[Path, dict[str, Any]],
) -> None:
    told = package[1]
    assert (told["name"], told["version"]) == ("mobilegs", __version__)
    names = {file["path"] for file in told["files"]}
    kinds = [
        r"LICENSE|README\.md|package\.json",
        r"dist/(index|element|three|react|react-three|chunk-[A-Z0-9]{8})\.js",
        r"dist/types/(package|viewer|mgs|three|react)/\w+\.d\.ts|dist/types/element\.d\.ts",
    ]
    assert not [name for name in names if not any(re.fullmatch(kind, name) for kind in kinds)]
    entries = {f"dist/{name}.js" for name in ("index", "element", "three", "react", "react-three")}
    assert names >= {"LICENSE", "README.md", "package.json", *entries}
    assert f"npm/mobilegs@{__version__}/" in (EXAMPLES.parents[1] / "npm/README.md").read_text()
    print(f"{told['unpackedSize']} bytes unpacked, {told['size']} packed")
    assert told["unpackedSize"] < LIMIT


def imported(folder: Path, names: set[str], pattern: str) -> set[str]:
    """Return scripts and those that they import, statically or in all ways, by their names."""
    found: set[str] = set()
    while names:
        name = names.pop()
        found.add(name)
        text = (folder / name).read_text("utf-8")
        names |= set(re.findall(pattern + r'"\./([\w.-]+\.js)"', text)) - found
    return found


def test_the_guide_tells_the_sizes_of_the_entries(fresh: Callable[..., Path]) -> None:
    folder = fresh() / "node_modules" / "mobilegs" / "dist"
    guide = (EXAMPLES.parents[1] / "docs" / "guides" / "web.md").read_text("utf-8")
    told = re.findall(r"^\| `mobilegs(?:/(\w+))?` \| .* \| (\d+) \+ (\d+) \|$", guide, re.MULTILINE)
    assert [name for name, *_ in told] == ["element", "", "three"]
    for name, *sizes in told:
        first = imported(folder, {f"{name or 'index'}.js"}, r"(?:from|import)")
        later = imported(folder, set(first), r"(?:from|import)\(?") - first
        for size, scripts in zip(sizes, (first, later), strict=True):
            found = sum(len(gzip.compress((folder / one).read_bytes())) for one in scripts)
            assert abs(found / 1e3 - int(size)) < 1, (name, found)


def test_scripts_say_what_other_tools_need(fresh: Callable[..., Path]) -> None:
    installed = fresh() / "node_modules" / "mobilegs"
    texts = {path.name: path.read_text("utf-8") for path in installed.rglob("*.*s")}
    for name, text in texts.items():
        assert str(MODULES.parent.parent) not in text and "sourceMappingURL" not in text, name
        # servers of React
        assert text.startswith('"use client"') == (name in ("react.js", "react-three.js")), name
    # bundlers leave the import of the decoder in Node.js alone
    (loader,) = [text for text in texts.values() if "import(/*" in text]
    assert "import(/* webpackIgnore: true */ /* @vite-ignore */`data:" in loader


def test_it_has_no_dependency_and_optional_peers(fresh: Callable[..., Path]) -> None:
    manifest = json.loads((fresh() / "node_modules/mobilegs/package.json").read_text())
    assert not manifest.keys() & {"dependencies", "scripts", "devDependencies"}
    peers = manifest["peerDependencies"].keys()
    assert peers == {"three", "react", "@react-three/fiber"}
    assert manifest["peerDependenciesMeta"] == {name: {"optional": True} for name in peers}


def test_publint_and_arethetypeswrong_find_nothing(
    package: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    tarball = package[0]
    said = run(tmp_path, MODULES / "publint" / "src" / "cli.js", tarball, "--strict")
    assert "All good!" in said
    checker = MODULES / "@arethetypeswrong" / "cli" / "dist" / "index.js"
    # the package has ES modules only
    run(tmp_path, checker, tarball, "--profile", "esm-only", "--quiet")


def test_a_project_in_strict_mode_compiles(fresh: Callable[..., Path]) -> None:
    folder = fresh()
    options = {
        "strict": True,
        "skipLibCheck": False,
        "noEmit": True,
        "exactOptionalPropertyTypes": True,
    }
    options |= {"target": "es2022", "module": "nodenext", "jsx": "react-jsx", "types": []}
    options |= {"lib": ["es2022", "dom", "dom.iterable"]}
    settings = {"compilerOptions": options, "include": ["strict.tsx"]}
    (folder / "tsconfig.json").write_text(json.dumps(settings))
    run(folder, MODULES / "typescript" / "bin" / "tsc", "-p", ".")


# --- the decoder


def decoded(folder: Path, paths: list[Path]) -> Iterator[tuple[dict, dict]]:
    """Yield description and arrays of the files, as the package decodes them in Node.js."""
    run(folder, "decode.js", *paths)
    for path in paths:
        told = json.loads(path.with_suffix(".mgs.json").read_text())
        values = torch.from_numpy(np.fromfile(path.with_suffix(".mgs.bin"), "<f4"))
        parts = values.split([length for _, length in told["layout"]])
        names = [name for name, _ in told["layout"]]
        yield told, dict(zip(names, parts, strict=True))


def test_it_decodes_what_python_decodes(fresh: Callable[..., Path], tmp_path: Path) -> None:
    """Positions, background and cameras to the bit, the rest to the rounding of float32."""
    cases = [case for case in CASES.values() if case.count <= 1000]
    paths = [tmp_path / f"{i}.mgs" for i in range(len(cases))]
    for path, case in zip(paths, cases, strict=True):
        path.write_bytes(encode_mgs(make_scene(case)))
    for path, (told, arrays) in zip(paths, decoded(fresh(), paths), strict=True):
        coded = read_mgs(path)
        scene = coded.decode()
        expected = scene.gaussians
        assert told["count"] == len(coded)
        assert torch.equal(arrays["means"], expected.means.reshape(-1))
        assert_close("quats", arrays["quats"], normalize(expected.quats, dim=1), 2e-7)
        assert_close("scales", arrays["scales"], expected.scales, 3e-7)
        assert_close("sh", arrays["sh"], expected.sh, 3e-6)
        assert_close("opacities", arrays["opacities"], expected.opacities, 3e-6)
        assert ("lobes" in arrays) == (scene.lobes is not None)
        if scene.lobes is not None:
            assert_close("lobes", arrays["lobes"], scene.lobes, 3e-6)
            assert (told["lobeDegree"] + 1) ** 2 == scene.lobes.shape[1]
        assert told["levels"] == list(coded.lod_sizes or [len(coded)])
        assert told["blend"] == coded.blend and told["near"] == coded.near
        assert told["notes"] == coded.meta
        assert (told["network"] is None) == (coded.network is None)
        assert torch.equal(torch.tensor(told["background"]), coded.background)
        assert {**told["weighting"], "detached": False} == vars(coded.weighting)
        assert told["footprint"] == vars(coded.footprint)
        for camera, view in zip(told["cameras"], coded.views, strict=True):
            assert torch.equal(torch.tensor(camera["viewmat"]), view.viewmat.reshape(-1))
            assert torch.equal(torch.tensor(camera["K"]), view.K.reshape(-1))
            assert (camera["width"], camera["height"]) == (view.width, view.height)


def test_all_sources_give_the_same_arrays(fresh: Callable[..., Path]) -> None:
    folder = fresh()
    told = json.loads(run(folder, "sources.js", TRAINED))
    for kind, result in told["found"].items():
        assert result["equal"], kind
        received = [progress["received"] for progress in result["told"]]
        assert received == sorted(set(received)) and received[-1] == told["size"], kind
        # unknown before the header is complete
        assert {progress["total"] for progress in result["told"]} <= {told["size"], None}
        if kind in ("stream", "response"):
            assert len(received) > told["size"] / 1000


def test_failures_are_sentences_and_signals_end_decoding(fresh: Callable[..., Path]) -> None:
    folder = fresh()
    found = json.loads(run(folder, "failures.js", "scene.mgs"))
    assert found["damaged"][0] == "SceneError" and found["damaged"][2]
    assert "it has been cut short" in found["damaged"][1]
    assert found["missing"][1] == "the scene could not be loaded: the server says 404"
    assert found["nothing"][0] == "TypeError" and "decodeMgs takes" in found["nothing"][1]
    assert found["aborted"][1] == found["cancelled"] == "enough"
    assert found["before"][1] == "never"


def test_an_app_with_the_decoder_alone_does_not_contain_the_viewer(
    fresh: Callable[..., Path], tab: Tab
) -> None:
    output = vite(fresh(), "decoder_only.html")
    scripts = [path.read_text("utf-8") for path in output.rglob("*.js")]
    size = sum(len(text) for text in scripts)
    print(f"{size} bytes")
    assert size < 60_000
    for word in ("attachShadow", "mobile-gs", "requestAdapter", "getContext"):
        assert not any(word in text for text in scripts), word
    # and it decodes, in a worker
    with hosted(output) as address:
        tab.page.goto(f"{address}/decoder_only.html")
        shutil.copy(fresh() / "scene.mgs", output)
        found = tab.page.evaluate(
            """async () => {
              const { count, means } = await decodeMgs("scene.mgs");
              const damaged = new Uint8Array(40);
              const { name, message } = await decodeMgs(damaged).catch((error) => error);
              const over = new AbortController();
              const { signal } = over;
              const onProgress = () => over.abort();
              const aborted = await decodeMgs("scene.mgs", { signal, onProgress })
                .catch((error) => error);
              return [count, means.length, name, message, aborted.name];
            }"""
        )
    assert found == [800, 2400, "SceneError", "this is not a .mgs scene", "AbortError"]


# --- the viewer and its components


def opened(tab: Tab, address: str, settled: str = SETTLED) -> str:
    tab.page.goto(address)
    return tab.page.wait_for_function(settled, timeout=60_000).json_value()


@pytest.mark.parametrize("page", ["element.html", "step.html"])
def test_an_example_with_the_element_works_with_an_import_map(
    page: str, fresh: Callable[..., Path], tab: Tab
) -> None:
    with hosted(fresh()) as address:
        assert opened(tab, f"{address}/{page}") == "loaded"
        if page == "element.html":
            before = tab.page.wait_for_function(
                "document.querySelector('#camera').value"
            ).json_value()
            tab.page.click("#closer")
            tab.page.wait_for_function(
                "(before) => document.querySelector('#camera').value !== before", arg=before
            )
            notes = tab.page.evaluate(
                """[...document.querySelectorAll('.note')].map(
                  (note) => getComputedStyle(note).visibility)"""
            )
            assert notes == ["visible", "visible"]
        else:
            both = "[...document.querySelectorAll('mobile-gs')]"
            tab.page.wait_for_function(f"{both}.every((one) => one.dataset.state === 'loaded')")
            tab.page.evaluate(f"{both}[1].camera = 'eye=0,0,-5&at=0,0,0&up=0,-1,0'")
            tab.page.wait_for_function(f"new Set({both}.map((one) => one.camera)).size === 1")


def test_the_example_of_the_decoder_works_with_an_import_map(
    fresh: Callable[..., Path], tab: Tab
) -> None:
    with hosted(fresh()) as address:
        text = opened(tab, f"{address}/decode.html", "document.querySelector('#found').textContent")
    assert json.loads(text)["count"] == 800


def test_the_example_of_three_works_with_an_import_map(
    fresh: Callable[..., Path], tab: Tab
) -> None:
    with hosted(fresh()) as address:
        # in software a frame takes long, and a screenshot of a page that never rests waits for ten
        tab.page.set_viewport_size({"width": 240, "height": 120})
        assert opened(tab, f"{address}/three.html", "document.body.dataset.state") == "hit"
        png = tab.page.evaluate(
            """() => new Promise((resolve) => requestAnimationFrame(() =>
              resolve(document.querySelector("canvas").toDataURL().split(",")[1])))"""
        )
        assert np.array(Image.open(BytesIO(b64decode(png))).convert("RGB")).std() > 20


@pytest.fixture(scope="module")
def built(fresh: Callable[..., Path]) -> Callable[[int], Path]:
    """A function that gives the built pages of a project, with React's checks of development."""
    outputs: dict[int, Path] = {}

    def give(react: int) -> Path:
        if react not in outputs:
            pages = ["hydrate.html", "react.html"]
            pages += ["react-three.html", "boundary.html"] if react == 19 else []
            folder = fresh(react)
            dist = vite(folder, *pages, NODE_ENV="development")
            outputs[react] = dist.rename(folder / "built")
            shutil.copy(folder / "scene.mgs", outputs[react])
        return outputs[react]

    return give


@pytest.mark.parametrize("react", [19, 18])
def test_a_server_of_react_renders_the_element(react: int, fresh: Callable[..., Path]) -> None:
    html = run(fresh(react), "server.js", str(react))
    expected = {
        'src="scene.mgs"',
        'autorotate=""',
        'loading="lazy"',
        'start-portrait="0 0 1 0 0 0 1 1"',
        'fov="40"',
        'class="stage"',
        'style="height:300px"',
    }
    assert html.startswith("<mobile-gs ") and all(word in html for word in expected), html
    assert "noui" not in html and "onCamera" not in html
    assert '<div slot="annotation" data-at="1 2.5 -3" class="note">here</div></mobile-gs>' in html
    assert "&quot;at&quot;:[0,1,0]" in html


@pytest.mark.parametrize("react", [19, 18])
def test_the_component_hydrates_and_changes(
    react: int, built: Callable[[int], Path], tab: Tab
) -> None:
    """Also without complaints of React's strict mode, which `tab` would report."""
    with hosted(built(react)) as address:
        assert opened(tab, f"{address}/hydrate.html") == "loaded"
        assert tab.page.evaluate("element === document.querySelector('mobile-gs')")
        tab.page.wait_for_function("told.some(({ kind }) => kind === 'camera')")
        # each event is told once, although effects run twice
        kinds = [one["kind"] for one in tab.page.evaluate("told.splice(0)")]
        assert kinds.count("load") == kinds.count("camera") == 1
        wanted = "eye=1,2,-3&at=0,0.5,0&up=0,-1,0"
        tab.page.evaluate(
            "(camera) => change({ camera, compare: 'sorted', background: '#ff0000', noui: true })",
            wanted,
        )
        tab.page.wait_for_function("told.some(({ kind }) => kind === 'camera')")
        assert tab.page.evaluate("[element.camera, told.length, told[0].camera]") == [
            wanted,
            1,
            wanted,
        ]
        assert tab.page.evaluate(
            "[element.viewer.background, element.getAttribute('compare')]"
        ) == [
            [1, 0, 0],
            "sorted",
        ]
        tab.page.wait_for_function(f"{STATE} === 'loaded'")
        tab.page.evaluate("change({})")
        tab.page.wait_for_function("!element.hasAttribute('compare')")
        tab.page.evaluate("(window.kept = element, leave())")
        tab.page.wait_for_function("element === null && kept.viewer === null")


@pytest.mark.parametrize("react", [19, 18])
def test_the_example_of_react_works(react: int, built: Callable[[int], Path], tab: Tab) -> None:
    with hosted(built(react)) as address:
        assert opened(tab, f"{address}/react.html") == "loaded"
        tab.page.wait_for_function(
            "document.querySelector('#state').textContent.startsWith('loaded in')"
        )
        tab.page.click("text=Turn")
        tab.page.wait_for_function("document.querySelector('mobile-gs').hasAttribute('autorotate')")
        tab.page.click("text=Stop")
        tab.page.wait_for_function(
            "!document.querySelector('mobile-gs').hasAttribute('autorotate')"
        )
        assert (
            tab.page.evaluate("getComputedStyle(document.querySelector('.note')).visibility")
            == "visible"
        )


def test_the_example_of_react_three_fiber_works(built: Callable[[int], Path], tab: Tab) -> None:
    tab.ignore("THREE.Clock: This module has been deprecated")  # of react-three-fiber
    with hosted(built(19)) as address:
        tab.page.goto(f"{address}/react-three.html")
        until(tab, lambda: bool(screen(tab).std() > 20))  # on white, without input: `demand`
        before = still(tab)
        size = tab.page.viewport_size
        tab.page.mouse.click(size["width"] / 2, size["height"] / 2)
        until(tab, lambda: bool((screen(tab) != before).mean() > 0.01))  # a ring is there


def test_an_error_boundary_gets_what_goes_wrong(built: Callable[[int], Path], tab: Tab) -> None:
    tab.ignore("THREE.Clock: This module has been deprecated")
    tab.ignore("404")
    with hosted(built(19)) as address:
        told = "document.querySelector('#told')?.textContent"
        sentence = opened(tab, f"{address}/boundary.html", told)
    assert "could not be loaded" in sentence


def test_a_sandboxed_frame_shows_a_scene(fresh: Callable[..., Path], tab: Tab) -> None:
    """Workers start in a page without an origin, whose host allows others to load its files."""
    folder = fresh()
    frame = "<iframe sandbox=allow-scripts src=element.html width=500 height=400></iframe>"
    (folder / "frame.html").write_text(f"<!doctype html><title>test</title>{frame}")

    def allow(route: Any) -> None:
        answer = route.fetch()
        allowed = {"Access-Control-Allow-Origin": "*"}
        route.fulfill(response=answer, headers={**answer.headers, **allowed})

    with hosted(folder) as address:
        tab.page.route(f"{address}/**", allow)
        tab.page.goto(f"{address}/frame.html")
        until(tab, lambda: len(tab.page.frames) > 1)
        loaded = "document.querySelector('mobile-gs')?.dataset.state === 'loaded'"
        polled(tab.page.frames[1], loaded, timeout=60_000)
        assert still(tab).std() > 10


@pytest.mark.parametrize("scene", ["scene.mgs", "scene.ply"])
@pytest.mark.parametrize("workers", ["'self'", "'none'"])
def test_a_page_hosts_the_script_of_the_workers(
    workers: str, scene: str, fresh: Callable[..., Path], tab: Tab
) -> None:
    """Policies may forbid `blob:`, or workers at all: the page draws and decodes nevertheless."""
    folder = fresh()
    script = "process.stdout.write(await (await import('mobilegs')).workerScript())"
    written = run(folder, "--input-type=module", "-e", script)
    (folder / "mobilegs-worker.js").write_text(written, "utf-8")
    write_ply(folder / "scene.ply", decode_mgs(MGS).decode().gaussians)
    (folder / "hosted.js").write_text(
        """import "./node_modules/mobilegs/dist/element.js";
        import { decodeMgs, setWorker } from "./node_modules/mobilegs/dist/index.js";
        setWorker("mobilegs-worker.js");
        document.querySelector("mobile-gs").src = location.hash.slice(1);
        decodeMgs("scene.mgs").then(({ count }) => (document.title = String(count)));"""
    )
    page = """<!doctype html><meta charset=utf-8><link rel=icon href=data:,><title>hosted</title>
      <script type=module src=hosted.js></script><mobile-gs></mobile-gs>"""
    policy = STRICT.replace("worker-src blob:", f"worker-src {workers}")
    headers = {"Content-Type": "text/html", "Content-Security-Policy": policy}
    tab.ignore("worker-src 'none'")
    started: list[str] = []
    tab.page.on("worker", lambda worker: started.append(worker.url))
    with hosted(folder) as address:
        tab.page.route(f"{address}/hosted.html", lambda r: r.fulfill(body=page, headers=headers))
        assert opened(tab, f"{address}/hosted.html#{scene}") == "loaded"
        tab.page.wait_for_function("document.title === '800'")
        assert still(tab).std() > 10
        assert bool(started) == (workers == "'self'"), started


@contextmanager
def developed(folder: Path) -> Iterator[str]:
    """Run vite's development server in a project; yields its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    program = MODULES / "vite" / "bin" / "vite.js"
    words = [node_program(), program, "--host", "127.0.0.1", "--port", port, "--strictPort"]
    server = subprocess.Popen(
        words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        end = time.monotonic() + 60
        while True:
            try:
                socket.create_connection(("127.0.0.1", int(port)), 1).close()
                break
            except OSError:
                assert server.poll() is None and time.monotonic() < end, "vite did not start"
                time.sleep(0.1)
        yield f"http://127.0.0.1:{port}"
    finally:
        server.terminate()
        server.wait()


def test_the_development_server_of_vite_needs_no_settings(
    fresh: Callable[..., Path], tab: Tab
) -> None:
    """Its optimizer moves the modules of packages: workers must start all the same."""
    folder = fresh()
    (folder / "vite.config.js").unlink(missing_ok=True)
    (folder / "favicon.ico").touch()
    with developed(folder) as address:
        assert opened(tab, f"{address}/react.html") == "loaded"
