"""The window, on a canvas without a display."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.cli.main import main
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.formats.ply import write_ply
from mobilegs.progress_display import printed_log
from mobilegs.up import AXES
from mobilegs.view import window as windows
from mobilegs.view.wgpu_renderer import WgpuRenderer
from tests.support.golden import as_scene
from tests.support.gpus import GPU
from tests.support.scenes import as_float32, random_scene
from tests.support.window import event, ring

LEVELS = 1.0  # of 255: the GPU and the test round differently


@pytest.fixture
def opened(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> Any:
    """Open windows without a display, in an empty working folder."""
    from rendercanvas.offscreen import RenderCanvas

    monkeypatch.chdir(tmp_path)
    made: list[windows.Window] = []

    def open_window(kind: str = "mobile_gs", *, density: float = 1.0, views: bool = True) -> Any:
        scene = as_scene(as_float32(random_scene(300, seed=2)), kind)
        canvas = RenderCanvas(size=(90, 60), pixel_ratio=density)
        made.append(windows.Window(canvas, WgpuRenderer(scene), ring() if views else [], "garden"))
        return made[-1]

    yield open_window
    for window in made:
        window.close()
    # rendercanvas catches and logs errors in handlers and frames
    assert not [record for record in caplog.records if record.name == "rendercanvas"]


def act(window: windows.Window, *events: dict) -> None:
    """Send events, as a toolkit does."""
    for one in events:
        window.canvas.submit_event(one)
    window.canvas._process_events()


def press(window: windows.Window, key: str, *modifiers: str) -> None:
    act(window, event("key_down", key=key, modifiers=modifiers), event("key_up", key=key))


def shown(window: windows.Window) -> np.ndarray:
    """Return the image on the canvas, RGB in 0 to 255."""
    return window.canvas.draw()[..., :3].astype(np.float64)


def expected(window: windows.Window) -> np.ndarray:
    """Return the image of the renderer for the window's pose."""
    seen = window.camera(*window.canvas.get_physical_size())
    return to_bytes(window._renderer.render(seen).image).numpy().astype(np.float64)


@GPU
@pytest.mark.parametrize(("kind", "density"), [("mobile_gs", 1.0), ("sorted", 2.0)])
def test_a_window_shows_the_renderers_image(opened: Any, kind: str, density: float) -> None:
    window = opened(kind, density=density)
    first = shown(window)
    assert first.shape == (60 * density, 90 * density, 3) and first.std() > 5
    assert np.abs(first - expected(window)).max() <= LEVELS
    window.canvas.set_logical_size(50, 70)
    assert np.abs(shown(window) - expected(window)).max() <= LEVELS
    assert shown(window).shape == (70 * density, 50 * density, 3)


@GPU
def test_the_first_view_is_a_training_camera_and_v_shows_the_next(opened: Any) -> None:
    window, views = opened(), ring()
    for index in (0, 1, 2, 3, 4, 0):
        if index or window._view:
            press(window, "v")
        seen = window.camera(80, 60)
        torch.testing.assert_close(seen.position, views[index].position, atol=1e-5, rtol=1e-5)
        forward = views[index].viewmat[2, :3]
        torch.testing.assert_close(seen.viewmat[2, :3], forward, atol=1e-5, rtol=1e-5)
    assert float(seen.K[0, 0]) == pytest.approx((90 * 80) ** 0.5)


@GPU
def test_u_turns_one_axis_after_the_other_upwards(opened: Any) -> None:
    window = opened()
    own = window.input.pose.up
    for name in list(AXES)[1:]:  # -y is the scene's own
        press(window, "u")
        np.testing.assert_array_equal(window.input.pose.up, AXES[name])
        assert -window.camera(80, 60).viewmat[1, :3].numpy() @ AXES[name] > 0.9
        press(window, "v")
        np.testing.assert_array_equal(window.input.pose.up, AXES[name])
    press(window, "u")
    np.testing.assert_array_equal(window.input.pose.up, own)


def drag(window: windows.Window, dx: float, dy: float, *, button: int = 1, **more: Any) -> None:
    buttons = (button,)
    act(
        window,
        event("pointer_down", x=10.0, y=10.0, button=button, buttons=buttons, **more),
        event("pointer_move", x=10.0 + dx, y=10.0 + dy, buttons=buttons, **more),
        event("pointer_up", x=10.0 + dx, y=10.0 + dy, button=button, **more),
        event("pointer_move", x=70.0, y=50.0),  # no button is down any more
    )


