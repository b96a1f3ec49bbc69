"""Compare web viewers: one scene, one camera path, headless Chromium.

    python -m bench.viewers.compare --mgs RUN/scene.mgs --ply RUN/teacher.ply [--json OUT]
        [--size 800x533] [--frames 10] [--only "ours, WebGPU" "PlayCanvas*"]

Ours and `MobileGSMesh` draw the student's `.mgs` sort-free. The other viewers, and ours sorted,
draw the `.ply` of its teacher. The others come from npm (`package.json` in this folder). All use
the same cameras: they look at the point that the capture's cameras look at, from the distance and
with the field of view of the first camera.

Each viewer runs in its own browser, all in turns, `--rounds` times, each round starting with
another one:

- *load*: from navigation to the end of the first frame that looks like the settled picture. The
  server is local, so this is reading, compiling and one frame; the bytes say what a network adds.
- *frame*: an orbit of 1 degree per frame. A frame begins with the camera and ends when the device
  has finished it. *cpu*: seconds of all browser processes per frame, sorting workers included.
- *settle*: time after a jump by 120 degrees until the picture is within 50 dB of the settled one.
  Every frame is read back, which the time includes; the number of frames says more.
- *memory*: what the page's and the GPU's processes hold after the orbit, beyond an empty page's
  (PSS). Ours opens its scene `--loads` times more, which shows what stays.
- *turn*: 6 degrees per frame; *timed*: 90 degrees a second. Both run in the first round only.
  `--turn-frames 0` leaves both out. Each picture is compared with the viewer's own settled picture
  from there, which shows the cost of a stale order, and with the true image: the CPU kernels'
  render of the file. Stochastic pictures settle with their noise: only the true image shows it.

Ours picks the fastest way to draw at its start, unless its name says float16 or float32. Viewers
run as they ship, except that nothing fades in, spherical harmonics have the highest degree that
they can draw (2 in mkkellogg's), Spark knows that the scene was trained without anti-aliasing, and
frames are requested one by one. `fragments` are ours alone: per pixel, by level, after the last
frame of the orbit.

A software device says nothing about phones, and it distorts turns: by degrees per frame, workers
have time to sort between frames, which flatters viewers that sort; by time, frames are tens of
degrees apart, which is hard on them.
"""

import argparse
import gzip
import json
import math
import os
import subprocess
from dataclasses import dataclass, field
from fnmatch import fnmatch
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import torch

from bench.record import RESULTS, ROOT, Figures
from bench.viewers.chromium import launched
from bench.viewers.serve import Server
from mobilegs.camera import Camera, look_at
from mobilegs.mgs.codec import read_mgs
from mobilegs.scene_file import open_scene
from mobilegs.view.assets import script

PAGES = ROOT / "bench" / "viewers"
PEERS = ROOT / "build" / "viewers"  # where npm installs
FOLDERS = {"": PAGES, "viewer": ROOT / "viewer", "peers": PEERS / "node_modules"}
RING = 360  # cameras around the scene, one a degree
JUMPS = [120, 240]  # degrees
TURN_STEP, TURN_SPEED = 6, 90  # degrees a frame, degrees a second
ALIKE = 99.0  # dB, reported where two pictures are equal
SETTLED = 50.0  # dB; a frame of a turn that is further from the settled picture is stale


@dataclass(frozen=True)
class Variant:
    """One viewer in one configuration: its module, its scene, its options."""

    module: str
    scene: str
    wishes: dict[str, str] = field(default_factory=dict)


