"""`MobileGSMesh` in three.js against the viewer and the definition, in Chromium."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import decode_mgs, encode_mgs, read_mgs
from mobilegs.render.layers import composite
from mobilegs.render.project import rotation_matrices
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0
from tests.support.golden import TRAINED, view_network
from tests.support.page_renderers import KINDS, in_javascript
from tests.support.placed_scenes import Placed, Sums, ball_depths, sums_of
from tests.support.scene_cases import Case, make_scene
from tests.support.three_page import CLEAR, SCRIPTS, Pages, ThreePage, pixels_of

pytestmark = pytest.mark.thorough

BLUE = torch.tensor([0.2, 0.4, 1.0])
RADIUS = 0.6
# somewhere else, turned, and 2.5 times as large
MATRIX = torch.tensor(
    [[0.0, -2.0, 1.5, 0.3], [2.5, 0.0, 0.0, -1.0], [0.0, 1.5, 2.0, 0.7], [0.0, 0.0, 0.0, 1.0]]
)
BALL = """
const ball = new THREE.Mesh(
  new THREE.SphereGeometry(radius, 256, 128),
  new THREE.MeshBasicMaterial({ color: new THREE.Color().setRGB(...color, THREE.SRGBColorSpace) }),
);
ball.position.set(...center);
scene.add(ball);
window.ball = ball;
"""


@cache
def trained() -> Scene:
    return read_mgs(TRAINED).decode()


@cache
def with_pass() -> bytes:
    """The file of that scene, drawn with a depth pass."""
    coded = read_mgs(TRAINED)
    return encode_mgs(replace(coded, weighting=replace(coded.weighting, name="depth_pass")))


@cache
def view() -> Camera:
    return read_mgs(TRAINED).views[0].resized(96, 64)


@cache
def alone() -> Sums:
    """The scene where it was trained."""
    return sums_of([Placed(trained(), torch.eye(4))], view())


@cache
def center() -> torch.Tensor:
    """The middle of a ball that the scene's surface cuts."""
    depth = float(alone().depth[32, 48])
    return view().position + depth * view().viewmat[2, :3]


@cache
def limits() -> torch.Tensor:
    """The depth of that ball at each pixel."""
    return ball_depths(view(), center(), RADIUS)


@cache
def with_ball() -> torch.Tensor:
    """The scene and the ball."""
    behind = limits().isfinite()[..., None] * BLUE
    return sums_of([Placed(trained(), torch.eye(4))], view(), limits()).over(behind)


def ball() -> dict[str, object]:
    """The ball as the page gets it."""
    return {"center": center().tolist(), "radius": RADIUS, "color": BLUE.tolist()}


def opened(page: ThreePage, **more: object) -> None:
    """Load the trained scene; the page's `mesh` is it."""
    url = page.share("trained.mgs", TRAINED.read_bytes())
    page.tab.run("window.mesh = await three.load(url, more);", url=url, more=more)


def alike(found: torch.Tensor, expected: torch.Tensor, least: float, what: str = "") -> None:
    decibels = psnr(found, expected.clamp(0, 1))
    print(f"{what} {decibels:.1f} dB")
    assert decibels >= least, what


# the viewer's own picture
OWN = (SCRIPTS / "own.js").read_text()


@pytest.mark.parametrize(("kind", "scale"), [("webgl", 0.4), ("webgpu", 1.0)])
def test_a_mesh_looks_as_in_the_viewer(kind: str, scale: float, pages: Pages) -> None:
    page = pages(kind)
    opened(page, supersampling=None)
    camera = read_mgs(TRAINED).views[0].resized(round(240 * scale), round(160 * scale))
    given = {"view": in_javascript(camera), "kind": KINDS[kind]._asdict()}
    page.tab.ignore("Too many active WebGL contexts")
    expected = pixels_of(page.tab.run(OWN, **given), camera)
    assert expected.std() > 0.1
    alike(page.picture(camera), expected, 50, "in its place")
    # the same picture of the mesh elsewhere
    moved = replace(camera, viewmat=camera.viewmat @ torch.linalg.inv(MATRIX))
    moved.viewmat[:3] *= 2.5
    code = "mesh.matrixAutoUpdate = false; mesh.matrix.set(...matrix);"
    found = page.picture(moved, code, matrix=MATRIX.flatten().tolist())
    alike(found, expected, 50, "elsewhere")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.quick
