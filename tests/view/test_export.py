"""Exported scenes: one HTML file, and a site that opens offline."""

import base64
import gzip
import hashlib
import json
import os
import re
import threading
import zlib
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.cli.main import main
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import encode_mgs, read_mgs
from mobilegs.render.supersampling import supersampling_for
from mobilegs.representation.lobes import LobeShape
from mobilegs.scene_file import open_with_views
from mobilegs.up import Axis
from mobilegs.view.assets import DIST, SCRIPTS, element_script, script, version_of
from mobilegs.view.poster import posters_of
from mobilegs.viewpoints.pose import camera_of, first_pose
from tests.support.browser import Chromium, Tab, polled
from tests.support.scene_cases import Case, make_scene
from tests.support.viewer_page import COUNT_WORKERS, RENDERERS, SETTLED, frames

# registers the service worker and returns its state once it is installed or refused
INSTALL = """async () => {
  const { installing, waiting, active } = await navigator.serviceWorker.register("sw.js");
  const worker = installing ?? waiting ?? active;
  while (worker && !["activated", "redundant"].includes(worker.state)) {
    await new Promise((changed) => (worker.onstatechange = changed));
  }
  return worker?.state ?? "redundant";
}"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "garden.mgs"
    path.write_bytes(encode_mgs(make_scene(Case(500, LobeShape(2, 12, (64,)), size=200))))
    return path


@pytest.fixture
def site(scene: Path, tmp_path: Path) -> Iterator[tuple[Path, str]]:
    """An exported folder, and the address at which it is served."""
    folder = tmp_path / "site"
    words = ["export", str(scene), "--to", "site", "-o", str(folder), "--title", "A <garden>"]
    assert main(words) == 0

    class Host(SimpleHTTPRequestHandler):
        """Like some hosts: index.html redirects to its folder, and answers have a Vary header."""

        def do_GET(self) -> None:
            if self.path.endswith("/index.html"):
                self.send_response(308)
                self.send_header("Location", self.path.removesuffix("index.html"))
                self.send_header("Content-Length", "0")
                self.end_headers()
            else:
                super().do_GET()

        def end_headers(self) -> None:
            self.send_header("Vary", "Origin")
            self.send_header("Access-Control-Allow-Origin", "*")
            super().end_headers()

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Host, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield folder, f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


def test_the_html_file_opens_without_a_network(tab: Tab, scene: Path, tmp_path: Path) -> None:
    page = tmp_path / "garden.html"
    assert main(["export", str(scene), "--to", "html", "-o", str(page)]) == 0
    asked: list[str] = []
    tab.page.on("request", lambda request: asked.append(request.url))
    tab.page.goto(f"{page.as_uri()}?scale=1&variant=floats")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.title() == "garden"
    assert all(url.startswith(("file:", "blob:", "data:")) for url in asked), asked


def test_a_ply_becomes_a_page_with_the_axis_of_the_option_upright(
    tab: Tab, scene: Path, tmp_path: Path
) -> None:
    write_ply(tmp_path / "plain.ply", read_mgs(scene).decode().gaussians)
    for to, page in (("html", tmp_path / "plain.html"), ("site", tmp_path / "site")):
        words = ["export", str(tmp_path / "plain.ply"), "--to", to, "-o", str(page), "--up", "z"]
        assert main(words) == 0
        text = (page if to == "html" else page / "index.html").read_text("utf-8")
        assert re.search(r'<mobile-gs[^>]* up="z"', text)
    tab.page.goto(f"{(tmp_path / 'plain.html').as_uri()}?scale=1&variant=floats")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.up") == [0, 0, 1]


def test_the_poster_is_the_first_view(scene: Path, tmp_path: Path) -> None:
    plain = tmp_path / "plain.ply"
    write_ply(plain, read_mgs(scene).decode().gaussians)
    cases: list[tuple[Path, Axis | None]] = [(scene, None), (plain, None), (plain, "z")]
    for path, up in cases:
        opened, views = open_with_views(path)
        pose = first_pose(opened, views, up)
        camera = camera_of(pose, views[0] if views else None, 1200, 630, opened.near)
        n = supersampling_for(camera, views)
        expected = to_bytes(opened.render(camera, supersampling=n).image).numpy()
        assert (np.array(posters_of(path, up).preview) == expected).all()


def test_a_visited_site_opens_offline(site: tuple[Path, str], tab: Tab) -> None:
    _, address = site
    tab.page.add_init_script(COUNT_WORKERS)
    begun = f"begun.length === 1 && begun[0].startsWith('{address}scene.mgs?')"
    tab.page.goto(f"{address}?scale=1&variant=floats")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.evaluate(begun)
    assert tab.page.title() == "A <garden>"
    tab.page.wait_for_function("navigator.serviceWorker.ready.then(() => true)", timeout=30_000)
    tab.page.wait_for_function("navigator.serviceWorker.controller !== null", timeout=30_000)
    tab.page.context.set_offline(True)
    tab.page.reload()
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.evaluate(begun)
    tab.page.goto(f"{address}index.html?scale=1&variant=floats")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"


@pytest.mark.thorough
@pytest.mark.parametrize("file", ["viewer.js", "index.html"])
def test_files_of_another_version_are_not_kept(site: tuple[Path, str], tab: Tab, file: str) -> None:
    """A browser may visit the site while it is being uploaded."""
    folder, address = site
    content = (folder / file).read_text("utf-8")
    version = re.findall(r'VERSION = "(\w+)"', (folder / "sw.js").read_text("utf-8"))[0]
    (folder / file).write_text(
        f"{content}\n" if file == "viewer.js" else content.replace(version, "")
    )
    tab.page.goto(f"{address}?scale=1&variant=floats")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.evaluate(INSTALL) == "redundant"
    # servers give times in whole seconds: a file of the same second would not count as changed
    written = (folder / file).stat().st_mtime
    (folder / file).write_text(content)
    os.utime(folder / file, (written + 2, written + 2))
    # a visit that begins while an earlier one is being refused may keep nothing
    for _ in range(4):
        tab.page.goto(f"{address}?scale=1&variant=floats")
        assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
        if tab.page.evaluate(INSTALL) == "activated":
            break
    tab.page.wait_for_function("navigator.serviceWorker.controller !== null", timeout=30_000)
    tab.complaints.clear()  # of the file that was refused


def test_a_browser_would_install_it(site: tuple[Path, str], tab: Tab) -> None:
    tab.page.goto(site[1])
    session = tab.page.context.new_cdp_session(tab.page)
    found = session.send("Page.getInstallabilityErrors")["installabilityErrors"]
    assert {error["errorId"] for error in found} <= {"in-incognito"}  # as test pages are
    manifest = session.send("Page.getAppManifest")
    assert manifest["errors"] == [] and "any maskable" in manifest["data"]


def test_the_site_has_all_the_files_that_it_names(site: tuple[Path, str], scene: Path) -> None:
    folder, _ = site
    assert (folder / "scene.mgs").read_bytes() == scene.read_bytes()
    manifest = json.loads((folder / "manifest.webmanifest").read_text("utf-8"))
    assert manifest["name"] == "A <garden>"
    with Image.open(folder / manifest["icons"][0]["src"]) as icon:
        assert icon.size == (512, 512)
    with Image.open(folder / "poster.jpg") as poster:
        assert poster.size == (1200, 630)
        assert np.asarray(poster).std() > 5
    listed = (folder / "sw.js").read_text("utf-8").split("FILES = ", 1)[1].split("};", 1)[0] + "}"
    files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    assert set(json.loads(listed)) == files - {"sw.js", "mobile-gs.js"} | {"."}
    # browsers look at sw.js for a new version, so it is written last
    assert max(folder.iterdir(), key=lambda path: path.stat().st_mtime_ns).name == "sw.js"
    assert "A &lt;garden&gt;" in (folder / "index.html").read_text("utf-8")


@pytest.mark.thorough
def test_link_previews_have_the_full_address_of_the_image(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["export", str(scene), "--to", "site", "-o", str(tmp_path / "out"), "--url"]
    for url in ("https://me.example/a&b", "https://me.example/a&b/index.html"):
        assert main([*words, url]) == 0
        page = (tmp_path / "out" / "index.html").read_text("utf-8")
        assert 'og:image" content="https://me.example/a&amp;b/poster.jpg"' in page
        assert 'og:url" content="https://me.example/a&amp;b/"' in page
    assert main([*words, "https://me.example:8080/myindex.html"]) == 0
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    assert 'og:url" content="https://me.example:8080/myindex.html/"' in page
    wrong = ["me.example/a", "ftp://me.example/", "https://", "https://[", "https://a b.c/"]
    wrong += ["https://a.b/?", "https://a.b/#", "https://a.b:99999/", "https://u:p@a.b/"]
    for url in wrong:
        assert main([*words, url]) == 2
        assert "is not the address of a site" in capsys.readouterr().err
    page = tmp_path / "page.html"
    assert (
        main(["export", str(scene), "--to", "html", "-o", str(page), "--url", "https://a.b"]) == 2
    )
    assert "leave out --url" in capsys.readouterr().err
    assert not page.exists()


def test_export_replaces_earlier_exports_but_no_other_folder(
    site: tuple[Path, str], scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, _ = site
    before = (folder / "sw.js").read_text("utf-8")
    words = ["export", str(scene), "--to", "site", "-o"]
    assert main([*words, str(folder), "--title", "other"]) == 0
    assert (folder / "sw.js").read_text("utf-8") != before  # browsers see a new version
    page = (folder / "index.html").read_text("utf-8")
    for word, file in (("src", "scene.mgs"), ("poster", "poster.jpg")):
        mark = hashlib.sha256((folder / file).read_bytes()).hexdigest()[:8]
        assert f'{word}="{file}?{mark}"' in page  # no cached file of an earlier version
    (folder / "sw.js").unlink()  # as if it had been interrupted
    (folder / "scene.txt").write_text("somebody's own")
    assert main([*words, str(folder)]) == 0
    assert (folder / "sw.js").exists()
    plain = tmp_path / "plain.ply"
    write_ply(plain, read_mgs(scene).decode().gaussians)
    assert main(["export", str(plain), "--to", "site", "-o", str(folder)]) == 0
    assert {path.name for path in folder.glob("scene.*")} == {"scene.ply", "scene.txt"}
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("precious")
    assert main([*words, str(mine)]) == 2
    assert "not from an export" in capsys.readouterr().err
    assert [path.name for path in mine.iterdir()] == ["thesis.txt"]


def test_scenes_that_the_viewer_does_not_support_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken.mgs").write_bytes(encode_mgs(make_scene(Case(20)))[:100])
    (tmp_path / "photo.jpg").write_bytes(b"x")
    for name, to, sentence in (
        ("broken.mgs", "html", "broken.mgs"),
        ("photo.jpg", "site", "not a scene"),
        ("gone.mgs", "html", "gone.mgs"),
    ):
        words = ["export", str(tmp_path / name), "--to", to, "-o", str(tmp_path / "out")]
        assert main(words) in (1, 2)
        assert sentence in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_what_a_first_visit_loads_takes_less_than_62_and_a_half_kb() -> None:
    files = ("index.html", "preload.js", "viewer.js", "worker.js", "wgsl.js")
    sizes = [len(gzip.compress((DIST / file).read_bytes(), 9, mtime=0)) for file in files]
    print(dict(zip(files, sizes, strict=True)))
    assert sum(sizes) < 62_500


def test_the_parts_of_the_viewer_are_those_that_it_names() -> None:
    named = set()
    for file in ("preload.js", *SCRIPTS):
        text = (DIST / file).read_text("utf-8")
        addresses = re.findall(r'import\("\./(\w+\.js)\?([0-9a-f]{16})"\)', text)
        assert text.count("import(") == len(addresses)
        assert all(version_of(script(part)) == version for part, version in addresses)
        named |= {part for part, _ in addresses}
    assert named == {*SCRIPTS} - {"viewer.js"}


@pytest.mark.thorough
def test_a_site_shows_other_formats_offline(chromium: Chromium, site: tuple[Path, str]) -> None:
    folder, address = site
    write_ply(folder / "plain.ply", read_mgs(folder / "scene.mgs").decode().gaussians)
    tab = chromium.tab(locale="de-DE")
    tab.page.goto(f"{address}?renderer=webgl")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    tab.page.wait_for_function("navigator.serviceWorker.controller")
    plain = base64.b64encode((folder / "plain.ply").read_bytes()).decode()
    tab.page.context.set_offline(True)
    tab.page.goto(f"{address}?renderer=webgl")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    count = tab.page.evaluate(
        """async (plain) => {
          const element = document.querySelector("mobile-gs");
          const loaded = new Promise((done) => element.addEventListener("load", done));
          element.open(new Blob([Uint8Array.from(atob(plain), (c) => c.charCodeAt(0))]));
          await loaded;
          return element.viewer.count;
        }""",
        plain,
    )
    assert count == 500
    assert tab.page.get_by_role("button", name="Einstellungen").is_visible()
    tab.page.get_by_role("button", name="Teilen").click()
    tab.page.get_by_text("Diese Adresse gilt nur auf diesem Gerät.").wait_for()
    assert tab.page.evaluate("fetch('extras.js').then((answer) => answer.ok)")
    tab.close()


@pytest.mark.parametrize("renderer", RENDERERS)
@pytest.mark.parametrize("kind", ["html", "site"])
def test_a_script_that_got_into_a_page_does_not_run(
    site: tuple[Path, str], scene: Path, tmp_path: Path, tab: Tab, kind: str, renderer: str
) -> None:
    folder, address = site
    page = folder / "index.html"
    if kind == "html":
        page = tmp_path / "page.html"
        address = page.as_uri()
        assert main(["export", str(scene), "--to", "html", "-o", str(page)]) == 0
    attack = (
        "<script>window.attacked = 1</script><img src=data:, onerror='window.attacked = 3'>"
        "<script src='https://evil.example/a.js'></script><base href='https://evil.example/'>"
        "<img src='https://evil.example/a.png'><a href='javascript:window.attacked = 4'>a</a>"
    )
    text = page.read_text("utf-8").replace("<title>", f"{attack}<title>")
    page.write_text(text.replace("<body>", f"<body>{attack}"), "utf-8")
    asked: list[str] = []
    tab.page.on("request", lambda request: asked.append(request.url))
    tab.page.goto(f"{address}?scale=1&variant=floats&renderer={renderer}")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    tab.page.evaluate("() => document.querySelector('a').click()")
    frames(tab, 3)
    name = tab.page.evaluate("document.querySelector('mobile-gs').viewer.device.renderer")
    assert name == ("WebGPU" if renderer == "webgpu" else "WebGL2")
    assert tab.page.evaluate("window.attacked") is None
    tab.ignore("404")  # of an icon: the picture ended the head
    blocked = [text for text in tab.complaints if "Content Security Policy" in text]
    assert len(blocked) >= 6
    tab.complaints = [text for text in tab.complaints if text not in blocked]


def test_a_link_decides_what_a_page_shows_only_where_its_maker_allows_it(
    site: tuple[Path, str], scene: Path, tab: Tab
) -> None:
    folder, address = site
    (folder / "other.mgs").write_bytes(encode_mgs(make_scene(Case(60, LobeShape(2, 12, (64,))))))
    link = f"{address}?renderer=webgl&url=other.mgs&heading=Pay&credit=me&poster=evil.jpg&noui"
    found = """() => {
      const element = document.querySelector("mobile-gs");
      const names = ["heading", "credit", "poster", "noui"];
      return [element.viewer.count, ...names.map((name) => element.getAttribute(name))];
    }"""
    tab.page.goto(f"{link}&compare=other.mgs")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    own = re.findall(r' poster="([^"]*)"', (folder / "index.html").read_text("utf-8"))
    assert tab.page.evaluate(found) == [500, "A <garden>", None, *own, ""]
    assert not tab.page.evaluate("document.querySelector('mobile-gs').hasAttribute('compare')")
    page = (folder / "index.html").read_text("utf-8")
    linked = page.replace("<mobile-gs ", "<mobile-gs linkable ")
    (folder / "linked.html").write_text(linked, encoding="utf-8")
    (folder / "evil.jpg").write_bytes((folder / "poster.jpg").read_bytes())
    tab.page.goto(link.replace("?", "linked.html?"))
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.evaluate(found) == [60, "Pay", "me", "evil.jpg", ""]


def test_texts_that_turn_or_hide_others_are_shown_as_numbers(scene: Path, tmp_path: Path) -> None:
    title = "\u202egpj.exe\u2066\x1b[2J \u05e9\u200f caf\xe9"
    words = ["export", str(scene), "--to", "site", "-o", str(tmp_path), "--title", title]
    assert main(words) == 0
    text = (tmp_path / "index.html").read_text("utf-8")
    seen = r"\u202egpj.exe\u2066\u001b[2J " + "\u05e9\u200f caf\xe9"
    assert f"<title>{seen}</title>" in text and f'heading="{seen}"' in text
    assert json.loads((tmp_path / "manifest.webmanifest").read_text("utf-8"))["name"] == seen


@pytest.mark.parametrize("file", ["mobile-gs.js", "preload.js"])
def test_a_script_can_stand_in_an_html_page(file: str) -> None:
    text = (DIST / file).read_text("utf-8")
    assert "</script" not in text and "<!--" not in text


def test_the_script_has_each_module_once_and_leaves_no_globals(tab: Tab, scene: Path) -> None:
    text = element_script()
    assert text.count("attachShadow") == 1
    tab.page.evaluate("() => (window.before = Object.getOwnPropertyNames(window))")
    tab.page.evaluate("() => (document.body.innerHTML = '<mobile-gs page></mobile-gs>')")
    tab.page.add_script_tag(content=text)  # not as a module, which has no globals anyway
    tab.page.wait_for_function("document.querySelector('mobile-gs').viewer", timeout=20_000)
    names = "() => Object.getOwnPropertyNames(window).filter((name) => !before.includes(name))"
    assert tab.page.evaluate(names) == ["before"]


def test_the_worker_starts_from_another_worker(tab: Tab, scene: Path) -> None:
    packed = re.findall('"(.*)"', script("worker.js"))[0]
    text = zlib.decompress(base64.b64decode(packed)).decode()
    outer = """onmessage = ({ data: { file, text } }) => {
      const url = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
      const inner = new Worker(url, { type: "module" });
      inner.onmessage = ({ data }) => postMessage(data.sentence ?? data.kind);
      inner.onerror = () => postMessage("error");
      inner.postMessage({ file });
    };"""
    code = """const url = URL.createObjectURL(new Blob([outer], { type: "text/javascript" }));
    const worker = new Worker(url);
    const kinds = [];
    return new Promise((resolve) => {
      worker.onmessage = ({ data }) => {
        kinds.push(data);
        if (!["dots", "scene", "rows", "progress"].includes(data)) resolve(kinds);
      };
      worker.postMessage({ file: new Blob([file]), text });
    });"""
    file = np.frombuffer(scene.read_bytes(), np.uint8)
    kinds = tab.run(code, outer=outer, text=text, file=file)
    assert kinds[-1] == "done" and {"dots", "scene"} <= set(kinds)


def test_the_element_works_in_another_page(site: tuple[Path, str], tab: Tab) -> None:
    folder, address = site
    (folder / "mine.html").write_text(
        '<!doctype html><meta charset="utf-8" /><link rel="icon" href="data:," />'
        '<script type="module" src="mobile-gs.js"></script>'
        '<mobile-gs src="scene.mgs" style="height: 200px"></mobile-gs>'
    )
    tab.page.goto(f"{address}mine.html")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"


@pytest.mark.thorough
def test_a_sandboxed_frame_without_an_origin_works(
    scene: Path, site: tuple[Path, str], tab: Tab
) -> None:
    folder, address = site
    assert main(["export", str(scene), "--to", "html", "-o", str(folder / "page.html")]) == 0
    for page in (address, f"{address}page.html"):
        tab.page.evaluate(
            """(src) => {
              document.body.innerHTML =
                `<iframe sandbox="allow-scripts" src="${src}" width=400 height=300></iframe>`;
            }""",
            f"{page}?scale=1&variant=floats",
        )
        frame = tab.page.frames[-1]
        frame.wait_for_load_state()
        assert frame.evaluate("self.origin") == "null"
        assert polled(frame, SETTLED, timeout=60_000).json_value() == "loaded"


def test_export_html_overwrites_only_exported_pages_and_has_a_largest_size(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "own.mgs"
    copy.write_bytes(scene.read_bytes())
    assert main(["export", str(copy), "--to", "html", "-o", str(copy)]) == 2
    assert "not an exported page" in capsys.readouterr().err
    assert copy.read_bytes() == scene.read_bytes()
    for _ in range(2):  # the second time over its own page
        assert main(["export", str(copy), "--to", "html", "-o", str(tmp_path / "a.html")]) == 0
    monkeypatch.setattr("mobilegs.view.export.HTML_MAX", 1000)
    assert main(["export", str(copy), "--to", "html", "-o", str(tmp_path / "b.html")]) == 2
    assert "use --to site" in capsys.readouterr().err


def test_the_title_is_the_name_of_the_capture(tmp_path: Path) -> None:
    scene = make_scene(Case(60, LobeShape(2, 12, (64,)), size=20))
    (tmp_path / "scene.mgs").write_bytes(encode_mgs(replace(scene, meta={"capture": "My <yard>"})))
    words = ["export", str(tmp_path / "scene.mgs"), "--to", "html", "-o", str(tmp_path / "a.html")]
    assert main(words) == 0
    assert "<title>My &lt;yard&gt;</title>" in (tmp_path / "a.html").read_text("utf-8")


def test_file_names_that_are_not_utf8_become_titles(scene: Path, tmp_path: Path) -> None:
    try:
        named = tmp_path / os.fsdecode(b"caf\xe9.mgs")
        named.write_bytes(scene.read_bytes())
    except (OSError, UnicodeError):
        pytest.skip("needs a file system that takes any bytes as a name")
    for to in ("html", "site"):
        assert main(["export", str(named), "--to", to, "-o", str(tmp_path / to)]) == 0
    for page in (tmp_path / "html", tmp_path / "site" / "index.html"):
        assert "<title>caf\ufffd</title>" in page.read_text(encoding="utf-8")
