"""A batch on a Ray cluster of several nodes, one of which dies in the middle.

    python -m bench.batch [--rows 12] [--nodes 3] [--steps 1200] [--json OUT]

The nodes are processes on this machine, with one core each, and a head that takes no tasks. The
captures are small ones of the demo's scene with other seeds. The single commands
(`mobilegs train`, `mobilegs export`) make half of the scenes before the batch and half after it, as
many at a time as the machine has cores: their seconds, shared evenly among the cores, are the ideal
time. Once half of the rows are done, all processes of a node whose training has a checkpoint get
SIGKILL. The batch must give the same bytes as the single commands.

Other programs on the machine make both times uncertain. `offered_per_used` does not depend on them:
the core-seconds that living nodes offered, over those of tasks whose work was not lost.
"""

import argparse
import csv
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil

from mobilegs.atomic import atomic_write
from mobilegs.data.demo.capture import demo_capture, write_capture

VIEWS, SIZE, POINTS, SPLATS = 24, (144, 96), 2000, 3000  # of a capture
CHECKPOINT_SECONDS = 1
STORE = 80 << 20  # bytes of a node's object store, which the batch does not use
SAME = ("scene.mgs", "teacher.ply", "contact_sheet.png")
COMMAND = (sys.executable, "-m", "mobilegs")