VARIANTS = {
    "ours, WebGPU": Variant("ours", "mgs", {"api": "webgpu"}),
    "ours, WebGPU, float16": Variant("ours", "mgs", {"api": "webgpu", "sums": "halves"}),
    "ours, WebGPU, float32": Variant("ours", "mgs", {"api": "webgpu", "sums": "floats"}),
    "ours, WebGPU, all at full size": Variant("ours", "mgs", {"api": "webgpu", "levels": "0"}),
    "ours, WebGL2": Variant("ours", "mgs", {"api": "webgl"}),
    "ours, WebGL2, all at full size": Variant("ours", "mgs", {"api": "webgl", "levels": "0"}),
    "ours, WebGL2, float16": Variant("ours", "mgs", {"api": "webgl", "sums": "halves"}),
    "ours, WebGL2, float32": Variant("ours", "mgs", {"api": "webgl", "sums": "floats"}),
    "ours sorted, WebGPU": Variant("ours", "ply", {"api": "webgpu"}),
    "ours sorted, WebGL2": Variant("ours", "ply", {"api": "webgl"}),
    "PlayCanvas 2.23.3, WebGPU": Variant("playcanvas", "ply", {"api": "webgpu"}),
    "PlayCanvas 2.23.3, stochastic": Variant(
        "playcanvas", "ply", {"api": "webgpu", "stochastic": "1"}
    ),
    "PlayCanvas 2.23.3, WebGL2": Variant("playcanvas", "ply", {"api": "webgl"}),
    "three.js 0.187.0, WebGPU": Variant("three-splat", "ply"),
    "Spark 2.2.0, WebGL2": Variant("spark", "ply"),
    "mkkellogg 0.4.7, WebGL2": Variant("mkkellogg", "ply"),
    "MobileGSMesh, WebGPU": Variant("three-mesh", "mgs", {"api": "webgpu"}),
    "MobileGSMesh, WebGL2": Variant("three-mesh", "mgs", {"api": "webgl"}),
}


def install() -> None:
    """Install the other viewers as `package.json` pins them, if they are missing."""
    PEERS.mkdir(parents=True, exist_ok=True)
    wanted = (PAGES / "package.json").read_text()
    done = PEERS / "package.json"
    if done.exists() and done.read_text() == wanted and (PEERS / "node_modules").exists():
        return
    done.write_text(wanted)
    subprocess.run(["npm", "install", "--no-audit", "--no-fund"], cwd=PEERS, check=True)


def ring_of(views: list[Camera], width: int, height: int, step: float = 1.0) -> list[Camera]:
    """Return cameras on a circle around the point that `views` look at, `step` degrees apart."""
    eyes = torch.stack([view.position for view in views]).double()
    down, forward = (torch.stack([v.viewmat[i, :3] for v in views]).double() for i in (1, 2))
    # the place nearest to all lines of sight: sum of (I - f f^T) (x - eye) = 0
    square = torch.eye(3) - forward[:, :, None] * forward[:, None, :]
    center = torch.linalg.solve(square.sum(0), (square @ eyes[:, :, None]).sum(0))[:, 0]
    up = torch.nn.functional.normalize(-down.mean(0), dim=0)
    first, back = views[0], eyes[0] - center
    focal = math.sqrt(width * first.K[0, 0] / first.width * height * first.K[1, 1] / first.height)
    K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    ring = []
    for angle in torch.arange(RING) * (step * 2 * math.pi / RING):
        along = up * (up @ back)
        turned = along + (back - along) * angle.cos() + torch.linalg.cross(up, back) * angle.sin()
        viewmat = look_at(center + turned, center, up).float()
        ring.append(Camera(viewmat, K, width, height, first.near))
    return ring


def plan_of(ring: list[Camera]) -> bytes:
    """Return the JSON that `drive.js` reads."""
    cameras = []
    for camera in ring:
        sizes = {"width": camera.width, "height": camera.height, "near": camera.near}
        focal = {"fx": camera.K[0, 0].item(), "fy": camera.K[1, 1].item()}
        cameras.append({"viewmat": camera.viewmat.flatten().tolist(), **focal, **sizes})
    return json.dumps({"ring": cameras}).encode()


