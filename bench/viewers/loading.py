"""Time half a million Gaussians from a local server to the screen, in headless Chromium.

    python -m bench.viewers.loading --mgs RUN/scene.mgs [--json OUT] [--count 500000] [--rounds 3]

The scene is a trained one, repeated with positions moved by 2 % of their distance from the centre
until it has `--count` Gaussians. Their scales shrink so that they cover as many pixels as before.
The streams keep the statistics of real ones, and the file has LOD levels. Times are milliseconds
from navigation in a window that has been open for some seconds, medians of visits, each in its
own browser: `first_picture` (first frame, of dots), `loaded` (everything decoded and drawn),
`decoded` (from the request until the last number is known). After a `first_visit` the browser
remembers how its device draws fastest. `alone` is the worker's time in a page that draws nothing,
the first time and later.
"""

import argparse
import json
import math
import os
import platform
import statistics
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from bench.viewers.chromium import launched
from mobilegs.mgs.codec import pack, read_mgs
from mobilegs.mgs.lod import lod_levels_for, with_lod_levels
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.view.serve import Server

SPREAD = 0.02
IDLE = 2500  # milliseconds
LISTEN = """
addEventListener("load", () => {
  const scene = document.querySelector("mobile-gs");
  window.found = {};
  const asked = new Set();
  const note = async (name) => {
    if (asked.has(name)) return;
    asked.add(name);
    await scene.viewer.finished(); // so far the frame was only asked for
    found[name] = performance.now();
  };
  scene.addEventListener("frame", () => note("first_picture"));
  scene.addEventListener("load", ({ detail }) => {
    found.decoded = detail.milliseconds;
    scene.addEventListener("frame", () => note("loaded"));
  });
});
"""

# the viewer's script is its thread's, too
DECODE = """async () => {
  const worker = new Worker("/viewer.js");
  const found = await new Promise((resolve, reject) => {
    worker.onmessage = ({ data }) => {
      if (data.kind === "done") resolve(data.milliseconds);
      if (data.kind === "failed") reject(data.sentence);
    };
    worker.postMessage({ url: `${location.origin}/scene` });
  });
  worker.terminate();
  return found;
}"""


def repeated(scene: QuantizedScene, count: int) -> QuantizedScene:
    """Return the scene repeated with small shifts."""
    generator = torch.Generator().manual_seed(0)
    rows = torch.arange(count) % len(scene)
    positions = scene.positions[rows].float()
    moved = positions * (1 + SPREAD * torch.randn(positions.shape, generator=generator))
    indices = {name: codes[rows] for name, codes in scene.indices.items()}
    whole = replace(scene, positions=moved.half(), indices=indices, lod_sizes=())
    return with_lod_levels(whole, lod_levels_for(count), scene.views)


def smaller(scene: QuantizedScene, copies: float) -> QuantizedScene:
    """Return scales so small that the copies cover as many pixels as the original."""
    less = math.log(copies) / 2
    if scene.step_sizes:
        codes = scene.indices["scale"] - round(less / scene.step_sizes["scale"])
        return replace(scene, indices=scene.indices | {"scale": codes})
    scales = scene.codebooks["scale"].float() - less
    return replace(scene, codebooks=scene.codebooks | {"scale": scales.half()})


def alone(browser: Any, address: str) -> list[float]:
    """Time decoding in a page that draws nothing, several times."""
    page = browser.new_page()
    page.goto(f"{address}/nothing")
    page.wait_for_timeout(IDLE)
    found = [page.evaluate(DECODE) for _ in range(4)]
    page.close()
    return found


def visits(browser: Any, address: str) -> list[dict[str, float]]:
    """Return the times of two visits; the first browser remembers nothing."""
    context = browser.new_context(viewport={"width": 800, "height": 533})
    found = []
    for _ in range(2):
        page = context.new_page()
        page.add_init_script(LISTEN)
        page.wait_for_timeout(IDLE)
        page.goto(address)
        page.wait_for_function("window.found && window.found.loaded", timeout=120_000)
        row = page.evaluate("window.found")
        page.evaluate("document.querySelector('mobile-gs').viewer.calibrated")
        row["device"] = page.evaluate("document.querySelector('mobile-gs').viewer.device")
        found.append(row)
        page.close()
    context.close()
    return found


def main() -> None:
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mgs", type=Path, required=True)
    parser.add_argument("--json", type=Path, default=Path("loading.json"))
    parser.add_argument("--count", type=int, default=500_000)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    trained = read_mgs(options.mgs)
    scene = smaller(repeated(trained, options.count), options.count / len(trained))
    data = pack(scene)
    result: dict[str, Any] = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "coding": "sq" if scene.step_sizes else "nvq",
        "gaussians": len(scene),
        "file_bytes": len(data),
    }
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "scene.mgs"
        path.write_bytes(data)
        server = Server(path)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for renderer in ("webgpu", "webgl"):
            rows: list[list[dict]] = []
            for _ in range(options.rounds):
                browser = launched(playwright)
                rows.append(visits(browser, f"{server.address('127.0.0.1')}&renderer={renderer}"))
                browser.close()
            result[renderer] = {
                name: {
                    key: round(statistics.median(pair[i][key] for pair in rows))
                    for key in ("first_picture", "decoded", "loaded")
                }
                for i, name in enumerate(("first_visit", "later_visit"))
            } | {"device": rows[0][0]["device"]}
            print(renderer, json.dumps(result[renderer]), flush=True)
        runs = []
        for _ in range(options.rounds):
            browser = launched(playwright)
            runs.append(alone(browser, f"http://127.0.0.1:{server.server_port}"))
            browser.close()
        server.shutdown()
        result["alone"] = {
            "first": round(statistics.median(run[0] for run in runs)),
            "later": round(statistics.median(ms for run in runs for ms in run[1:])),
        }
        print("alone", json.dumps(result["alone"]), flush=True)
    result["load_average"] = os.getloadavg()[0]
    options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
