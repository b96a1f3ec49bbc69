"""Failing devices and browsers: the viewer recovers or shows an error."""

import http.server
import threading
from typing import Any

import numpy as np
import pytest

from mobilegs.formats.ply import COLUMNS
from mobilegs.mgs.codec import decode_mgs
from tests.support.browser import Tab
from tests.support.viewer_page import (
    MGS,
    RENDERERS,
    SETTLED,
    frames,
    nearness,
    screen,
    seen,
    still,
    until,
    visit,
)

pytestmark = pytest.mark.thorough

REFUSED_GLSL = """const { getProgramParameter } = WebGL2RenderingContext.prototype;
WebGL2RenderingContext.prototype.getProgramParameter = function (program, what) {
  return what === this.LINK_STATUS ? false : getProgramParameter.call(this, program, what);
};"""
REFUSED_WGSL = """const { createShaderModule } = GPUDevice.prototype;
GPUDevice.prototype.createShaderModule = function (given) {
  return createShaderModule.call(this, { ...given, code: `${given.code} this is no shader` });
};"""
LOSABLE = """const { requestDevice } = GPUAdapter.prototype;
GPUAdapter.prototype.requestDevice = async function (...given) {
  const device = await requestDevice.apply(this, given);
  const lost = new Promise((resolve) => {
    window.lose = () => resolve({ reason: "unknown", message: "test" });
  });
  return Object.defineProperty(device, "lost", { value: lost });
};"""
DEVICE = "document.querySelector('mobile-gs').viewer.device.renderer"
TURN = """() => {
  const { viewer } = document.querySelector("mobile-gs");
  viewer.pose.orbit(0.5, 0.1);
  viewer.redraw();
}"""


def as_kernels(tab: Tab) -> float:
    scene = decode_mgs(MGS).decode()
    return nearness(tab, lambda camera: scene.render(camera).image)


@pytest.mark.parametrize(
    ("renderer", "broken", "sentence"),
    [
        ("webgl", REFUSED_GLSL, "this GPU refuses a shader"),
        ("webgpu", REFUSED_WGSL, "this GPU cannot draw the scene"),
        ("auto", f"{REFUSED_WGSL}{REFUSED_GLSL}", "this GPU refuses a shader"),
    ],
)
def test_refused_shaders_show_an_error(
    tab: Tab, served: Any, renderer: str, broken: str, sentence: str
) -> None:
    tab.ignore("")  # the browser complains, too, when it likes
    tab.page.add_init_script(f"{{{broken}}}")
    visit(tab, served("scene.mgs", MGS), f"renderer={renderer}")
    tab.page.get_by_role("alert").filter(has_text=sentence).wait_for(timeout=20_000)
    state = "document.querySelector('mobile-gs').dataset.state === 'failed'"
    tab.page.wait_for_function(state)


