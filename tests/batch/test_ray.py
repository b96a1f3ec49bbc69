"""A batch on a Ray cluster of two nodes, one of which is killed."""

import importlib.util
import json
import os
import re
import subprocess
import sys
import time
from inspect import signature
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import psutil
import pytest

from mobilegs.batch.engine import LocalEngine
from mobilegs.batch.ray_engine import RayEngine
from mobilegs.cli.batch import batch, engine_of
from mobilegs.data.demo.capture import demo_capture, write_capture
from mobilegs.errors import InputError

OPTIONS = {"steps": 150, "preset": "demo", "max_splats": 3000}
FILES = ("scene.mgs", "teacher.ply", "contact_sheet.png")
STORE = 80 << 20  # bytes of a node's object store, which the batch does not use
# a dead node is noticed after two seconds, not fifteen
HEALTH = {"RAY_health_check_period_ms": "500", "RAY_USAGE_STATS_ENABLED": "0"}
TOKEN = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": "d4f2" * 8}


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
    for name, value in (HEALTH | TOKEN).items():
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
        del environment["RAY_AUTH_MODE"]  # the batch asks for it itself
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


class DeniedError(Exception):
    """Ray's AuthenticationError."""


@pytest.mark.parametrize(
    ("address", "error", "says"),
    [
        (None, None, ""),
        ("10.0.0.1:6379", None, ""),
        (
            None,
            ConnectionError,
            "no Ray cluster answers on this machine: start one with `ray start --head`",
        ),
        ("10.0.0.1:6379", ConnectionError, "no Ray cluster answers at 10.0.0.1:6379 (RAY_ADDRESS)"),
        ("10.0.0.1:6379", DeniedError, "at 10.0.0.1:6379 (RAY_ADDRESS) needs a token: copy"),
    ],
)
def test_a_cluster_is_joined_with_a_token_or_refused_in_a_sentence(
    monkeypatch: pytest.MonkeyPatch, address: str | None, error: type[Exception] | None, says: str
) -> None:
    asked: list[tuple[str, str]] = []

    def init(address: str, **_: object) -> None:
        asked.append((address, os.environ["RAY_AUTH_MODE"]))
        if error is not None:
            raise error("a long text")

    fake: Any = ModuleType("ray")  # stands for Ray, which this test does not start
    fake.init, fake.remote, fake.__version__ = init, lambda function: function, "2.52"
    fake.exceptions = SimpleNamespace(AuthenticationError=DeniedError)
    monkeypatch.setitem(sys.modules, "ray", fake)
    for name in ("RAY_AUTH_MODE", "RAY_USAGE_STATS_ENABLED", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO"):
        monkeypatch.setenv(name, "")  # so that it is as before afterwards
        monkeypatch.delenv(name)
    monkeypatch.setenv("RAY_ADDRESS", address or "")
    if error is None:
        assert RayEngine().name == "Ray 2.52"
    else:
        with pytest.raises(InputError, match=re.escape(says)):
            RayEngine()
    assert asked == [(address or "auto", "token")]


def test_a_cluster_is_joined_only_if_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAY_ADDRESS", "10.0.0.1:6379")
    monkeypatch.setitem(sys.modules, "ray", None)  # an import of it fails
    assert signature(batch).parameters["engine"].default == "local"
    assert isinstance(engine_of("local", "cpu"), LocalEngine)
    with pytest.raises(InputError, match="--engine ray needs Ray, which is not installed"):
        engine_of("ray", "cpu")