def test_opaque_meshes_hide_gaussians_behind_them(kind: str, pages: Pages) -> None:
    ball_seen = limits().isfinite()
    assert 0.05 < ball_seen.float().mean() < 0.3
    # a part is in front and a part behind
    assert psnr(with_ball(), alone().over(torch.zeros(3))) < 25
    assert (with_ball() - BLUE).abs().amax(2)[ball_seen].gt(0.1).float().mean() > 0.1
    for sigma in (0, None):
        page = pages(kind)
        opened(page, levelSigma=sigma)
        alike(page.picture(view(), BALL, **ball()), with_ball(), 50, f"levels {sigma}")


@pytest.mark.parametrize("kind", KINDS)
def test_a_depth_pass_sees_what_opaque_meshes_leave(kind: str, pages: Pages) -> None:
    scene = decode_mgs(with_pass()).decode()
    cut = sums_of([Placed(scene, torch.eye(4))], view(), limits())
    expected = cut.over(limits().isfinite()[..., None] * BLUE)
    assert psnr(expected, with_ball()) < 30
    page = pages(kind)
    page.share("pass.mgs", with_pass())
    for sigma in (0, None):
        load = "window.mesh?.dispose(); window.mesh = await three.load('/arrays/pass.mgs', more);"
        page.tab.run(load, more={"levelSigma": sigma})
        alike(page.picture(view(), BALL, **ball()), expected, 45, f"levels {sigma}")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "options", [{"reversedDepthBuffer": True}, {"logarithmicDepthBuffer": True}]
)
def test_other_depth_buffers_hide_the_same(kind: str, options: dict, pages: Pages) -> None:
    page = pages(kind, **options)
    opened(page)
    alike(page.picture(view(), BALL, **ball()), with_ball(), 50)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("floats", "sigma", "least"), [(False, 0, 38), (True, None, 45)])
def test_several_scenes_are_layers(
    kind: str, floats: bool, sigma: int | None, least: float, pages: Pages
) -> None:
    page = pages(kind)
    opened(page, levelSigma=sigma, variant={"floats": floats, "strips": False})
    other = torch.tensor([[0.0, 0.0, 0.5, 0.6], [0.5, 0.0, 0.0, 0.2], [0.0, 0.5, 0.0, 0.3]])
    matrix = torch.cat([other, torch.tensor([[0.0, 0.0, 0.0, 1.0]])])
    code = """
    const second = await load(url, { levelSigma: sigma, matrixAutoUpdate: false, opacity: 0.8 });
    second.matrix.set(...matrix);
    """
    # levels change a small picture with a depth pass that no training has seen
    file = with_pass() if sigma == 0 else TRAINED.read_bytes()
    url = page.share("second.mgs", file)
    given = {"url": url, "matrix": matrix.flatten().tolist(), "sigma": sigma}
    found = page.picture(view(), code, **given)
    second = decode_mgs(file).decode()
    both = [Placed(trained(), torch.eye(4)), Placed(second, matrix, 0.8)]
    expected, _ = composite([sums_of([one], view()).layer for one in both])
    assert psnr(expected, alone().over(torch.zeros(3))) < 25
    assert psnr(expected, sums_of(both, view()).over(torch.zeros(3))) < 30
    alike(found, expected, least)


def linear(image: torch.Tensor) -> torch.Tensor:
    return torch.where(image <= 0.04045, image / 12.92, ((image + 0.055) / 1.055) ** 2.4)


def displayed(image: torch.Tensor) -> torch.Tensor:
    encoded = 1.055 * image.clamp_min(0) ** (1 / 2.4) - 0.055
    return torch.where(image <= 0.0031308, 12.92 * image, encoded)