class Truth:
    """True images along the ring, drawn by the CPU kernels on first use."""

    def __init__(self, scenes: dict[str, Path], ring: list[Camera]) -> None:
        self._scenes = {k: open_scene(path, torch.device("cpu")) for k, path in scenes.items()}
        self._ring = ring
        self._known: dict[tuple[str, int], np.ndarray] = {}

    def image(self, kind: str, degrees: int) -> np.ndarray:
        """Return an image, `[h, w, 3]`, 0 to 255."""
        if (kind, degrees) not in self._known:
            with torch.no_grad():
                image = self._scenes[kind].render(self._ring[degrees % RING]).image
            self._known[kind, degrees] = 255 * image.clamp(0, 1).double().numpy()
        return self._known[kind, degrees]


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    error = np.mean((a - b) ** 2)
    return min(ALIKE, 10 * math.log10(255**2 / error)) if error else ALIKE


def processes(session: Any) -> list[dict[str, Any]]:
    return session.send("SystemInfo.getProcessInfo")["processInfo"]


def cpu_seconds(session: Any) -> float:
    """Return the CPU time of all browser processes so far."""
    return sum(process["cpuTime"] for process in processes(session))


def memory_of(session: Any, page: Any) -> np.ndarray:
    """Return MB of the page's processes and of the GPU's, shared pages divided (PSS)."""
    page.request_gc()
    found = {"renderer": 0.0, "GPU": 0.0}
    for process in processes(session):
        if process["type"] in found:
            text = Path(f"/proc/{process['id']}/smaps_rollup").read_text()
            (kilobytes,) = (line.split()[1] for line in text.splitlines() if line[:4] == "Pss:")
            found[process["type"]] += int(kilobytes) / 1e3
    return np.array(list(found.values()))


@dataclass
class Plan:
    """Picture size, and the number of frames per measurement."""

    width: int
    height: int
    frames: int
    warm: int
    turn_frames: int
    loads: int


