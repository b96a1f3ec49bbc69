"""Time both renderers, forward and backward, on a synthetic scene.

    python -m bench.kernels [--json OUT] [--counts 100000 400000]
    python -m bench.kernels --scenes A.mgs B.mgs ... [--names A B ...] [--json OUT]

Scenes are trained sort-free ones: they are drawn from their first view at the size of training, and
at two and three times that size, in turns with all Gaussians at full size and with the viewers'
levels, and their fragments per pixel are counted.
"""

import argparse
import math
import resource
import time
from pathlib import Path

import numpy as np
import torch

from bench.record import RESULTS, Figures
from mobilegs.camera import Camera
from mobilegs.evaluate.fragments import fragments_per_pixel
from mobilegs.mgs.codec import read_mgs
from mobilegs.render import render_sorted, render_sortfree
from mobilegs.render.levels import usual_level_sigma
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.project import ALPHA_MIN
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0

WIDTH, HEIGHT, FOCAL = 800, 533, 700.0
BACKGROUND = (0.1, 0.2, 0.3)
LOBE_DEGREE = 2  # of a student
INPUTS = {
    "sorted": ("means", "quats", "scales", "opacities", "sh"),
    "sortfree": ("means", "quats", "scales", "lobes", "sh"),
}


def study_scene(count: int) -> tuple[dict[str, torch.Tensor], Camera]:
    """Return the scene: depth log-uniform over 1..20, projected sigma about 3 px, SH degree 1."""
    g = np.random.default_rng(0)
    z = np.exp(g.uniform(0, np.log(20.0), count))
    u = g.uniform(-0.03 * WIDTH, 1.03 * WIDTH, count)
    v = g.uniform(-0.03 * HEIGHT, 1.03 * HEIGHT, count)
    means = np.stack([(u - WIDTH / 2) / FOCAL * z, (v - HEIGHT / 2) / FOCAL * z, z], 1)
    sigma = np.minimum(3 * np.exp(0.8 * g.standard_normal(count)), 60.0)
    scales = sigma[:, None] * z[:, None] / FOCAL * np.exp(0.35 * g.standard_normal((count, 3)))
    quats = g.standard_normal((count, 4))
    sh = [g.normal(0.3, 0.8, (count, 1, 3)), g.normal(0, 0.15, (count, 3, 3))]
    opacities = 1 / (1 + np.exp(-g.normal(0, 1.5, count)))
    phi = np.maximum(g.normal(1, 0.4, count), 0)
    lobes = np.zeros((count, (LOBE_DEGREE + 1) ** 2, 2))
    lobes[:, 0] = np.stack([np.log(opacities / (1 - opacities)), phi], 1) / C0
    c, s = math.cos(0.3), math.sin(0.3)
    rotation, shift = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), np.array([0.2, -0.1, 0.5])
    viewmat = np.eye(4)
    viewmat[:3, :3], viewmat[:3, 3] = rotation, shift
    k = [[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]]
    values = {
        "means": (means - shift) @ rotation,
        "quats": quats,
        "scales": scales,
        "opacities": opacities,
        "sh": np.concatenate(sh, 1),
        "phi": phi,
        "lobes": lobes,
    }
    scene = {name: torch.tensor(x, dtype=torch.float32) for name, x in values.items()}
    return scene, Camera(torch.tensor(viewmat).float(), torch.tensor(k), WIDTH, HEIGHT)


class Ours:
    """Our kernels behind the public functions, autograd included."""

    def __init__(self, scene: dict[str, torch.Tensor], camera: Camera, grad: torch.Tensor) -> None:
        self.leaves = {name: value.clone().requires_grad_() for name, value in scene.items()}
        self.camera, self.grad = camera, grad
        self.background = torch.tensor(BACKGROUND)

    def forward(self, path: str) -> torch.Tensor:
        render = render_sortfree if path == "sortfree" else render_sorted
        inputs = [self.leaves[name] for name in INPUTS[path]]
        return render(*inputs, camera=self.camera, background=self.background).image

    def both(self, path: str) -> dict[str, torch.Tensor]:
        for leaf in self.leaves.values():
            leaf.grad = None
        self.forward(path).backward(self.grad)
        return {n: leaf.grad for n, leaf in self.leaves.items() if leaf.grad is not None}


class Trained:
    """A trained scene through the public function, with a `level_sigma`."""

    def __init__(self, scene: Scene, camera: Camera, level_sigma: float) -> None:
        gaussians = scene.gaussians
        lobes = constant_lobes(gaussians.logit_opacities) if scene.lobes is None else scene.lobes
        leaves = (gaussians.means, gaussians.quats, gaussians.scales, lobes, gaussians.sh)
        self.leaves = [leaf.detach().clone().requires_grad_() for leaf in leaves]
        self.options = {"camera": camera, "background": scene.background}
        self.options |= {"weighting": scene.weighting, "footprint": scene.footprint}
        self.options["level_sigma"] = level_sigma
        shape = (camera.height, camera.width, 3)
        self.grad = torch.randn(*shape, generator=torch.Generator().manual_seed(7))

    def forward(self) -> torch.Tensor:
        return render_sortfree(*self.leaves, **self.options).image

    def both(self) -> None:
        for leaf in self.leaves:
            leaf.grad = None
        self.forward().backward(self.grad)