@pytest.mark.quick
def test_webgl_replaces_webgpu_if_shaders_are_refused(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(REFUSED_WGSL)
    visit(tab, served("scene.mgs", MGS))
    tab.page.wait_for_function(f"{DEVICE} === 'WebGL2'")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert as_kernels(tab) > 45
    tab.complaints.clear()


def test_webgl_replaces_a_lost_webgpu_device(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(LOSABLE)
    assert visit(tab, served("scene.mgs", MGS)) == "loaded"
    tab.page.evaluate(TURN)
    before, _ = seen(tab, 16, 16)
    # what cannot be opened leaves the scene, which is then the one to be drawn in another way
    tab.page.evaluate("document.querySelector('mobile-gs').open(new Blob(['no scene']))")
    tab.page.wait_for_function("document.querySelector('mobile-gs').dataset.state === 'failed'")
    tab.page.evaluate("window.lose()")
    tab.page.wait_for_function(f"{DEVICE} === 'WebGL2'")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert np.allclose(seen(tab, 16, 16)[0].viewmat, before.viewmat, atol=1e-6)
    assert as_kernels(tab) > 45
    assert [text for text in tab.complaints if "WebGL2 takes over" in text] == tab.complaints
    tab.complaints.clear()


def test_a_lost_device_shows_an_error_if_webgpu_is_required(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(LOSABLE)
    assert visit(tab, served("scene.mgs", MGS), "renderer=webgpu") == "loaded"
    tab.page.evaluate("window.lose()")
    alert = tab.page.get_by_role("alert")
    alert.wait_for(timeout=10_000)
    assert "the graphics device was lost" in alert.inner_text()
    tab.page.mouse.wheel(0, 100)
    frames(tab, 10)
    tab.page.evaluate(
        """() => {
          const element = document.querySelector("mobile-gs");
          const message = element.shadowRoot.querySelector(".message");
          const observer = new MutationObserver(() => (window.vanished ||= message.hidden));
          observer.observe(message, { attributes: true });
          element.open("/scene?again");
        }"""
    )
    tab.page.wait_for_function("window.vanished", timeout=20_000)  # if only for a moment
    alert.wait_for(timeout=10_000)  # another scene would not be seen either
    assert "the graphics device was lost" in alert.inner_text()


def test_a_restored_webgl_context_shows_the_scene_again(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS), "renderer=webgl")
    tab.page.evaluate(TURN)
    before = still(tab)
    tab.page.evaluate(
        """() => {
          const canvas = document.querySelector("mobile-gs").shadowRoot.querySelector("canvas");
          window.loss = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
          loss.loseContext();
        }"""
    )
    alert = tab.page.get_by_role("alert")
    alert.filter(has_text="the browser took the GPU away from this page").wait_for()
    tab.page.evaluate("loss.restoreContext()")
    tab.page.wait_for_function(f"({SETTLED})() === 'loaded'", timeout=60_000)
    until(tab, lambda: bool(np.abs(screen(tab).astype(int) - before).mean() < 2))
    tab.complaints.clear()  # the browser notes that the context was lost


@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_first_visit_stores_the_fastest_variant(tab: Tab, served: Any, renderer: str) -> None:
    server = served("scene.mgs", MGS)
    tab.page.goto(f"{server.address('127.0.0.1')}&renderer={renderer}")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.calibrated")
    assert as_kernels(tab) > 45
    kept = tab.page.evaluate("Object.keys(localStorage)")
    assert len(kept) == 1 and kept[0].startswith("mobilegs variant")


def test_an_impossible_benchmark_shows_an_error(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(
        """const { getParameter } = WebGL2RenderingContext.prototype;
        WebGL2RenderingContext.prototype.getParameter = function (what) {
          return what === this.MAX_TEXTURE_SIZE ? 4096 : getParameter.call(this, what);
        };"""
    )
    said = visit(tab, served("scene.mgs", MGS), "renderer=webgl", "bench=1,5000x400")
    alert = tab.page.get_by_role("alert")
    alert.filter(has_text="an image of 5000x400").wait_for(timeout=20_000)
    assert "cannot be measured" in alert.inner_text() or said


def test_the_report_is_copied_without_a_clipboard_api(tab: Tab, served: Any) -> None:
    tab.page.add_init_script("Object.defineProperty(navigator, 'clipboard', { value: undefined })")
    visit(tab, served("scene.mgs", MGS), "renderer=webgl", "bench=1,32x32")
    dialog = tab.page.get_by_role("dialog", name="Benchmark")
    dialog.wait_for(timeout=60_000)
    dialog.get_by_role("button", name="Copy").click()
    dialog.get_by_text("Copied.").wait_for(timeout=5000)
    text = tab.page.get_by_label("Results as JSON").input_value()
    area = "document.querySelector('mobile-gs').shadowRoot.querySelector('textarea')"
    assert tab.page.evaluate(f"[{area}.selectionStart, {area}.selectionEnd]") == [0, len(text)]


def test_open_works_right_after_the_element_is_created(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    found = tab.page.evaluate(
        """async () => {
          const scene = await (await fetch("/scene")).blob();
          const before = document.querySelector("mobile-gs");
          const element = document.createElement("mobile-gs");
          element.setAttribute("scale", "0.1");
          before.replaceWith(element);
          element.open(scene);
          const loaded = () => new Promise((done) => element.addEventListener("load", done));
          await loaded();
          const { viewer } = element;
          document.body.append(element.parentNode.removeChild(element)); // as frameworks do
          await new Promise(requestAnimationFrame);
          const kept = element.viewer === viewer;
          element.remove();
          await new Promise(requestAnimationFrame);
          const again = loaded();
          document.body.append(element);
          await again;
          return [kept, element.viewer.count];
        }"""
    )
    assert found == [True, 800]


def test_a_lazy_element_loads_when_it_is_nearly_visible(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    begun = tab.page.evaluate(
        """async () => {
          document.documentElement.style.height = "auto";
          document.body.style.height = `${5 * innerHeight}px`;
          const before = document.querySelector("mobile-gs");
          const element = document.createElement("mobile-gs");
          const pixel = "data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=";
          const wishes = { src: "/scene", loading: "lazy", poster: pixel, scale: "0.1",
            style: `position: absolute; inset: auto; top: ${3 * innerHeight}px; height: 99px` };
          for (const [name, value] of Object.entries(wishes)) element.setAttribute(name, value);
          before.replaceWith(element);
          // the element's own observer has had its first call when this one has
          await new Promise((done) => new IntersectionObserver(done).observe(element));
          await new Promise((done) => requestAnimationFrame(done));
          const early = element.viewer !== null || "state" in element.dataset;
          const poster = element.style.background.includes(pixel);
          const loaded = new Promise((done) => element.addEventListener("load", done));
          scrollTo(0, 1.5 * innerHeight); // half a screen is between them
          await loaded;
          return [early, poster, element.viewer.count];
        }"""
    )
    assert begun == [False, True, 800]


@pytest.mark.quick
def test_a_file_can_be_opened_by_keyboard(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.ply", b"no scene"))
    tab.page.keyboard.press("Escape")
    tab.page.get_by_role("button", name="Settings").click()
    with tab.page.expect_file_chooser() as chooser:
        tab.page.get_by_role("button", name="Open a file").click()
    chooser.value.set_files([{"name": "a.mgs", "mimeType": "", "buffer": MGS}])
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert as_kernels(tab) > 45


def test_a_device_lost_during_a_benchmark_gives_no_report(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(LOSABLE)
    visit(tab, served("scene.mgs", MGS), "bench=3,96x64")
    tab.page.evaluate(
        """() => {
          window.reported = window.refused = 0;
          addEventListener("report", () => reported++, true);
          const refuses = ({ detail }) => detail?.sentence.includes("cannot be measured");
          addEventListener("error", (event) => (refused += Number(refuses(event))), true);
        }"""
    )
    tab.page.evaluate("window.lose()")
    tab.page.wait_for_function(f"{DEVICE} === 'WebGL2'")
    tab.page.wait_for_function("refused === 1", timeout=20_000)
    frames(tab, 10)
    assert tab.page.evaluate("window.reported") == 0
    assert tab.page.get_by_role("dialog", name="Benchmark").is_hidden()
    tab.complaints.clear()


def test_nothing_else_renders_during_a_benchmark(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(
        """window.frames_seen = { true: 0, false: 0 };
        const note = ({ target }) => window.frames_seen[target.viewer.measured]++;
        addEventListener("frame", note, true);"""
    )
    visit(tab, served("scene.mgs", MGS), "renderer=webgl", "bench=2,96x64", "autorotate")
    tab.page.get_by_role("dialog", name="Benchmark").wait_for(timeout=60_000)
    assert tab.page.evaluate("window.frames_seen[true]") <= 1  # that was asked for before
    before = tab.page.evaluate("window.frames_seen[false]")
    tab.page.wait_for_function("(before) => window.frames_seen[false] > before + 1", arg=before)


class Cut(http.server.BaseHTTPRequestHandler):
    """Sends half of a scene, and half an hour later the other one."""

    shared = True

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Length", str(len(MGS)))
        if self.shared:
            self.send_header("Access-Control-Allow-Origin", "*")
        self.end_headers()
        self.wfile.write(MGS[: len(MGS) // 2])

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.mark.parametrize(
    ("shared", "sentence"), [(True, "broke off before its end"), (False, "(CORS)")]
)
def test_a_failing_host_shows_an_error(
    tab: Tab, monkeypatch: pytest.MonkeyPatch, shared: bool, sentence: str
) -> None:
    monkeypatch.setattr(Cut, "shared", shared)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Cut) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        scene = f"http://127.0.0.1:{other.server_port}/scene"
        tab.page.goto(f"{tab.address}/src/index.html?url={scene}")
        said = tab.page.wait_for_function(SETTLED, timeout=60_000).json_value()
        other.shutdown()
    assert sentence in said
    tab.complaints.clear()  # the browser itself notes what became of the request


def test_an_empty_scene_shows_an_error(tab: Tab, served: Any) -> None:
    for rows in (0, 3):
        lines = ["ply", "format binary_little_endian 1.0", f"element vertex {rows}"]
        lines += [f"property float {name}" for name in COLUMNS]
        header = "\n".join([*lines, "end_header", ""]).encode()
        content = header + np.full(rows * len(COLUMNS), np.nan, "<f4").tobytes()
        assert "no Gaussian" in visit(tab, served(f"{rows}.ply", content))
