"""The wheel of `make wheel`, installed where there is no compiler."""

import os
import signal
import subprocess
import sysconfig
import venv
from pathlib import Path

import pytest

WHEELS = sorted((Path(__file__).parents[1] / "dist").glob("*-manylinux_*_x86_64.whl"))


@pytest.mark.thorough
@pytest.mark.skipif(
    not WHEELS or sysconfig.get_platform() != "linux-x86_64",
    reason="needs a wheel for this machine (make wheel)",
)
@pytest.mark.timeout(1800)
def test_a_demo_and_a_training_run_from_a_wheel_without_a_compiler(tmp_path: Path) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / "bin"
    subprocess.run([programs / "pip", "install", "--no-deps", WHEELS[-1]], check=True)
    # what it depends on comes from this environment, for torch has gigabytes
    places = {name: sysconfig.get_path(name) for name in ("purelib", "platlib")}
    (site,) = (tmp_path / "venv").glob("lib/python*/site-packages")
    (site / "dependencies.pth").write_text("\n".join(places.values()))
    bare = {"PATH": str(programs), "HOME": os.environ.get("HOME", "/")}
    program, demo, run = programs / "mobilegs", tmp_path / "demo", tmp_path / "run"
    # the demo, until it has made its capture and trains; then a training that is over sooner
    with subprocess.Popen(
        [program, "demo", "-o", demo], stdout=subprocess.PIPE, text=True, env=bare, cwd=tmp_path
    ) as process:
        assert process.stdout is not None
        assert any(line.startswith("training the teacher") for line in process.stdout)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
    assert process.returncode == 130 and not (demo / "scene.mgs").exists()
    short = [program, "train", demo / "capture", "-o", run, "--preset", "demo", "--steps", "240"]
    subprocess.run(short, check=True, env=bare, cwd=tmp_path)
    assert (run / "scene.mgs").stat().st_size > 50_000