def visit(playwright: Any, server: Server, variant: Variant, plan: Plan) -> dict[str, Any]:
    """Measure one viewer in its own browser."""
    server.pictures.clear()
    browser = launched(playwright)
    try:
        page = browser.new_page(viewport={"width": plan.width, "height": plan.height})
        complaints: list[str] = []
        page.on("console", lambda m: m.type == "error" and complaints.append(m.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.set_default_timeout(0)
        session = browser.new_browser_cdp_session()
        empty = memory_of(session, page)
        wishes = {"module": variant.module, "scene": f"/scene/scene.{variant.scene}"}
        page.goto(f"{server.address}/page.html?{urlencode(wishes | variant.wishes)}")

        def ask(call: str) -> Any:
            return page.evaluate(f'async () => (await import("/drive.js")).{call}')

        found: dict[str, Any] = {"browser": browser.version, "complaints": complaints}
        found["load_average"] = os.getloadavg()[0]
        found["load_ms"] = ask("loaded")
        found["about"] = ask("about()")
        ask(f"orbit({plan.warm}, 1)")
        before = cpu_seconds(session)
        found["frame_ms"] = ask(f"orbit({plan.frames}, 1)")
        found["cpu_ms"] = 1000 * (cpu_seconds(session) - before) / plan.frames
        found["memory_mb"] = (memory_of(session, page) - empty).round(1).tolist()
        found["fragments"] = ask("fragments()")
        if plan.turn_frames and ask(f"again({plan.loads})"):
            found["memory_after_loads_mb"] = (memory_of(session, page) - empty).round(1).tolist()
        found["jumps"] = ask(f"jumps({JUMPS})")
        if plan.turn_frames == 0:
            return found
        found["turn"] = ask(f"turn('turn', {plan.turn_frames}, {TURN_STEP}, 0)")
        found["timed"] = ask(f"turn('timed', {plan.turn_frames}, 0, {TURN_SPEED})")
        places = {frame["degrees"] for frame in found["turn"] + found["timed"]}
        ask(f"references({sorted(places)})")
        return found
    finally:
        browser.close()


def viewer_bytes(variant: Variant) -> int | None:
    """Return the gzipped bytes that a page ships of the viewer; None within a page of three.js."""
    if variant.module == "three-mesh":
        return None
    if variant.module == "ours":
        files = map(script, ("viewer.js", "worker.js", "wgsl.js"))
        return sum(len(gzip.compress(text.encode())) for text in files)
    program = PEERS / "node_modules" / ".bin" / "esbuild"
    options = ["--bundle", "--minify", "--format=esm", "--log-level=error"]
    page = PAGES / f"{variant.module}.js"
    env = os.environ | {"NODE_PATH": str(PEERS / "node_modules")}
    bundle = subprocess.run([program, page, *options], env=env, capture_output=True, check=True)
    return len(gzip.compress(bundle.stdout))


def errors_of(
    seen: list[dict], name: str, pictures: dict[str, np.ndarray], truth: Any
) -> dict[str, Any]:
    """Return the PSNR of turning pictures against settled ones and against the truth."""
    rows = []
    for degrees in (frame["degrees"] for frame in seen):
        moving, settled = pictures[f"{name}/{degrees}"], pictures[f"settled/{degrees}"]
        true = truth(degrees)
        rows.append([psnr(moving, settled), psnr(moving, true), psnr(settled, true)])
    found: dict[str, Any] = {"frames": len(rows)}
    found["stale"] = sum(row[0] < SETTLED for row in rows)
    found["frame_ms"] = median([frame["milliseconds"] for frame in seen])
    for column, pair in enumerate(("moving_settled", "moving_true", "settled_true")):
        values = [row[column] for row in rows]
        found[pair] = {"median": median(values), "min": round(min(values), 2)}
    return found


def median(values: list[float]) -> float:
    return round(float(np.median(values)), 2)


def decoded(pictures: dict[str, bytes], plan: Plan) -> dict[str, np.ndarray]:
    """Return the pictures of pages, `[h, w, 3]`, 0 to 255."""
    shape = (plan.height, plan.width, 4)
    return {
        name: np.frombuffer(body, np.uint8).reshape(shape)[..., :3].astype(np.float64)
        for name, body in pictures.items()
    }


def summary(rounds: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the rounds of one viewer as the results hold them."""
    found: dict[str, Any] = {}
    found["load_ms"] = {"median": median([r["load_ms"] for r in rounds])}
    found["load_ms"]["min"] = round(min(r["load_ms"] for r in rounds), 2)
    times = [time for r in rounds for time in r["frame_ms"]]
    found["frame_ms"] = {"median": median(times), "min": round(min(times), 2)}
    cpu = [r["cpu_ms"] for r in rounds]
    found["cpu_ms"] = {"median": median(cpu), "min": round(min(cpu), 2)}
    jumps = [jump for r in rounds for jump in r["jumps"]]
    found["settle_ms"] = median([jump["milliseconds"] for jump in jumps])
    if rounds[0]["fragments"] is not None:
        found["fragments"] = [round(value, 2) for value in rounds[0]["fragments"]]
    found["memory_mb"] = np.median([r["memory_mb"] for r in rounds], 0).round(1).tolist()
    if "memory_after_loads_mb" in rounds[0]:
        found["memory_after_loads_mb"] = rounds[0]["memory_after_loads_mb"]
    found["settle_frames"] = median([jump["frames"] for jump in jumps])
    found["rounds"] = [
        {
            "load_average": round(r["load_average"], 2),
            "load_ms": round(r["load_ms"], 2),
            "frame_ms": median(r["frame_ms"]),
            "cpu_ms": round(r["cpu_ms"], 2),
            "drawn_with": r["about"],
        }
        for r in rounds
    ]
    found["complaints"] = sorted({text for r in rounds for text in r["complaints"]})
    return found


def measure(
    options: argparse.Namespace, views: list[Camera], chosen: dict[str, Variant]
) -> dict[str, dict[str, Any]]:
    """Measure viewers in turns, around what `views` look at, and return their rows.

    Prints why a viewer fails.
    """
    from playwright.sync_api import Error, sync_playwright

    install()
    scenes = {"mgs": options.mgs, "ply": options.ply}
    width, height = map(int, options.size.split("x"))
    ring = ring_of(views, width, height)
    server, truth = Server(FOLDERS, scenes), Truth(scenes, ring)
    server.plan = plan_of(ring)
    rounds: dict[str, list[dict]] = {name: [] for name in chosen}
    rest: dict[str, dict] = {}
    failed: set[str] = set()
    with sync_playwright() as playwright:
        first = launched(playwright)  # whose files come from the disk
        first.new_page()
        first.close()
        for number in range(options.rounds):
            turns = 0 if number else options.turn_frames
            plan = Plan(width, height, options.frames, options.warm, turns, options.loads)
            for name, variant in rotated(chosen, number / options.rounds):
                if name in failed:
                    continue
                try:
                    found = visit(playwright, server, variant, plan)
                except Error as error:
                    failed.add(name)
                    print(f"{name}: not measured, {error}", flush=True)
                    continue
                rounds[name].append(found)
                print(f"{name}: {json.dumps(summary([found]))}", flush=True)
                if number == 0:
                    rest[name] = once(server, variant, plan, found, truth)
                    if options.pictures:
                        save(options.pictures, name, decoded(server.pictures, plan), truth)
    return {
        name: summary(visits)
        | rest[name]
        | {"browser": f"Chromium {visits[0]['browser']}, headless"}
        for name, visits in rounds.items()
        if name not in failed
    }


def rotated(chosen: dict[str, Variant], share: float) -> list[tuple[str, Variant]]:
    """Return all variants, starting from one further in each round."""
    items = list(chosen.items())
    start = round(share * len(items))
    return items[start:] + items[:start]


def once(
    server: Server, variant: Variant, plan: Plan, found: dict[str, Any], truth: Truth
) -> dict[str, Any]:
    """Return what only the first visit measures: bytes, and errors of turning pictures."""
    pictures = decoded(server.pictures, plan)
    true = partial(truth.image, variant.scene)
    turns = [turn for turn in ("turn", "timed") if turn in found]
    return {
        "viewer_gzip_bytes": viewer_bytes(variant),
        "scene_bytes": server.scenes[variant.scene].stat().st_size,
        **{turn: errors_of(found[turn], turn, pictures, true) for turn in turns},
    }


def save(folder: Path, name: str, pictures: dict[str, np.ndarray], truth: Truth) -> None:
    """Write a viewer's first settled picture next to the reference."""
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    both = np.concatenate([pictures["first"], truth.image(VARIANTS[name].scene, 0)], 1)
    Image.fromarray(both.round().astype(np.uint8)).save(folder / f"{name}.png")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mgs", type=Path, required=True, help="the student, drawn by ours")
    parser.add_argument("--ply", type=Path, required=True, help="its teacher, drawn sorted")
    parser.add_argument("--json", type=Path, default=RESULTS / "viewer.json")
    parser.add_argument("--name", default="bonsai", help="of the scene, in the results")
    parser.add_argument("--size", default="800x533")
    parser.add_argument("--frames", type=int, default=10, help="of the slow orbit, in a round")
    parser.add_argument("--warm", type=int, default=3, help="frames before it, not counted")
    parser.add_argument("--turn-frames", type=int, default=5)
    parser.add_argument("--loads", type=int, default=20, help="more of ours, after its orbit")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--only", nargs="*", default=["*"], help="names of viewers, or patterns")
    parser.add_argument("--pictures", type=Path, help="folder for a picture of every viewer")
    options = parser.parse_args()
    figures = Figures(
        options.json,
        scene={"mgs": options.mgs.name, "ply": options.ply.name, "name": options.name},
        plan={"frames": options.frames, "rounds": options.rounds},
    )
    chosen = {
        name: variant
        for name, variant in VARIANTS.items()
        if any(fnmatch(name, pattern) for pattern in options.only)
    }
    for name, row in measure(options, read_mgs(options.mgs).views, chosen).items():
        figures.add(f"{name}, {options.size}", **row)


if __name__ == "__main__":
    main()