def contributing_pairs(scene: dict[str, torch.Tensor], camera: Camera) -> int:
    """Count (pixel, Gaussian) pairs with alpha >= 1/255: the area of all ellipses in the image."""
    from mobilegs.render.project import project

    flat = [scene[name] for name in INPUTS["sorted"]]
    total = 0.0
    for start in range(0, len(flat[0]), 50000):
        part = project(*[x[start : start + 50000] for x in flat], camera=camera)
        a, b, c = part.conics.double().unbind(1)
        reach = 2 * torch.log(flat[3][start : start + 50000].double() / ALPHA_MIN)
        area = math.pi * reach / (a * c - b * b).sqrt()
        low = (part.means2d - part.radii).clamp_min(0)
        size = part.means2d.new_tensor([camera.width, camera.height])
        high = torch.minimum(part.means2d + part.radii, size)
        share = (high - low).clamp_min(0).prod(1) / (2 * part.radii).prod(1).clamp_min(1e-9)
        total += (area * share)[part.visible].sum().item()
    return int(total)


def times(candidates: dict, call, rounds: int) -> dict[str, list[float]]:
    """Return the milliseconds of `call(candidate)`; all candidates take turns within each round."""
    for candidate in candidates.values():
        call(candidate)
    found = {name: [] for name in candidates}
    for _ in range(rounds):
        for name, candidate in candidates.items():
            start = time.perf_counter()
            call(candidate)
            found[name].append((time.perf_counter() - start) * 1e3)
    return found


def measure(count: int, rounds: int, figures: Figures) -> None:
    """Add a row for each path and kind of the synthetic scene."""
    scene, camera = study_scene(count)
    grad = torch.randn(HEIGHT, WIDTH, 3, generator=torch.Generator().manual_seed(7))
    ours, pairs = Ours(scene, camera, grad), contributing_pairs(scene, camera)
    for path in ("sortfree", "sorted"):
        for kind in ("forward", "both"):
            samples = times({"ours": ours}, lambda c, k=kind, p=path: getattr(c, k)(p), rounds)
            median = float(np.median(samples["ours"]))
            row: dict = {"gaussians": count, "pairs": pairs}
            row |= {"ours_ms": round(median, 2), "ours_min_ms": round(min(samples["ours"]), 2)}
            if path == "sortfree":  # the sorted path stops early: it sees fewer pairs
                row["ours_ns_per_pair"] = round(median * 1e6 / pairs, 3)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
            figures.add(f"{count} {path} {kind}", **row, peak_memory_mib=peak)


def measure_scene(path: Path, name: str, rounds: int, figures: Figures) -> None:
    """Add a row for each size and kind of a trained scene."""
    coded = read_mgs(path)
    scene, view = coded.decode(), coded.views[0]
    sigma = usual_level_sigma(soft_edge=scene.footprint.soft_edge)
    for factor in (1, 2, 3):
        camera = view.resized(factor * view.width, factor * view.height)
        candidates = {k: Trained(scene, camera, k) for k in (0.0, sigma)}
        counts = {k: fragments_per_pixel(scene, camera, level_sigma=k) for k in candidates}
        for kind in ("forward", "both"):
            found = times(candidates, lambda c, k=kind: getattr(c, k)(), rounds)
            ratios = [a / b for a, b in zip(found[0.0], found[sigma], strict=True)]
            figures.add(
                f"{name} {camera.width}x{camera.height} {kind}",
                scene=name,
                gaussians=len(scene.gaussians),
                size=[camera.width, camera.height],
                kind=kind,
                level_sigma=sigma,
                full_ms=round(float(np.median(found[0.0])), 2),
                levels_ms=round(float(np.median(found[sigma])), 2),
                times_faster=round(float(np.median(ratios)), 3),
                fragments=round(sum(counts[0.0]), 2),
                fragments_by_level=[round(value, 2) for value in counts[sigma]],
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="default: kernels.json or trained_kernels.json")
    parser.add_argument("--counts", type=int, nargs="*", default=[100_000, 400_000])
    parser.add_argument("--scenes", type=Path, nargs="*", default=[], metavar="MGS")
    parser.add_argument("--names", nargs="*", help="names of the scenes in the JSON")
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    if options.scenes:
        figures = Figures(options.json or RESULTS / "trained_kernels.json", torch=torch.__version__)
        for path, name in zip(options.scenes, options.names or options.scenes, strict=True):
            measure_scene(path, str(name), options.rounds, figures)
        return
    path = options.json or RESULTS / "kernels.json"
    figures = Figures(path, size=[WIDTH, HEIGHT], torch=torch.__version__)
    for count in options.counts:
        measure(count, options.rounds, figures)


if __name__ == "__main__":
    main()
