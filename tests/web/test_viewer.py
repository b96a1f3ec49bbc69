"""The viewer's page in Chromium, served by `mobilegs view`."""

import base64
from pathlib import Path
from typing import Any

import pytest
import torch

from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render.scene import Scene
from tests.support.browser import Tab
from tests.support.golden import view_network
from tests.support.node import WEB
from tests.support.scene_cases import Case, make_scene
from tests.support.viewer_page import (
    MGS,
    RENDERERS,
    SETTLED,
    frames,
    nearness,
    pose_moved,
    screen,
    seen,
    visit,
)

PLY_NAMES = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3"
PLY_HEADER = "".join(
    [
        "ply\nformat binary_little_endian 1.0\nelement vertex 99\n",
        *(f"property float {name}\n" for name in PLY_NAMES.split()),
        "end_header\n",
    ]
).encode()


@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_scene_matches_the_python_renderer(tab: Tab, served: Any, renderer: str) -> None:
    assert visit(tab, served("scene.mgs", MGS), f"renderer={renderer}") == "loaded"
    camera, pixels = seen(tab, 160, 120)
    expected = decode_mgs(MGS).decode().render(camera).image
    assert expected.std() > 0.05
    decibels = psnr(pixels, expected)
    print(f"{renderer}: {decibels:.1f} dB")
    assert decibels > 45
    assert camera.near == pytest.approx(0.05)
    assert screen(tab).std() > 10
    # the first view is a training camera
    trained = decode_mgs(MGS).views[0]
    torch.testing.assert_close(camera.position, trained.position, rtol=1e-4, atol=1e-4)
    torch.testing.assert_close(camera.viewmat[2, :3], trained.viewmat[2, :3], rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_ply_is_rendered_sorted(tab: Tab, served: Any, renderer: str, tmp_path: Path) -> None:
    some = decode_mgs(MGS).decode().gaussians
    write_ply(tmp_path / "made.ply", some)
    content = (tmp_path / "made.ply").read_bytes()
    assert visit(tab, served("scene.ply", content), f"renderer={renderer}") == "loaded"
    scene = Scene(read_ply(tmp_path / "made.ply"))
    decibels = nearness(tab, lambda camera: scene.render(camera).image)
    print(f"{renderer}: {decibels:.1f} dB")
    assert decibels > 45


def with_view_network() -> QuantizedScene:
    """A scene that only WebGPU renders."""
    coded = make_scene(Case(300, network=True, size=300, layers=(100, 200)))
    coded.network = {name: value.half() for name, value in view_network().state_dict().items()}
    return coded


def test_messages_of_a_terminated_worker_do_not_hide_an_error(tab: Tab, served: Any) -> None:
    tab.page.add_init_script("Worker.prototype.terminate = () => {}")
    server = served("network.mgs", encode_mgs(with_view_network()))
    assert "takes WebGPU" in visit(tab, server, "renderer=webgl")
    tab.page.wait_for_timeout(500)
    assert "takes WebGPU" in tab.page.evaluate(SETTLED)


@pytest.mark.thorough
def test_a_scene_with_a_view_network_needs_webgpu(tab: Tab, served: Any) -> None:
    coded = with_view_network()
    assert visit(tab, served("network.mgs", encode_mgs(coded)), "renderer=webgpu") == "loaded"
    scene = coded.decode()
    decibels = nearness(tab, lambda camera: scene.render(camera).image)
    print(f"{decibels:.1f} dB")
    assert decibels > 45


def test_dragging_orbits_the_target(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    before, _ = seen(tab, 64, 48)
    target = torch.tensor(
        tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.target")
    )
    tab.page.mouse.move(200, 200)
    tab.page.mouse.down()
    tab.page.mouse.move(300, 220, steps=3)
    tab.page.mouse.up()
    after, _ = seen(tab, 64, 48)
    reach = [(camera.position - target).norm().item() for camera in (before, after)]
    assert reach[0] == pytest.approx(reach[1], rel=1e-3)
    assert (before.position - after.position).norm() > 0.2 * reach[0]
    middle = after.viewmat[:3, :3] @ (target - after.position)
    assert middle[:2].abs().max() < 1e-3 * middle[2]
    # where the hand rests on its way, the address names that place for a while
    named = """([x, y, z]) => {
      const eye = /eye=([^&]+)/.exec(location.hash)?.[1].split(",").map(Number);
      return eye && Math.hypot(eye[0] - x, eye[1] - y, eye[2] - z) < 1e-3;
    }"""
    tab.page.wait_for_function(named, arg=after.position.tolist(), timeout=5000)
    # the link shows the same to another visitor
    link = tab.page.url
    tab.page.goto("about:blank")
    tab.page.goto(link)
    tab.page.wait_for_function(SETTLED, timeout=60_000)
    eye = tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.eye")
    torch.testing.assert_close(torch.tensor(eye), after.position, rtol=1e-3, atol=1e-3)


def test_wheel_and_keys_move_the_camera(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    first, _ = seen(tab, 64, 48)
    tab.page.mouse.move(200, 200)
    tab.page.mouse.wheel(0, 500)
    second, _ = seen(tab, 64, 48)
    away = (second.position - first.position) @ first.viewmat[2, :3]
    assert away < 0  # the wheel towards the visitor goes away
    tab.page.focus("mobile-gs")
    tab.page.keyboard.press("h")
    assert tab.page.get_by_role("dialog").is_visible()
    tab.page.keyboard.press("Escape")
    assert not tab.page.get_by_role("dialog").is_visible()
    tab.page.keyboard.down("w")
    pose_moved(tab, second.position)
    tab.page.keyboard.up("w")
    third, _ = seen(tab, 64, 48)
    assert (third.position - second.position) @ second.viewmat[2, :3] > 0
    tab.page.keyboard.press("r")
    torch.testing.assert_close(seen(tab, 64, 48)[0].position, first.position)
    # a key that is released under Ctrl does not stick
    for key, act in (("w", "down"), ("Control", "down"), ("w", "up"), ("Control", "up")):
        getattr(tab.page.keyboard, act)(key)
    frames(tab, 5)
    rest, _ = seen(tab, 16, 16)
    frames(tab, 10)
    torch.testing.assert_close(seen(tab, 16, 16)[0].position, rest.position)


def test_a_malformed_file_shows_an_error(tab: Tab, served: Any, subtests: pytest.Subtests) -> None:
    cases = {
        "truncated": (MGS[: len(MGS) // 2], "cut off|ends|shorter|incomplete|truncated"),
        "damaged": (MGS[:200] + b"\x00" * 40 + MGS[240:], "damaged|checksum|broken"),
        "foreign": (b"hello" * 100, "not a"),
        "empty": (b"", "not a|empty|cut off|too short"),
        "ascii ply": (b"ply\nformat ascii 1.0\nend_header\n", "only binary_little_endian"),
        "truncated ply": (PLY_HEADER + b"\x00" * 100, "cut off: 99 Gaussians were announced"),
        "other ply": (PLY_HEADER.replace(b"float x", b"float w"), "it lacks x as floats"),
        "cut spz": ((WEB / "spz_v4.spz").read_bytes()[:-100], "cut off"),
    }
    visit(tab, served("scene.mgs", b"nothing"))
    alert = tab.page.get_by_role("alert")
    for name, (content, sentence) in cases.items():
        with subtests.test(name):
            said = tab.page.evaluate(
                """(text) => new Promise((done) => {
                  const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
                  const element = document.querySelector("mobile-gs");
                  const told = ({ detail }) => done(detail.sentence);
                  element.addEventListener("error", told, { once: true });
                  element.open(new Blob([bytes]));
                })""",
                base64.b64encode(content).decode(),
            )
            print(said)
            assert any(part in said for part in sentence.split("|")) and len(said) < 200
            assert said in alert.inner_text()


def test_a_browser_without_webgpu_and_webgl_shows_an_error(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(
        "Object.defineProperty(navigator, 'gpu', { get: () => undefined });"
        "HTMLCanvasElement.prototype.getContext = () => null;"
        "delete Navigator.prototype.gpu;"
    )
    said = visit(tab, served("scene.mgs", MGS))
    assert "cannot draw the scene" in said


@pytest.mark.parametrize("file", ["worker.js", "wgsl.js"])
def test_missing_files_of_the_viewer_show_an_error(tab: Tab, served: Any, file: str) -> None:
    tab.page.route(f"**/{file}?*", lambda route: route.fulfill(status=404))
    said = visit(tab, served("scene.mgs", MGS), "renderer=webgpu")
    assert "own files could not be loaded" in said
    tab.ignore("status of 404")


def test_a_bad_file_keeps_the_shown_scene(tab: Tab, served: Any, tmp_path: Path) -> None:
    write_ply(tmp_path / "made.ply", decode_mgs(MGS).decode().gaussians)
    visit(tab, served("scene.ply", (tmp_path / "made.ply").read_bytes()))
    tab.page.evaluate(
        """() => document.querySelector("mobile-gs").open(new Blob(["no scene at all"]))"""
    )
    tab.page.wait_for_function("document.querySelector('mobile-gs').dataset.state === 'failed'")
    tab.page.keyboard.press("Escape")
    assert tab.page.evaluate(SETTLED.replace("loaded", "failed")) == "failed"  # no message is left
    tab.page.evaluate("() => document.querySelector('mobile-gs').viewer.pose.orbit(3, 0)")
    tab.page.evaluate("() => document.querySelector('mobile-gs').viewer.redraw()")
    scene = Scene(read_ply(tmp_path / "made.ply"))
    assert nearness(tab, lambda camera: scene.render(camera).image) > 45  # in the new order


def test_a_malformed_address_shows_an_error(tab: Tab, served: Any) -> None:
    server = served("scene.mgs", MGS)
    tab.page.goto(server.address("127.0.0.1").replace("url=/scene", "url=http://[&scale=1"))
    said = tab.page.wait_for_function(SETTLED, timeout=60_000).json_value()
    assert "cannot be opened" in said
