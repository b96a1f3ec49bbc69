"""Open and close a scene in one page hundreds of times, and watch the browser's memory.

    python -m bench.soak.page SCENE [--times 500] [--renderer webgl] [--json OUT]

Half of the times the element is removed and made again, half of the times its `src` changes. After
every tenth of the times the page collects its garbage; then heap, nodes, listeners and workers are
counted, and the memory of all of the browser's processes.
"""

import argparse
import json
import sys
import threading
import time
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import CDPSession, sync_playwright

from bench.soak.record import add_record
from bench.viewers.chromium import launched
from mobilegs.view.serve import Server

MIB = 1 << 20
SHARES = 10  # of the times, after which the page is measured
OPEN = """async ([address, remake, renderer]) => {
  let element = document.querySelector("mobile-gs");
  if (remake) {
    element.remove();
    element = document.createElement("mobile-gs");
    element.setAttribute("renderer", renderer);
    element.style.cssText = "position: fixed; inset: 0";
  } else element.removeAttribute("src");
  const loaded = new Promise((resolve, reject) => {
    element.addEventListener("load", resolve, { once: true });
    element.addEventListener("error", ({ detail }) => reject(detail.sentence), { once: true });
  });
  element.setAttribute("src", address);
  if (!element.isConnected) document.body.append(element);
  await loaded;
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
}"""


def measured(session: CDPSession, workers: int) -> dict[str, float]:
    """Collect the page's garbage, and count what is left."""
    for _ in range(3):
        session.send("HeapProfiler.collectGarbage")
    found = {row["name"]: row["value"] for row in session.send("Performance.getMetrics")["metrics"]}
    family = psutil.Process().children(recursive=True)
    memory = 0
    for process in family:
        try:
            memory += process.memory_info().rss
        except psutil.Error:  # it has just ended
            pass
    return {
        "heap_mib": round(found["JSHeapUsedSize"] / MIB, 2),
        "nodes": int(found["Nodes"]),
        "listeners": int(found["JSEventListeners"]),
        "workers": workers,
        "browser_mib": round(memory / MIB),
    }


def soak(scene: Path, times: int, renderer: str) -> dict[str, Any]:
    """Open and close a scene, and return the measurements as JSON data."""
    server = Server(scene)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    complaints: list[str] = []
    with sync_playwright() as playwright:
        browser = launched(playwright)
        page = browser.new_page(viewport={"width": 390, "height": 640})
        page.on("pageerror", lambda error: complaints.append(str(error)))
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        page.goto(server.address("127.0.0.1") + f"&renderer={renderer}")
        page.wait_for_function(
            "document.querySelector('mobile-gs')?.dataset.state === 'loaded'", timeout=120_000
        )
        rows, started = [measured(session, len(page.workers))], time.monotonic()
        share = max(1, times // SHARES)
        for number in range(1, times + 1):
            page.evaluate(OPEN, [f"/scene?{number}", number % 2 == 0, renderer])
            if number % share == 0:
                rows.append({"opened": number, **measured(session, len(page.workers))})
                print(json.dumps(rows[-1]), flush=True)
        seconds = time.monotonic() - started
        browser.close()
    server.shutdown()
    server.server_close()
    return {
        "times": times,
        "renderer": renderer,
        "seconds": round(seconds),
        "rows": rows,
        "errors": complaints,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path, help=".mgs file")
    parser.add_argument("--times", type=int, default=500)
    parser.add_argument("--renderer", choices=["webgl", "webgpu"], default="webgl")
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    options = parser.parse_args()
    found = soak(options.scene, options.times, options.renderer)
    add_record(options.json, f"page, {options.renderer}", found)
    if found["errors"]:
        sys.exit(f"the page reported {len(found['errors'])} errors: {found['errors'][0]}")


if __name__ == "__main__":
    main()