@pytest.mark.parametrize("kind", KINDS)
def test_a_transparent_mesh_lies_in_the_scene(kind: str, pages: Pages) -> None:
    page = pages(kind)
    opened(page, levelSigma=0)
    code = "Object.assign(ball.material, { transparent: true, opacity: 0.6, depthWrite: false });"
    found = page.picture(view(), BALL + code, **ball())
    image = alone().over(torch.zeros(3))
    shown = (limits() < alone().depth) | (alone().transmittance > 0.5)
    share = 0.6 * (shown & limits().isfinite()).float()[..., None]
    # three.js blends what it draws to a canvas as displayed, and in linear colours elsewhere
    if kind == "webgl":
        expected = (1 - share) * image + share * BLUE
    else:
        expected = displayed((1 - share) * linear(image) + share * linear(BLUE))
    assert 0.02 < shown[limits().isfinite()].float().mean() < 0.98
    alike(found, expected, 40)


COMPOSED = """
const { EffectComposer } = await import("three/addons/postprocessing/EffectComposer.js");
const { RenderPass } = await import("three/addons/postprocessing/RenderPass.js");
const { OutputPass } = await import("three/addons/postprocessing/OutputPass.js");
const options = { type: THREE.HalfFloatType, samples };
const target = new THREE.WebGLRenderTarget(view.width, view.height, options);
const composer = new EffectComposer(renderer, target);
composer.addPass(new RenderPass(scene, camera));
composer.addPass(new OutputPass());
return () => composer.render();
"""
NODES = """
const { pass } = await import("three/tsl");
const pipeline = new THREE.RenderPipeline(renderer);
pipeline.outputNode = pass(scene, camera, { samples });
return () => pipeline.render();
"""


@pytest.mark.parametrize("samples", [0, 4])
@pytest.mark.parametrize("kind", KINDS)
def test_post_processing_shows_the_same(kind: str, samples: int, pages: Pages) -> None:
    page = pages(kind, antialias=True) if samples else pages(kind)
    opened(page)
    direct = page.picture(view(), BALL, **ball())
    found = page.picture(view(), COMPOSED if kind == "webgl" else NODES, samples=samples)
    alike(found, direct, 45)
    # smoother edges than one sample per pixel has, and no dark ones
    alike(found, with_ball(), 30 if samples else 40)


@pytest.mark.parametrize("kind", KINDS)
def test_meshes_follow_the_rules_of_three(kind: str, pages: Pages) -> None:
    page = pages(kind)
    opened(page, levelSigma=0)
    gray = torch.full((64, 96, 3), 0.5)
    whole = page.picture(view(), "scene.background = new THREE.Color(0x808080);")
    alike(whole, alone().over(torch.tensor(128 / 255)), 45, "over a background")
    for change in ("mesh.visible = false", "mesh.visible = true; mesh.layers.set(3)"):
        assert (page.picture(view(), f"{change};") - gray).abs().max() < 0.005
    page.picture(view(), "camera.layers.enable(3);")
    torch.testing.assert_close(page.picture(view()), whole, rtol=0, atol=0.005)
    for opacity in (0.0, 0.2, 0.5, 0.8):  # what people see fades evenly
        expected = opacity * whole + (1 - opacity) * gray
        found = page.picture(view(), f"mesh.opacity = {opacity};")
        alike(found, expected, 45, f"faded to {opacity}")
    grade = torch.tensor([[0.5, 0.2, 0.0], [0.0, 0.3, 0.1], [0.3, 0.0, 0.5]])
    offset = torch.tensor([0.1, 0.05, 0.0])
    code = "mesh.opacity = 1; mesh.grade = new THREE.Matrix4().set(...matrix);"
    matrix = torch.cat([torch.cat([grade, offset[:, None]], 1), torch.tensor([[0.0, 0, 0, 1]])])
    found = page.picture(view(), code, matrix=matrix.flatten().tolist())
    graded = alone()._replace(color=alone().color @ grade.T + alone().weight[..., None] * offset)
    alike(found, graded.over(gray), 45, "graded")