@GPU
def test_dragging_turns_and_pans_and_the_wheel_zooms(opened: Any) -> None:
    window = opened()
    pose = window.input.pose
    start, reach = pose.copy(), np.linalg.norm(pose.eye - pose.target)
    drag(window, 50, 5)
    assert np.linalg.norm(pose.eye - pose.target) == pytest.approx(reach)
    assert np.linalg.norm(pose.eye - start.eye) > 0.2 * reach
    np.testing.assert_array_equal(pose.target, start.target)
    assert (pose.eye - start.eye) @ start.right < 0  # the scene follows the pointer
    press(window, "r")
    pose = window.input.pose
    np.testing.assert_allclose(pose.eye, start.eye)
    options: list[dict[str, Any]] = [{"button": 2}, {"modifiers": ("Shift",)}]
    for more in options:
        before = pose.copy()
        drag(window, 30, 0, **more)
        step = pose.eye - before.eye
        np.testing.assert_allclose(step, -0.5 * reach * before.right, atol=1e-9)
        np.testing.assert_allclose(pose.target - before.target, step)
    act(window, event("wheel", dx=0.0, dy=100.0, x=5.0, y=5.0))
    away = np.linalg.norm(pose.eye - pose.target)
    assert away == pytest.approx(reach * np.exp(0.12))
    press(window, "m")
    before = pose.copy()
    drag(window, 50, 5)
    np.testing.assert_array_equal(pose.eye, before.eye)
    assert np.abs(shown(window) - expected(window)).max() <= LEVELS


@GPU
def test_a_double_click_sets_the_target(opened: Any) -> None:
    window = opened()
    seen = window.camera(90, 60)
    place = seen.viewmat.double().numpy() @ [*window._solid[7], 1]
    x, y, w = seen.K.double().numpy() @ place[:3]
    at = {"x": x / w, "y": y / w, "button": 1, "buttons": (1,)}
    before = window.input.pose.copy()
    act(window, event("pointer_down", **at, time_stamp=10.0), event("pointer_up", x=0, y=0))
    np.testing.assert_array_equal(window.input.pose.target, before.target)
    act(window, event("pointer_down", **at, time_stamp=10.2))
    target = window.input.pose.target
    assert (np.abs(window._solid - target).max(1) == 0).any()
    np.testing.assert_array_equal(window.input.pose.eye, before.eye)


@GPU
def test_a_sorted_scene_is_sorted_again_after_a_turn(opened: Any) -> None:
    window = opened("sorted")
    shown(window)
    window.input.pose.orbit(3.0, 0.0)
    stale = shown(window)  # still in the earlier order
    assert window._next_order is not None
    window._next_order.result()
    exact = shown(window)
    assert np.abs(exact - expected(window)).max() <= LEVELS
    assert np.abs(stale - exact).max() > 10
    window.input.pose.orbit(0.005, 0.0)
    shown(window)
    assert window._next_order is None  # no new order for a small turn


@GPU
def test_a_held_key_moves_in_every_frame(opened: Any) -> None:
    window = opened()
    act(window, event("key_down", key="s"))
    shown(window)
    before = window.input.pose.eye
    shown(window)
    assert (window.input.pose.eye - before) @ window.input.pose.forward < 0
    act(window, event("key_up", key="s"))
    before = window.input.pose.eye
    shown(window)
    np.testing.assert_array_equal(window.input.pose.eye, before)


