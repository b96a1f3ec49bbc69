"""The viewer's WebGL2 and WebGPU renderers against the reference."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.evaluate.fragments import fragments_per_pixel
from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply
from mobilegs.mgs.codec import encode_mgs, read_mgs
from mobilegs.render.scene import Scene
from mobilegs.render.supersampling import magnified, supersampling_for
from mobilegs.representation.lobes import LobeShape
from tests.support.browser import Chromium, Tab
from tests.support.golden import (
    BACKGROUND,
    BASE,
    RENDERERS,
    TRAINED,
    as_scene,
    golden_cases,
    input_names,
    inputs_of,
    render_reference,
    settings_of,
    trained,
    turned_around,
    view_network,
)
from tests.support.page_renderers import KINDS, Painter, Painters, in_javascript
from tests.support.scene_cases import Case, make_scene
from tests.support.scenes import (
    as_float32,
    camera,
    camera_from_json,
    near_threshold,
    random_scene,
)
from tests.support.selection import few


@cache
def sure(case: str, renderer: str) -> torch.Tensor:
    """The pixels of a case where no rounding decides what is drawn."""
    inputs, view = inputs_of(case)
    names, settings = input_names(renderer), settings_of(renderer)
    return ~near_threshold(inputs, view, names=names, margin=1e-4, settings=settings)


definition = cache(render_reference)


def decibels(found: torch.Tensor, reference: torch.Tensor) -> float:
    error = found.double() - reference.double()
    return -10 * torch.log10(error.square().mean().clamp_min(1e-30)).item()


@pytest.mark.parametrize("kind", KINDS)
def test_the_renderers_match_the_reference(
    kind: str, painters: Painters, subtests: pytest.Subtests
) -> None:
    painter = painters(kind, full_precision=True)
    for renderer in RENDERERS:
        sigma = settings_of(renderer).level_sigma
        for case in golden_cases(renderer):
            inputs, view = inputs_of(case)
            drawn = painter.paint(view, as_scene(inputs, renderer), level_sigma=sigma)
            reference, keep = definition(case, renderer), sure(case, renderer)
            for name in ("image", "alpha"):
                with subtests.test(renderer=renderer, case=case, output=name):
                    assert getattr(drawn, name).isfinite().all()
                    found = decibels(getattr(drawn, name)[keep], getattr(reference, name)[keep])
                    print(f"{found:.1f} dB")
                    assert found >= 75


@pytest.mark.parametrize(("renderer", "level_sigma"), [("sorted", 0.0), ("mobile_gs", 1.0)])
@pytest.mark.parametrize("kind", KINDS)
def test_small_images_are_means_of_larger_ones(
    kind: str, renderer: str, level_sigma: float, painters: Painters
) -> None:
    scene = as_scene(random_scene(500, seed=5, spread=1.5), renderer)
    view = camera(53, 31).to(dtype=torch.float32)
    options = {"level_sigma": level_sigma, "supersampling": 3}
    found = painters(kind, full_precision=True).paint(view, scene, **options)
    expected = scene.render(view, **options)
    for name in ("image", "alpha"):
        value = decibels(getattr(found, name), getattr(expected, name))
        print(f"{name} {value:.1f} dB")
        assert value >= 75, name


def test_the_page_renders_small_pictures_as_large_as_python_does(painters: Painters) -> None:
    tab = painters("webgpu", full_precision=False).tab
    code = """
    const { supersamplingFor } = await import("/src/viewer/supersampling.js");
    return cameras.map((camera) => supersamplingFor(camera, [view]));
    """
    trained = camera(100, 100)
    cameras = [trained.resized(size, size) for size in (200, 75, 60, 50, 33, 25, 5)]
    cameras += [replace(cameras[-2], width=1500), replace(cameras[-2], width=5000)]
    view = {"K": trained.K.flatten().tolist(), "width": 100, "height": 100}
    found = tab.run(code, cameras=[in_javascript(one) for one in cameras], view=view)
    assert list(found) == [supersampling_for(one, [trained]) for one in cameras]
    assert len(set(found)) == 4


@pytest.mark.parametrize("kind", KINDS)
def test_float16_is_precise_enough_in_sorted_scenes(kind: str, painters: Painters) -> None:
    scene = as_scene(random_scene(20_000, seed=3, spread=1.5), "sorted")
    scene.gaussians.log_scales -= 1.5
    view = camera(320, 213).to(dtype=torch.float32)
    drawn = painters(kind, full_precision=False).paint(view, scene).image
    found = psnr(drawn, scene.render(view).image)
    print(f"{found:.1f} dB")
    assert found >= 50


WITHOUT_FILTERS = """
const { prototype } = WebGL2RenderingContext;
const { getExtension } = prototype;
prototype.getExtension = function (name) {
  return name === "OES_texture_float_linear" ? null : getExtension.call(this, name);
};
window.restore = () => (prototype.getExtension = getExtension);
"""


def test_a_depth_pass_is_drawn_where_only_float16_can_be_filtered(painters: Painters) -> None:
    painter = painters("webgl", full_precision=False)
    scene = as_scene(as_float32(random_scene(2000, seed=7, spread=1.5, size=0.3)), "depth_pass")
    far = replace(scene.weighting, sigma=0.2)  # far from the scene's depths, so that float16 shows
    scene = replace(scene, weighting=far)
    sizes = [(131, 67), (131, 68)]  # for each the picture is made again
    views = [camera(*size).to(dtype=torch.float32) for size in sizes]
    expected = [scene.render(view).image for view in views]
    full = psnr(painter.paint(views[0], scene).image, expected[0])
    painter.tab.run(WITHOUT_FILTERS)
    half = psnr(painter.paint(views[1]).image, expected[1])
    painter.tab.run("restore();")
    print(f"{full:.1f} dB, {half:.1f} dB")
    assert full - 5 > half > 40


OPEN_MGS = """
const { SceneReader } = await import("/src/mgs/reader.js");
const { GaussianDecoder } = await import("/src/mgs/gaussian_decoder.js");
const { emptyScene, packRows } = await import("/src/render/pack.js");
const reader = new SceneReader();
reader.append(bytes);
while (reader.step());
const { header } = reader;
const decoder = new GaussianDecoder(reader.decoder.decoderInputs);
const [codes] = reader.decoder.levels;
// room for more, of which nothing is to be seen
const { network } = reader.decoder;
renderer.setScene(emptyScene(header, header.count + 5000, decoder.scaleRange, network));
renderer.show(header.count);
for (const [from, to] of [[0, 1], [1, 150], [150, header.count]]) {
  const packed = packRows(decoder, codes.rows(from, to));
  for (const part of ["shapes", "colors", "lobes"]) renderer.update(part, from, packed[part]);
}
const { shapes, colors, lobes } = emptyScene(header, header.count, decoder.scaleRange, network);
window.bytesEach = [shapes, colors, lobes].reduce((sum, part) => sum + part.byteLength, 0);
return renderer.pixels(camera);
"""
SHAPES = {
    "without lobes": None,
    "degree 0": LobeShape(0, 2, (5,)),
    "degree 1": LobeShape(1, 6),
    "degree 2": LobeShape(2, 12, (64,)),
    "degree 3": LobeShape(3, 4),
}


def opened(
    painter: Painter, data: bytes, view: Camera, *, floats: bool, strips: bool, sigma: float = 0.0
) -> torch.Tensor:
    """Return the image of a file that the page decodes and packs in pieces."""
    variant = {"floats": floats, "strips": strips}
    show = "renderer.variant = variant; renderer.levelSigma = sigma;"
    painter.tab.run(show, variant=variant, sigma=sigma)
    bytes_ = np.frombuffer(data, np.uint8)
    found = painter.tab.run(OPEN_MGS, bytes=bytes_, camera=in_javascript(view))
    painter.tab.run(show, variant={"floats": True, "strips": False}, sigma=0)
    return as_image(found, view)


def as_image(pixels: np.ndarray, view: Camera) -> torch.Tensor:
    """Return the colours of RGBA pixels, `[h, w, 3]`."""
    return torch.from_numpy(pixels.reshape(view.height, view.width, 4)[..., :3].copy())


@pytest.mark.parametrize("name", few(SHAPES, "degree 2"))
@pytest.mark.parametrize("kind", KINDS)
def test_a_packed_scene_matches_its_file(kind: str, name: str, painters: Painters) -> None:
    painter = painters(kind, full_precision=True)
    view = camera(160, 120).to(dtype=torch.float32)
    coded = make_scene(Case(1200, SHAPES[name], exponent=4, spread=0.2))
    expected = coded.decode().render(view).image
    assert expected.std() > 0.05
    i = list(SHAPES).index(name)
    variant = {"floats": i % 2 == 0, "strips": i % 4 in (1, 2)}
    found = psnr(opened(painter, encode_mgs(coded), view, **variant), expected)
    print(f"{variant}: {found:.1f} dB")
    assert found >= 50
    each = painter.tab.run("return bytesEach;") / len(coded)
    assert each + 8 < 64 or name == "degree 3"  # and 8 for what it looks like


@pytest.mark.parametrize("kind", KINDS)
def test_a_packed_trained_scene_matches_its_file(
    kind: str, painters: Painters, subtests: pytest.Subtests
) -> None:
    painter, data = painters(kind, full_precision=True), TRAINED.read_bytes()
    scene = read_mgs(TRAINED)
    view, scene = scene.views[0].resized(240, 160), scene.decode()
    plain = scene.render(view).image
    leveled = scene.render(view, level_sigma=0.6).image
    for floats, strips, sigma in ((False, False, 0.0), (True, True, 0.6), (False, False, 0.6)):
        with subtests.test(floats=floats, strips=strips, sigma=sigma):
            drawn = opened(painter, data, view, floats=floats, strips=strips, sigma=sigma)
            found, without = psnr(drawn, leveled if sigma else plain), psnr(drawn, plain)
            print(f"{found:.1f} dB, without levels {without:.1f} dB")
            assert found >= 55 and (not sigma or without < found - 3)


@pytest.mark.thorough
def test_a_view_network_is_evaluated_in_each_frame(painters: Painters) -> None:
    coded = make_scene(Case(1200, network=True, exponent=4, spread=0.2))
    coded.network = {name: value.half() for name, value in view_network().state_dict().items()}
    painter = painters("webgpu", full_precision=True)
    scene, view = coded.decode(), camera(160, 120).to(dtype=torch.float32)
    constant = replace(scene, network=None).render(view).image
    assert psnr(constant, scene.render(view).image) < 30
    opened(painter, encode_mgs(coded), view, floats=True, strips=False)
    for angle in (0.0, 0.6, 2.2):
        turned = turned_around(view, angle)
        drawn = painter.tab.run("return renderer.pixels(camera);", camera=in_javascript(turned))
        found = psnr(as_image(drawn, view), scene.render(turned).image)
        print(f"{found:.1f} dB")
        assert found >= 50
    times = painter.tab.run("await renderer.time(); return renderer.milliseconds;")
    assert times is None or set(times) == {"network", "project", "splat", "resolve"}


@pytest.mark.parametrize(
    ("renderer", "level_sigma", "supersampling"),
    [("sorted", 1.0, 1), ("mobile_gs", 0.0, 2), ("all", 1.0, 1)],
)
@pytest.mark.parametrize("kind", KINDS)
def test_fragments_are_counted_as_eval_counts_them(
    kind: str, renderer: str, level_sigma: float, supersampling: int, painters: Painters
) -> None:
    scene = as_scene(random_scene(2000, seed=21, size=0.8), renderer)
    view = camera(200, 160).to(dtype=torch.float32)
    painter = painters(kind, full_precision=True)
    options = {"level_sigma": level_sigma, "supersampling": supersampling}
    painter.paint(view, scene, **options)
    found = np.array(painter.tab.run("return renderer.fragments();"))
    fine = magnified(view, supersampling)
    expected = np.array(fragments_per_pixel(scene, fine, level_sigma=level_sigma))
    assert len(found) == len(expected) == (4 if level_sigma and renderer != "sorted" else 1)
    np.testing.assert_allclose(found, supersampling**2 * expected, rtol=0.01)
    assert (expected > 0.03).all()


def test_the_variant_that_draws_fastest_is_chosen(tab: Tab) -> None:
    code = """
    const { fastestVariant } = await import("/src/render/calibrate.js");
    let size = 0;
    const made = {
      variants: [false, true].flatMap((floats) =>
        [false, true].map((strips) => ({ floats, strips }))),
      variant: {},
      setScene: ({ count }) => (size = count === 128 ? 0 : count),
      drawUnseen({ width }) {
        const { floats, strips } = this.variant;
        const cost = size ? size * (strips ? 0.002 : 0.02) : width * (floats ? 0.2 : 0.1);
        return new Promise((done) => setTimeout(done, 2 + cost));
      },
      describe: () => "made up",
    };
    return fastestVariant(made, null);
    """
    assert tab.run(code) == {"floats": False, "strips": True}


@pytest.mark.parametrize("name", ["student", "teacher"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_trained_scene_matches_the_reference(
    kind: str, name: str, painters: Painters, request: pytest.FixtureRequest
) -> None:
    if name == "student":
        scene, view = trained()
    else:
        splats: Path = request.getfixturevalue("data_dir") / "splats"
        scene = Scene(read_ply(splats / "playbot_125k_sh3pad.ply"), background=BACKGROUND)
        row = json.loads((splats / "playbot_cameras.json").read_text())[3]
        view = camera_from_json(row).resized(480, 270)
    reference = scene.render(view)
    assert reference.alpha.mean() > 0.1
    for full_precision, least in ((True, 75), (False, 50)):
        drawn = painters(kind, full_precision=full_precision).paint(view, scene)
        found = psnr(drawn.image, reference.image)
        print(f"{'floats' if full_precision else 'halves'} {found:.1f} dB")
        assert found >= least


@pytest.mark.parametrize("kind", KINDS)
def test_huge_gaussians_near_the_camera_give_finite_pixels(
    kind: str, painters: Painters, generator: torch.Generator
) -> None:
    inputs = random_scene(3000, seed=4)
    view = camera(160, 120).to(dtype=torch.float32)
    offsets = torch.randn(60, 3, generator=generator, dtype=torch.float64)
    inputs["means"][::50] = view.position.double() + 0.3 * offsets
    painter = painters(kind, full_precision=False)
    for size in (40.0, 1e6):
        inputs["scales"][::50] = size
        scene = as_scene(inputs, "mobile_gs")
        scene.weighting = replace(scene.weighting, exponent_max=8.0)
        drawn = painter.paint(view, scene)
        assert drawn.image.isfinite().all() and drawn.alpha.isfinite().all()
        if size < 1e6:  # beyond, the covariance itself overflows
            found = psnr(drawn.image.clamp(0, 1), scene.render(view).image.clamp(0, 1))
            print(f"{found:.1f} dB")
            assert found > 45


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_scene_can_be_drawn_at_another_size_and_be_updated(
    kind: str, renderer: str, painters: Painters
) -> None:
    painter = painters(kind, full_precision=True)
    view = camera().to(dtype=torch.float32)
    first = painter.paint(view, as_scene(as_float32(random_scene(3000, seed=2)), renderer))
    assert painter.paint(view.resized(20, 16)).image.shape == (16, 20, 3)
    # in any order, sums differ by a rounding
    tolerance = {"rtol": 0, "atol": 0 if renderer == "sorted" or kind == "webgl" else 2e-6}
    torch.testing.assert_close(painter.paint(view), first, **tolerance)
    code = """
    const parts = ["shapes", "colors", "lobes"];
    const hidden = parts.map((part) => [part, scene[part].slice().fill(-9)]);
    renderer.setScene({ ...scene, ...Object.fromEntries(hidden) });
    for (const part of parts) {
      const stride = scene[part].length / scene.count;
      for (const [from, to] of [[0, 1], [1, 1000], [1000, 2800], [2800, scene.count]]) {
        renderer.update(part, from, scene[part].subarray(stride * from, stride * to));
      }
    }
    """
    painter.tab.run(code)
    torch.testing.assert_close(painter.paint(view), first, rtol=0, atol=2e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_canvas_is_not_flipped(kind: str, painters: Painters) -> None:
    painter = painters(kind, full_precision=False)
    view = camera().to(dtype=torch.float32)
    expected = painter.paint(view, as_scene(as_float32(BASE), "mobile_gs")).image
    code = """
    renderer.draw(camera);
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    return new Uint8Array(copy.getImageData(0, 0, canvas.width, canvas.height).data);
    """
    bytes_ = painter.tab.run(code, camera=in_javascript(view)).reshape(view.height, view.width, 4)
    shown = torch.from_numpy(bytes_.copy())
    assert (shown[..., 3] == 255).all()
    error = shown[..., :3] / 255 - expected.clamp(0, 1)
    assert error.abs().max() < 1 / 255


def test_a_canvas_with_another_context_is_refused(tab: Tab) -> None:
    code = """
    const said = [];
    for (const { module, name } of kinds) {
      const Renderer = (await import(`/src/render/${module}`))[name];
      const canvas = document.createElement("canvas");
      canvas.getContext("2d");
      try {
        said.push(await Renderer.create(canvas, {}) && "nothing");
      } catch (error) {
        said.push(error.message);
      }
    }
    return said;
    """
    assert tab.run(code, kinds=[kind._asdict() for kind in KINDS.values()]) == [
        "this browser cannot draw with WebGL2 here",
        "this canvas is already drawn to in another way",
    ]


def test_a_gpu_without_a_needed_feature_is_refused(tab: Tab) -> None:
    needed = {
        "EXT_color_buffer_(half_)?float": "cannot draw into textures of floats",
        "EXT_color_buffer_float": "cannot blend 32-bit floats",
        "EXT_float_blend": "cannot blend 32-bit floats",
    }
    code = """
    const { WebGlRenderer } = await import("/src/render/webgl.js");
    const ask = WebGL2RenderingContext.prototype.getExtension;
    return missing.map((some) => {
      WebGL2RenderingContext.prototype.getExtension = function (name) {
        return new RegExp(`^${some}$`).test(name) ? null : ask.call(this, name);
      };
      try {
        WebGlRenderer.create(document.createElement("canvas"), {}, { floats: true });
      } catch (error) {
        return error.message;
      }
    });
    """
    found = tab.run(code, missing=list(needed))
    assert all(part in said for part, said in zip(needed.values(), found, strict=True)), found


def test_an_impossible_image_size_is_refused(painters: Painters) -> None:
    painter = painters("webgl", full_precision=True)
    view = camera().to(dtype=torch.float32)
    painter.paint(view, as_scene(as_float32(BASE), "mobile_gs"))
    code = "return renderer.pixels(camera).catch((error) => error.message);"
    for width in (0, 100_000):
        said = painter.tab.run(code, camera=in_javascript(replace(view, width=width, height=20)))
        assert "each side must lie between 1 and" in said


def test_console_errors_fail_the_test(chromium: Chromium) -> None:
    tab = chromium.tab()
    tab.run("console.error('something is wrong')")
    with pytest.raises(AssertionError, match="something is wrong"):
        tab.close()