@pytest.mark.parametrize("kind", KINDS)
def test_a_crop_leaves_out_what_lies_outside(kind: str, pages: Pages) -> None:
    page = pages(kind)
    opened(page, levelSigma=0)
    means = trained().gaussians.means
    low, high = means.quantile(torch.tensor([0.3, 0.8]), dim=0).unbind()
    kept = ((means >= low) & (means <= high)).all(1).nonzero()[:, 0]
    assert 0.03 < len(kept) / len(means) < 0.5
    lobes = trained().lobes
    assert lobes is not None
    part = replace(trained(), gaussians=trained().gaussians.select(kept), lobes=lobes[kept])
    expected = sums_of([Placed(part, torch.eye(4))], view()).over(torch.zeros(3))
    assert psnr(expected, alone().over(torch.zeros(3))) < 25
    code = "mesh.crop = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high));"
    alike(page.picture(view(), code, low=low.tolist(), high=high.tolist()), expected, 45)
    alike(page.picture(view(), "mesh.crop = null;"), alone().over(torch.zeros(3)), 45)


@pytest.mark.quick
def test_meshes_of_one_address_share_what_is_loaded(pages: Pages) -> None:
    page = pages("webgl")
    page.share("shared.mgs", TRAINED.read_bytes())
    requests: list[str] = []
    page.tab.page.on("request", lambda request: requests.append(request.url))
    found = page.tab.run(
        """const { THREE, MobileGSMesh, scene, load } = three;
        const given = new URL("/arrays/shared.mgs", location.href);
        const [one, other] = await Promise.all([load(given), load(given)]);
        Object.assign(one, { opacity: 0.5, crop: new THREE.Box3(), grade: new THREE.Matrix4() });
        one.position.set(1, 2, 3);
        const copy = one.clone();
        await copy.loaded;
        one.dispose();
        const same = copy.data === other.data && copy.gaussians > 0;
        const alike = [copy.opacity, copy.position.toArray(), copy.crop !== one.crop];
        const from = new MobileGSMesh({ file: await (await fetch(given)).arrayBuffer() });
        await from.loaded;
        const warned = [];
        console.warn = (text) => warned.push(text);
        JSON.stringify(copy.userData);
        JSON.stringify(copy.userData);
        for (const mesh of [copy, other, from]) mesh.dispose();
        return [same, ...alike, one.gaussians, from.views.length, warned];"""
    )
    assert found[:5] == [True, 0.5, [1, 2, 3], True, 0] and found[5] > 0
    assert len(found[6]) == 1 and "not exported" in found[6][0]
    # the meshes', and that of the test itself
    assert sum(url.endswith("shared.mgs") for url in requests) == 2


@pytest.mark.parametrize("kind", ["webgpu", "webgl"])
def test_a_disposed_mesh_leaves_nothing_on_the_gpu(kind: str, pages: Pages) -> None:
    page = pages(kind)
    page.share("trained.mgs", TRAINED.read_bytes())
    page.tab.run(
        """const live = (window.live = new Set());
        const wrap = (where, made, ended) => {
          const [make, end] = [where[made], ended.of[ended.name]];
          where[made] = function (...given) {
            const one = make.apply(this, given);
            live.add(one);
            return one;
          };
          ended.of[ended.name] = function (...given) {
            live.delete(ended.of === where ? given[0] : this);
            return end.apply(this, given);
          };
        };
        if (three.renderer.backend?.isWebGPUBackend) {
          for (const { name, prototype } of [GPUBuffer, GPUTexture, GPUQuerySet]) {
            const ended = { of: prototype, name: "destroy" };
            wrap(GPUDevice.prototype, name.replace("GPU", "create"), ended);
          }
        } else {
          const of = WebGL2RenderingContext.prototype;
          for (const kind of ["Buffer", "Texture", "Framebuffer", "VertexArray", "Program"]) {
            wrap(of, `create${kind}`, { of, name: `delete${kind}` });
          }
        }"""
    )
    left = []
    for _ in range(3):
        code = "await load('/arrays/trained.mgs');"
        assert page.picture(view(), code).std() > 0.05
        page.picture(view(), CLEAR)
        left.append(page.tab.run("return live.size;"))
    assert left[1] == left[2], left


