"""A batch on a Ray cluster of two nodes, one of which is killed."""

import importlib.util
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from mobilegs.data.demo.capture import demo_capture, write_capture

NAMES = ("one", "two")
OPTIONS = {"steps": 150, "preset": "demo", "max_splats": 3000}
FILES = ("scene.mgs", "teacher.ply", "contact_sheet.png")
STORE = 80 << 20  # bytes of a node's object store, which the batch does not use
# a dead node is noticed after two seconds, not fifteen
HEALTH = {"RAY_health_check_period_ms": "500", "RAY_USAGE_STATS_ENABLED": "0"}
# all single commands in one process, which imports torch once
SINGLES = """
import sys
from pathlib import Path
from mobilegs.cli.main import main
folder = Path(sys.argv[1])
for name in sys.argv[2].split():
    main(["train", str(folder / name), "-o", str(folder / "single" / name), *sys.argv[3:]])
"""


def killed_row(output: Path, nodes: list[Any]) -> str | None:
    """Kill the node of a training that has a checkpoint; return its row, None if there is none."""
    for file in output.glob("*/batch/events.jsonl"):
        event = json.loads(file.read_text().splitlines()[-1])
        row = file.parent.parent
        if event.get("stage") != "train" or not (row / "checkpoint.safetensors").exists():
            continue
        for node in nodes:
            raylet = psutil.Process(node.all_processes["raylet"][0].process.pid)
            processes = [raylet, *raylet.children(recursive=True)]
            if event["event"] == "started" and event["pid"] in {each.pid for each in processes}:
                for each in processes:
                    each.kill()
                return row.name
    return None


@pytest.mark.thorough
@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="needs Ray (the extra batch)")
@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_all_rows_are_made_with_the_same_bytes_although_a_node_dies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed, name in enumerate(NAMES):
        capture = demo_capture(views=24, width=48, height=32, points=2000, seed=seed)
        write_capture(tmp_path / name, capture)
    single = os.environ | {"OMP_NUM_THREADS": "1"}
    words = [f"--{name.replace('_', '-')}={value}" for name, value in OPTIONS.items()]
    program = [sys.executable, "-c", SINGLES, str(tmp_path), " ".join(NAMES), *words]
    subprocess.run([*program, "--device=cpu"], check=True, env=single, capture_output=True)

    (tmp_path / "list.csv").write_text("\n".join(["name,source", *(f"{n},{n}" for n in NAMES)]))
    for name, value in HEALTH.items():
        monkeypatch.setenv(name, value)
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": STORE}
    cluster: Any = Cluster(initialize_head=True, head_node_args=head)
    output, killed, printed = tmp_path / "batch", None, tmp_path / "batch.txt"
    try:
        nodes = [cluster.add_node(num_cpus=1, object_store_memory=STORE) for _ in NAMES]
        cluster.wait_for_nodes()
        defaults = [f"{name}={value}" for name, value in OPTIONS.items()]
        defaults.append("checkpoint_seconds=0.2")
        program = [sys.executable, "-m", "mobilegs", "batch", str(tmp_path / "list.csv")]
        program += ["-o", str(output), "--engine", "ray", "--cores", "1", "--default", *defaults]
        environment = os.environ | {"RAY_ADDRESS": cluster.address}
        with printed.open("w") as log:
            process = subprocess.Popen(program, stdout=log, stderr=log, env=environment)
            while process.poll() is None:
                killed = killed or killed_row(output, nodes)
                time.sleep(0.1)
    finally:
        cluster.shutdown()
    said = printed.read_text()
    assert process.returncode == 0 and killed is not None, said
    assert f"{killed}: training was lost (its machine" in said
    for line in map(json.loads, (output / "results.jsonl").read_text().splitlines()):
        assert line["state"] == "done"
        assert line["tries"] == (3 if line["name"] == killed else 2)  # trainings and an export
    for file in (f"{name}/{each}" for name in NAMES for each in FILES):
        assert (tmp_path / "single" / file).read_bytes() == (output / file).read_bytes(), file