@GPU
def test_keys_save_an_image_show_times_and_close(
    opened: Any, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    window = opened(density=2.0, views=False)
    titles: list[str] = []
    monkeypatch.setattr(window.canvas, "set_title", titles.append)
    image = shown(window)
    with printed_log():
        press(window, "p")
        press(window, "p")
    said = capsys.readouterr().out
    assert "saved garden.png" in said and "saved garden-2.png" in said
    for name in ("garden.png", "garden-2.png"):
        with Image.open(name) as saved:
            assert np.abs(np.array(saved, np.float64) - image).max() <= LEVELS
    press(window, "i")
    shown(window)
    assert "180 x 120" in titles[-1]
    press(window, "I")
    assert titles[-1] == "garden: 300 Gaussians"
    with printed_log():
        press(window, "h")
    assert "full screen" in capsys.readouterr().out
    press(window, "f")  # without a screen, no effect
    press(window, "q", "Shift")
    press(window, "r", "Control")
    assert not window.canvas.get_closed()
    press(window, "Escape")
    assert window.canvas.get_closed()
    other = opened()
    press(other, "q", "Control")
    assert other.canvas.get_closed()


@GPU
def test_a_lost_gpu_closes_the_window_with_a_sentence(opened: Any) -> None:
    window = opened()
    window._renderer.program.device.destroy()
    window.canvas.draw()
    assert window.canvas.get_closed()
    assert isinstance(window.failure, InputError) and "Parent device is lost" in str(window.failure)


def refusal(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert main([str(word) for word in words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


def test_without_the_packages_the_error_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "glfw", None)
    (tmp_path / "scene.mgs").touch()
    said = refusal(capsys, "view", tmp_path / "scene.mgs", "--native")
    assert "pip install 'mobilegs[native]'" in said


@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_without_a_display_the_error_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("glfw", reason="needs the extra native")
    (tmp_path / "scene.mgs").touch()
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "XDG_SESSION_TYPE"):
        monkeypatch.delenv(name, raising=False)
    assert "without a display" in refusal(capsys, "view", tmp_path / "scene.mgs", "--native")


def test_a_window_has_no_server_options(capsys: pytest.CaptureFixture[str]) -> None:
    said = refusal(capsys, "view", "scene.mgs", "--native", "--lan")
    assert "leave out --lan" in said


@pytest.fixture
def toolkit(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A toolkit without a display, whose windows render once and close."""
    from rendercanvas import offscreen

    class Loop:
        user: Callable[[], None] = staticmethod(lambda: None)

        def run(self) -> None:
            self.user()

    class Toolkit:
        loop = Loop()
        canvases: list[Any] = []  # noqa: RUF012

        def RenderCanvas(self, **options: Any) -> Any:
            self.canvases.append(offscreen.RenderCanvas(size=options["size"]))
            return self.canvases[-1]

    made = Toolkit()
    made.canvases = []
    monkeypatch.setattr(windows, "_toolkit", lambda: made)
    return made


@GPU
def test_view_opens_a_ply_in_a_window(
    toolkit: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = as_scene(as_float32(random_scene(80, seed=5)), "sorted")
    write_ply(tmp_path / "made.ply", scene.gaussians)
    images: list[np.ndarray] = []
    toolkit.loop.user = lambda: images.append(toolkit.canvases[0].draw())
    assert main(["view", str(tmp_path / "made.ply"), "--native"]) == 0
    said = capsys.readouterr().out
    assert "made.ply is open in a window" in said
    assert "up is -y, as usual: the file does not say (the key U or --up changes it)" in said
    assert images[0].shape == (720, 1280, 4) and images[0][..., :3].std() > 5
    assert toolkit.canvases[0].get_closed()


@GPU
def test_an_error_in_a_frame_or_a_key_ends_view_with_a_sentence(
    toolkit: Any,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = as_scene(as_float32(random_scene(80, seed=5)), "sorted")
    write_ply(tmp_path / "made.ply", scene.gaussians)

    def fails(*_: object, **__: object) -> None:
        raise InputError("the GPU made up failed: use another")

    def press_u() -> None:
        toolkit.canvases[-1].submit_event(event("key_down", key="u"))
        toolkit.canvases[-1]._process_events()

    acts = {
        (WgpuRenderer, "render_into"): lambda: toolkit.canvases[-1].draw(),
        (windows.Window, "turn_up"): press_u,
    }
    for (owner, name), act in acts.items():
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, fails)
            toolkit.loop.user = act
            assert "made up failed" in refusal(capsys, "view", tmp_path / "made.ply", "--native")
        assert toolkit.canvases[-1].get_closed()


def test_a_file_that_is_not_a_scene_opens_no_window(
    toolkit: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "scene.obj").touch()
    for name, sentence in (
        ("gone.mgs", "gone.mgs does not exist"),
        ("scene.obj", "a .mgs, .ply, .spz"),
    ):
        assert sentence in refusal(capsys, "view", tmp_path / name, "--native")
    assert not toolkit.canvases