@pytest.mark.quick
def test_a_page_can_end_loading(pages: Pages) -> None:
    page = pages("webgl")
    page.share("trained.mgs", TRAINED.read_bytes())
    found = page.tab.run(
        """const { MobileGSMesh } = three;
        const [told, url] = [[], "/arrays/trained.mgs"];
        const onError = ({ message }) => told.push(message);
        const one = new MobileGSMesh({ url, onError });
        one.dispose();
        const over = new AbortController();
        const other = new MobileGSMesh({ url, onError, signal: over.signal });
        over.abort(new Error("enough"));
        const { signal } = over;
        const third = new MobileGSMesh({ url, onError, signal });
        const ends = [one, other, third].map(({ loaded }) => loaded.catch((error) => error));
        const [disposed, ...aborted] = await Promise.all(ends);
        const late = await three.load(url);
        const { loaded } = late;
        late.dispose();
        const same = (await loaded) === late;
        return [disposed.name, ...aborted.map(({ message }) => message), told, same];"""
    )
    assert found == ["AbortError", "enough", "enough", [], True]


@pytest.mark.quick
def test_the_first_view_is_that_of_the_file(pages: Pages) -> None:
    page = pages("webgl")
    opened(page)
    found = page.tab.run(
        """const { THREE } = three;
        mesh.scale.setScalar(2);
        mesh.position.set(1, 0, 0);
        const view = mesh.firstView(1.5);
        const box = mesh.boundingBox ?? mesh.computeBoundingBox();
        const wide = mesh.views[0];
        return [view.position.toArray(), view.target.toArray(), view.up.toArray(), view.fov,
          box.min.toArray(), box.max.toArray(), mesh.notes, mesh.upward?.toArray() ?? null];"""
    )
    camera = read_mgs(TRAINED).views[0]
    position, target, up = map(torch.tensor, found[:3])
    place = torch.tensor([1.0, 0.0, 0.0])
    torch.testing.assert_close((position - place) / 2, camera.position, rtol=0, atol=1e-4)
    ahead = torch.nn.functional.normalize(target - position, dim=0)
    torch.testing.assert_close(ahead, camera.viewmat[2, :3], rtol=0, atol=1e-3)
    assert float(up.norm()) == pytest.approx(1, abs=1e-5)
    assert float(up @ -camera.viewmat[1, :3]) > 0.8
    assert 20 < found[3] < 100
    means = trained().gaussians.means
    inside = (means > torch.tensor(found[4])) & (means < torch.tensor(found[5]))
    assert 0.9 < inside.all(1).float().mean() <= 1
    assert found[6] == read_mgs(TRAINED).meta


def half_light(places: list[tuple[int, int]]) -> torch.Tensor:
    """The depth at which half of the light of a pixel is gone, infinite if more of it passes."""
    g, lobes = trained().gaussians, trained().lobes
    assert lobes is not None
    opacities = torch.sigmoid(C0 * lobes[:, 0, 0])
    to_axes = rotation_matrices(g.quats).transpose(1, 2) / g.scales[:, :, None]
    means = (to_axes @ (g.means - view().position)[:, :, None])[..., 0]
    found = []
    for x, y in places:
        ray = torch.linalg.inv(view().K) @ torch.tensor([x + 0.5, y + 0.5, 1.0])
        rays = to_axes @ (view().viewmat[:3, :3].T @ ray)
        depths = (means * rays).sum(1) / (rays * rays).sum(1)
        squares = (means - depths[:, None] * rays).square().sum(1)
        rows = ((squares < 9) & (depths > 0)).nonzero()[:, 0]
        rows = rows[depths[rows].argsort()]
        alphas = (opacities[rows] * torch.exp(-0.5 * squares[rows])).clamp_max(0.99)
        dark = (torch.log1p(-alphas).cumsum(0).exp() < 0.5).nonzero()[:, 0]
        found.append(depths[rows[dark[0]]] if len(dark) else torch.tensor(torch.inf))
    return torch.stack(found)