def write_list(folder: Path, rows: int, steps: int, size: tuple[int, int]) -> Path:
    """Write captures and their list."""
    lines = []
    for number in range(rows):
        name = f"scene-{number + 1:02}"
        capture = demo_capture(
            views=VIEWS, width=size[0], height=size[1], points=POINTS, seed=number
        )
        write_capture(folder / name, capture)
        lines.append({"name": name, "source": name, "steps": steps, "seed": number})
    with (folder / "list.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, lines[0])
        writer.writeheader()
        writer.writerows(lines)
    return folder / "list.csv"


def options(row: dict[str, str]) -> list[str]:
    """Return the options of a row for `mobilegs train`."""
    words = ["--steps", row["steps"], "--seed", row["seed"], "--preset", "demo", "--device", "cpu"]
    return [*words, "--max-splats", str(SPLATS)]


def single(folder: Path, row: dict[str, str], runs: Path) -> float:
    """Make one scene by the single commands on one core; return the seconds."""
    started, run = time.monotonic(), runs / row["name"]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    for words in (
        ["train", str(folder / row["source"]), "-o", str(run), *options(row)],
        ["export", str(run), "--to", "html", "-o", str(run / f"{row['name']}.html")],
    ):
        subprocess.run([*COMMAND, *words], check=True, env=environment, capture_output=True)
    return time.monotonic() - started


def singles(folder: Path, rows: list[dict[str, str]], cores: int) -> list[float]:
    """Make scenes by the single commands, one at a time on each core; return their seconds."""
    with ThreadPoolExecutor(cores) as pool:
        return list(pool.map(lambda row: single(folder, row, folder / "single"), rows))


class Nodes:
    """A Ray cluster on this machine; `kill` ends a node as a power failure does."""

    def __init__(self, number: int) -> None:
        os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
        from ray.cluster_utils import Cluster

        store = {"object_store_memory": STORE}
        head = {"num_cpus": 0, "include_dashboard": False, **store}
        self._cluster: Any = Cluster(initialize_head=True, head_node_args=head)
        self._nodes = [self._cluster.add_node(num_cpus=1, **store) for _ in range(number)]
        self._cluster.wait_for_nodes()
        self.address = self._cluster.address

    def kill(self, pids: Sequence[int]) -> int | None:
        """Kill the node that runs one of the processes; return which process, if there is one."""
        for node in self._nodes:
            raylet = psutil.Process(node.all_processes["raylet"][0].process.pid)
            own = [raylet, *raylet.children(recursive=True)]
            found = [each.pid for each in own if each.pid in pids]
            if found:
                for each in own:
                    try:
                        each.kill()
                    except psutil.NoSuchProcess:
                        pass
                return found[0]
        return None

    def shutdown(self) -> None:
        """End all nodes."""
        self._cluster.shutdown()


@contextmanager
def cluster(number: int) -> Iterator[Nodes]:
    """Start a cluster of nodes with one core each."""
    nodes = Nodes(number)
    try:
        yield nodes
    finally:
        nodes.shutdown()


def results(output: Path) -> list[dict[str, Any]]:
    """Return the lines of `results.jsonl`."""
    return [json.loads(line) for line in (output / "results.jsonl").read_text().splitlines()]


def progress(output: Path) -> tuple[int, dict[int, str]]:
    """Return the number of rows that are done, and the processes of trainings with a checkpoint.

    Each process comes with the name of its row.
    """
    done, training = 0, {}
    for file in output.glob("*/batch/events.jsonl"):
        row, lines = file.parent.parent, file.read_text().splitlines()
        last = json.loads(lines[-1]) if lines else {"event": "", "stage": ""}
        done += last["stage"] == "export" and last.get("result") == "done"
        checkpoint = (row / "checkpoint.safetensors").exists()
        if last["event"] == "started" and last["stage"] == "train" and checkpoint:
            training[last["pid"]] = row.name
    return done, training


def batch(listed: Path, output: Path, nodes: Nodes, rows: int) -> dict[str, Any]:
    """Run the batch and kill a node in the middle; return the times."""
    defaults = {
        "preset": "demo",
        "max_splats": SPLATS,
        "checkpoint_seconds": CHECKPOINT_SECONDS,
    }
    words = [f"{name}={value}" for name, value in defaults.items()]
    command = [*COMMAND, "batch", str(listed), "-o", str(output), "--engine", "ray"]
    command += ["--cores", "1", "--default", *words]
    started, killed = time.monotonic(), None
    with (output.parent / "batch.txt").open("w") as log:
        environment = os.environ | {"RAY_ADDRESS": nodes.address}
        process = subprocess.Popen(command, stdout=log, stderr=log, env=environment)
        while process.poll() is None:
            done, training = progress(output)
            if killed is None and 2 * done >= rows - 1:
                pid = nodes.kill(list(training))
                if pid is not None:
                    after = round(time.monotonic() - started, 1)
                    killed = {"row": training[pid], "seconds": after, "done": done}
            time.sleep(0.1)
    seconds = time.monotonic() - started
    print((output.parent / "batch.txt").read_text())
    return {"seconds": seconds, "exit_code": process.returncode, "killed": killed}


def offered_per_used(output: Path, seconds: float, nodes: int, killed: float | None) -> float:
    """Return the core-seconds of living nodes over those of tasks whose work was not lost.

    Nodes have one core each. Other programs on the machine slow both down.
    """
    offered = nodes * seconds - (0.0 if killed is None else seconds - killed)
    used = 0.0
    for file in output.glob("*/batch/events.jsonl"):
        for event in map(json.loads, file.read_text().splitlines()):
            used += event["seconds"] if event.get("result") == "done" else 0.0
    return offered / used


def measure(
    rows: int, nodes: int, steps: int, size: tuple[int, int], folder: Path
) -> dict[str, Any]:
    """Make all scenes by single commands and by a batch, and compare."""
    listed, cores = write_list(folder, rows, steps, size), os.cpu_count() or 1
    with listed.open() as file:
        lines = list(csv.DictReader(file))
    load = os.getloadavg()[0]
    seconds = singles(folder, lines[::2], cores)
    with cluster(nodes) as started_nodes:
        found = batch(listed, folder / "batch", started_nodes, rows)
    load_after = os.getloadavg()[0]
    seconds += singles(folder, lines[1::2], cores)
    ideal = sum(seconds) / cores
    entries = results(folder / "batch")
    done = [each["name"] for each in entries if each["state"] == "done"]

    def same(names: Sequence[str]) -> int:
        """Return the number of rows whose files are those of the single commands."""
        files = {name: [file.format(name=name) for file in names] for name in done}
        one, other = folder / "single", folder / "batch"
        return sum(
            all((one / n / f).read_bytes() == (other / n / f).read_bytes() for f in files[n])
            for n in done
        )

    return {
        "rows": rows,
        "nodes": nodes,
        "steps": steps,
        "size": size,
        "cores": cores,
        "load": [round(load, 2), round(load_after, 2)],
        "single_seconds": [round(each, 1) for each in seconds],
        "ideal_seconds": round(ideal, 1),
        "batch_seconds": round(found["seconds"], 1),
        "batch_per_ideal": round(found["seconds"] / ideal, 3),
        "offered_per_used": round(
            offered_per_used(
                folder / "batch",
                found["seconds"],
                nodes,
                found["killed"] and found["killed"]["seconds"],
            ),
            3,
        ),
        "exit_code": found["exit_code"],
        "killed": found["killed"],
        "done": len(done),
        "same_bytes": same(SAME),
        "same_pages": same(["{name}.html"]),  # if nobody changed the viewer meanwhile
        "tries": {each["name"]: each["tries"] for each in entries},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=int, default=12)
    parser.add_argument("--nodes", type=int, default=3)
    parser.add_argument("--steps", type=int, default=1200)
    parser.add_argument("--size", type=int, nargs=2, default=SIZE, help="of photos")
    parser.add_argument("--folder", type=Path, help="keep captures and runs here")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    import ray

    about = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": platform.machine(),
        "ray": ray.__version__,
    }
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        found = about | measure(given.rows, given.nodes, given.steps, tuple(given.size), folder)
    text = json.dumps(found, indent=2)
    print(text)
    if given.json:
        atomic_write(given.json, f"{text}\n")


if __name__ == "__main__":
    main()
