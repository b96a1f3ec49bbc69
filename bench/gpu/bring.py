"""Fills the folder that travels to a machine without network, beside the repository.

    python bench/gpu/bring.py [--captures bonsai lpips] [--wheels] [--parcel FOLDER] [--debs FOLDER]

runs/brought then has the captures of MOBILEGS_DATA that are named, the wheels of wheels.txt, and
the parcel that an earlier call left in FOLDER; bench/gpu/run.sh takes in what it finds there. What
several calls bring adds up on the machine. The exit code is 1 if folder and repository together
have more than 64 MiB (`--most`).
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
PLATFORMS = ("manylinux_2_28_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64")


def repository_bytes() -> int:
    """Of all files that git knows or does not ignore."""
    asked = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(asked, cwd=ROOT, check=True, capture_output=True).stdout.split(b"\0")
    paths = [ROOT / os.fsdecode(name) for name in names if name]
    return sum(path.lstat().st_size for path in paths if path.is_file())


def bytes_of(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def fetch_wheels(folder: Path, python: str) -> None:
    """The wheels of wheels.txt, for a Python version on x86-64."""
    asked = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--only-binary=:all:"]
    asked += ["--python-version", python, "--implementation", "cp", "-d", str(folder)]
    asked += [word for name in PLATFORMS for word in ("--platform", name)]
    subprocess.run([*asked, "-r", str(HERE / "wheels.txt")], check=True)


def copy(folder: Path, pattern: str, to: Path) -> None:
    """The files under a folder; they may be changed and removed, whatever they came from."""
    found = [path for path in sorted(folder.rglob(pattern)) if path.is_file()]
    if not found:
        sys.exit(f"there is no {pattern} in {folder}")
    for path in found:
        target = to / path.relative_to(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)


def fill(options: argparse.Namespace) -> None:
    """Make the folder anew."""
    to = options.to
    shutil.rmtree(to, ignore_errors=True)
    to.mkdir(parents=True)
    for name in options.captures:
        if options.data is None or not (Path(options.data) / name).is_dir():
            sys.exit(
                f"there is no {name} in {options.data}: --data, or MOBILEGS_DATA, names another"
            )
        copy(Path(options.data) / name, "*", to / "data" / name)
    if options.wheels:
        fetch_wheels(to / "wheels", options.python)
    if options.parcel is not None:
        copy(options.parcel, "parcel-*.bin", to / "parcel")
    if options.debs is not None:
        copy(options.debs, "*.deb", to / "debs")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--captures", nargs="+", default=[], metavar="NAME")
    parser.add_argument("--data", default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--wheels", action="store_true")
    parser.add_argument("--python", default="3.12", help="the machine's, for which wheels are")
    parser.add_argument("--parcel", type=Path, metavar="FOLDER")
    parser.add_argument("--debs", type=Path, metavar="FOLDER", help="such as libvulkan1's package")
    parser.add_argument("--to", type=Path, default=ROOT / "runs" / "brought")
    parser.add_argument("--most", type=float, default=64, metavar="MIB")
    options = parser.parse_args()
    fill(options)
    total = repository_bytes()
    print(f"{total / 2**20:6.1f} MiB  repository")
    for path in sorted(options.to.glob("*/*")):
        size = bytes_of(path) if path.is_dir() else path.stat().st_size
        total += size
        print(f"{size / 2**20:6.1f} MiB  {path.relative_to(options.to)}")
    print(f"{total / 2**20:6.1f} MiB  together")
    if total > options.most * 2**20:
        sys.exit(f"more than {options.most:g} MiB: bring it in several calls")


if __name__ == "__main__":
    main()
