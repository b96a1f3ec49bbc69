"""The wheel of `make wheel`, installed where there is no compiler."""

import os
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
@pytest.mark.timeout(3600)
def test_the_demo_runs_from_a_wheel_without_a_compiler(tmp_path: Path) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / "bin"
    subprocess.run([programs / "pip", "install", "--no-deps", WHEELS[-1]], check=True)
    # what it depends on comes from this environment, for torch has gigabytes
    places = {name: sysconfig.get_path(name) for name in ("purelib", "platlib")}
    (site,) = (tmp_path / "venv").glob("lib/python*/site-packages")
    (site / "dependencies.pth").write_text("\n".join(places.values()))
    bare = {"PATH": str(programs), "HOME": os.environ.get("HOME", "/")}
    demo = [programs / "mobilegs", "demo", "-o", tmp_path / "demo"]
    subprocess.run(demo, check=True, env=bare, cwd=tmp_path)
    assert (tmp_path / "demo" / "scene.mgs").stat().st_size > 100_000
