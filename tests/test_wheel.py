"""The wheel for this machine, installed where there is no compiler."""

import os
import platform
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]


@pytest.mark.thorough
@pytest.mark.skipif(platform.machine() != "x86_64" or sys.platform != "linux", reason="no wheel")
@pytest.mark.timeout(3600)
def test_the_demo_runs_from_a_wheel_without_a_compiler(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="`make wheel` installs it")
    build = [sys.executable, HERE / "tools" / "make_wheels.py", "linux-x86_64"]
    subprocess.run([*build, "--output", tmp_path], check=True)
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / "bin"
    (wheel,) = tmp_path.glob("*.whl")
    subprocess.run([programs / "pip", "install", "--no-deps", wheel], check=True)
    # what it depends on comes from this environment, for torch has gigabytes
    places = {name: sysconfig.get_path(name) for name in ("purelib", "platlib")}
    (site,) = (tmp_path / "venv").glob("lib/python*/site-packages")
    (site / "dependencies.pth").write_text("\n".join(places.values()))
    bare = {"PATH": str(programs), "HOME": os.environ.get("HOME", "/")}
    demo = [programs / "mobilegs", "demo", "-o", tmp_path / "demo"]
    subprocess.run(demo, check=True, env=bare, cwd=tmp_path)
    assert (tmp_path / "demo" / "scene.mgs").stat().st_size > 100_000