@pytest.mark.quick
def test_rays_meet_the_surface(pages: Pages) -> None:
    page = pages("webgl")
    opened(page)
    places = [(x, y) for y in range(4, 64, 8) for x in range(4, 96, 8)]
    found = page.tab.run(
        """const { THREE, camera, look } = three;
        look(view);
        const ray = new THREE.Raycaster();
        mesh.scale.setScalar(2);
        mesh.updateMatrixWorld();
        const { width, height } = view;
        return places.map(([x, y]) => {
          const at = new THREE.Vector2((2 * x + 1) / width - 1, 1 - (2 * y + 1) / height);
          ray.setFromCamera(at, camera);
          ray.ray.origin.multiplyScalar(2);
          const [hit] = ray.intersectObject(mesh);
          return hit ? [...hit.point.divideScalar(2), hit.index] : null;
        });""",
        places=places,
        view=in_javascript(view()),
    )
    expected = half_light(places)
    met = torch.tensor([point is not None for point in found])
    assert (met == expected.isfinite()).float().mean() > 0.95 and met.float().mean() > 0.7
    points = torch.tensor([point[:3] if point else [0.0, 0.0, 0.0] for point in found])
    # the Gaussian of a hit is there
    g = trained().gaussians
    rows = torch.tensor([point[3] if point else 0 for point in found])
    away = (points - g.means[rows]).norm(dim=1) / g.scales[rows].amax(1)
    assert (away[met] < 3.1).all()
    depths = points @ view().viewmat[2, :3] + view().viewmat[2, 3]
    errors = (depths / expected - 1).abs()[met & expected.isfinite()]
    print(f"{len(errors)} rays, errors {errors.quantile(torch.tensor([0.5, 0.9])).tolist()}")
    assert errors.median() < 0.005 and errors.quantile(0.9) < 0.05


COUNT = (SCRIPTS / "count.js").read_text()


@pytest.mark.parametrize("kind", KINDS)
def test_disposal_frees_everything(kind: str, pages: Pages) -> None:
    page = pages(kind, powerPreference="low-power")  # a page of its own
    url = page.share("trained.mgs", TRAINED.read_bytes())
    given = {"url": url, "view": in_javascript(view()), "kind": kind}
    most, left, children = page.tab.run(COUNT, **given)
    print(f"{most} objects, {left} left")
    # what three.js keeps for its own triangle and material
    assert most > 15 and left <= 8 and children == 0


def refusal(page: ThreePage, content: bytes, name: str) -> str:
    """Return the sentence with which a file is refused, when loading or when drawing."""
    return page.tab.run(
        """const { MobileGSMesh, renderer, scene, camera, look } = three;
        look(view);
        let told;
        const said = new Promise((resolve) => (told = resolve));
        const mesh = new MobileGSMesh({ url, onError: (error) => told(error.message) });
        scene.add(mesh);
        mesh.loaded.then(() => renderer.render(scene, camera), () => {});
        const sentence = await said;
        renderer.render(scene, camera);
        return sentence;""",
        url=page.share(name, content),
        view=in_javascript(view()),
    )


def test_scenes_that_cannot_be_drawn_are_refused(pages: Pages, tmp_path: Path) -> None:
    page = pages("webgl")
    write_ply(tmp_path / "made.ply", trained().gaussians.select(torch.arange(50)))
    sentence = refusal(page, (tmp_path / "made.ply").read_bytes(), "made.ply")
    assert "needs sorting" in sentence
    assert "is not" in refusal(page, b"nothing of that kind", "other.mgs")
    network = make_scene(Case(30, network=True))
    assert "takes WebGPURenderer" in refusal(page, encode_mgs(network), "network.mgs")


def test_a_view_network_is_evaluated(pages: Pages) -> None:
    coded = make_scene(Case(800, network=True, exponent=4, spread=0.2))
    coded.network = {name: value.half() for name, value in view_network().state_dict().items()}
    page = pages("webgpu")
    url = page.share("network.mgs", encode_mgs(coded))
    camera = replace(view(), viewmat=torch.eye(4))
    camera.viewmat[2, 3] = 4.0
    code = """
    const mesh = await load(url, { levelSigma: 0 });
    scene.background.setRGB(...mesh.background, THREE.SRGBColorSpace);
    """
    found = page.picture(camera, code, url=url)
    expected = coded.decode().render(replace(camera, near=coded.near)).image
    assert expected.std() > 0.05
    alike(found, expected, 45)
