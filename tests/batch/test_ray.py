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

OPTIONS = {"steps": 150, "preset": "demo", "max_splats": 3000}
FILES = ("scene.mgs", "teacher.ply", "contact_sheet.png")
STORE = 80 << 20  # bytes of a node's object store, which the batch does not use
# a dead node is noticed after two seconds, not fifteen
HEALTH = {"RAY_health_check_period_ms": "500", "RAY_USAGE_STATS_ENABLED": "0"}


def node_killed(row: Path, nodes: list[Any]) -> bool:
    """Kill the node of a row's training that has a checkpoint; return whether there was one."""
    events = row / "batch" / "events.jsonl"
    if not events.exists() or not (row / "checkpoint.safetensors").exists():
        return False
    event = json.loads(events.read_text().splitlines()[-1])
    for node in nodes:
        raylet = psutil.Process(node.all_processes["raylet"][0].process.pid)
        processes = [raylet, *raylet.children(recursive=True)]
        started = (event.get("stage"), event["event"]) == ("train", "started")
        if started and event["pid"] in {each.pid for each in processes}:
            for each in processes:
                each.kill()
            return True
    return False


@pytest.mark.thorough
@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="needs Ray (the extra batch)")
@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_a_row_is_made_with_the_same_bytes_although_its_node_dies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_capture(tmp_path / "one", demo_capture(views=24, width=48, height=32, points=2000))
    (tmp_path / "list.csv").write_text("name,source\none,one\n")
    for name, value in HEALTH.items():
        monkeypatch.setenv(name, value)
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": STORE}
    cluster: Any = Cluster(initialize_head=True, head_node_args=head)
    output, killed, printed = tmp_path / "batch", False, tmp_path / "batch.txt"
    try:
        nodes = [cluster.add_node(num_cpus=1, object_store_memory=STORE) for _ in range(2)]
        cluster.wait_for_nodes()
        defaults = [f"{name}={value}" for name, value in OPTIONS.items()]
        defaults.append("checkpoint_seconds=0.2")
        program = [sys.executable, "-m", "mobilegs", "batch", str(tmp_path / "list.csv")]
        program += ["-o", str(output), "--engine", "ray", "--cores", "1", "--default", *defaults]
        environment = os.environ | {"RAY_ADDRESS": cluster.address}
        with printed.open("w") as log:
            process = subprocess.Popen(program, stdout=log, stderr=log, env=environment)
            while process.poll() is None:
                killed = killed or node_killed(output / "one", nodes)
                time.sleep(0.1)
    finally:
        cluster.shutdown()
    said = printed.read_text()
    assert process.returncode == 0 and killed, said
    assert "one: training was lost (its machine" in said
    [line] = map(json.loads, (output / "results.jsonl").read_text().splitlines())
    assert (line["state"], line["tries"]) == ("done", 3)  # two trainings and an export
    words = [f"--{name.replace('_', '-')}={value}" for name, value in OPTIONS.items()]
    program = [sys.executable, "-m", "mobilegs", "train", str(tmp_path / "one"), *words]
    program += ["-o", str(tmp_path / "single"), "--device=cpu"]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    subprocess.run(program, check=True, env=environment, capture_output=True)
    for file in FILES:
        assert (tmp_path / "single" / file).read_bytes() == (output / "one" / file).read_bytes()
