"""Build the source distribution and the wheels of all platforms, and check the wheels.

    make wheel                           # all, into dist/
    make wheel TARGETS=linux-x86_64      # some

This needs Linux on x86-64, whose wheel is built by its GCC: with Clang, sort-free images with their
gradients take 1.28 times as long in the build v3. The other platforms have Zig's Clang, a package
of PyPI. The library is loaded by ctypes, so that a wheel serves all versions of Python.
"""

import argparse
import os
import re
import zipfile
from dataclasses import dataclass
from pathlib import Path

import lief
import ziglang
from scikit_build_core.build import build_sdist, build_wheel

HOME = Path(__file__).parents[1]
LINUX = r"lib(c|m|dl|pthread|stdc\+\+|gcc_s)\.so\.\d|ld-linux-.*"
# the newest versions of symbols that manylinux_2_28 has, the oldest system of torch's wheels
SYMBOLS = {"GLIBC": (2, 28), "GLIBCXX": (3, 4, 25), "CXXABI": (1, 3, 11), "GCC": (8,)}


@dataclass(frozen=True)
class Target:
    """A platform, as Zig, CMake and pip name it."""

    zig: str  # empty: this machine's compiler
    system: str
    processor: str
    tag: str
    builds: tuple[str, ...]  # of csrc/binding.py
    needs: str  # libraries that each such system has, as a pattern


PORTABLE = ("portable",)
TARGETS = {
    "linux-x86_64": Target(
        "", "Linux", "x86_64", "manylinux_2_28_x86_64", ("v2", "v3", "v4"), LINUX
    ),
    "linux-aarch64": Target(
        "aarch64-linux-gnu.2.28", "Linux", "aarch64", "manylinux_2_28_aarch64", PORTABLE, LINUX
    ),
    "macos-arm64": Target(
        "aarch64-macos.11.0", "Darwin", "arm64", "macosx_11_0_arm64", PORTABLE, r"libSystem\..*"
    ),
    "windows-x86_64": Target(
        "x86_64-windows-gnu",
        "Windows",
        "AMD64",
        "win_amd64",
        PORTABLE,
        r"KERNEL32\.dll|api-ms-win-crt-.*",  # the Universal C Runtime is a part of Windows 10
    ),
}


def make_wheel(target: Target, output: Path) -> Path:
    """Build a wheel and return its path."""
    zig = Path(ziglang.__file__).with_name("zig.exe" if os.name == "nt" else "zig")
    os.environ["CXX"] = f"{zig} c++ -target {target.zig}" if target.zig else "g++"
    settings: dict[str, str | list[str]] = {
        "wheel.tags": f"py3-none-{target.tag}",
        "build-dir": f"build/{target.tag}",
        "install.strip": "false",  # the linker strips: `strip` knows this system's format alone
        "cmake.define.CMAKE_SHARED_LINKER_FLAGS": "-s",
        "cmake.define.CMAKE_SYSTEM_NAME": target.system,
        "cmake.define.CMAKE_SYSTEM_PROCESSOR": target.processor,
        "cmake.define.CMAKE_INSTALL_NAME_TOOL": "none",  # CMake asks for one that it does not use
    }
    return output / build_wheel(str(output), settings)


def check_wheel(wheel: Path, target: Target) -> None:
    """Check a wheel's tag, files and libraries.

    Raises:
        AssertionError: something is wrong; the message says what.
    """
    libraries = {f"mobilegs/csrc/libmobilegs_{build}.so" for build in target.builds}
    expected = libraries | {
        path.relative_to(HOME).as_posix()
        for path in (HOME / "mobilegs").rglob("*")
        if path.is_file() and path.suffix not in (".so", ".pyc")
    }
    with zipfile.ZipFile(wheel) as opened:
        names = {name for name in opened.namelist() if ".dist-info/" not in name}
        assert names == expected, f"files that are missing, or too many: {names ^ expected}"
        info = next(name for name in opened.namelist() if name.endswith(".dist-info/WHEEL"))
        assert f"Tag: py3-none-{target.tag}\n" in opened.read(info).decode()
        for name in libraries:
            check_library(opened.read(name), target)


def check_library(data: bytes, target: Target) -> None:
    """Check what a library exports, and what it needs."""
    library = lief.parse(list(data))
    if isinstance(library, lief.ELF.Binary):
        exported = {symbol.name for symbol in library.exported_symbols}
        needed = set(library.libraries)
        versions = [
            version.name
            for file in library.symbols_version_requirement
            for version in file.get_auxiliary_symbols()
        ]
        newer = [name for name in versions if _is_newer(*name.split("_"))]
        assert not newer, f"symbols that older systems lack: {newer}"
    elif isinstance(library, lief.MachO.Binary):
        exported = {symbol.name.removeprefix("_") for symbol in library.exported_symbols}
        needed = {Path(part.name).name for part in library.libraries if part.name[0] != "@"}
        assert library.has_code_signature, "the library is not signed"
        assert library.build_version.minos == [11, 0, 0], "it needs a newer macOS"
    else:
        exported = {entry.name for entry in library.get_export().entries}
        needed = {part.name for part in library.imports}
    missing = called_functions() - exported
    assert not missing, f"functions that are not exported: {missing}"
    others = {name for name in needed if not re.fullmatch(target.needs, name)}
    assert not others, f"libraries that a system may lack: {others}"


def called_functions() -> set[str]:
    """Return the names of the library's functions that the package calls."""
    calls = [path for path in (HOME / "mobilegs").rglob("*.py") if "cuda" not in path.name]
    # a name that ends in "_" is completed where it is used
    words = r"\bmgs_\w*[^\W_]\b"
    found = {name for path in calls for name in re.findall(words, path.read_text("utf-8"))}
    assert len(found) > 20
    return found


def _is_newer(name: str, version: str) -> bool:
    return tuple(map(int, version.split("."))) > SYMBOLS[name]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--output", type=Path, default=HOME / "dist")
    given = parser.parse_args()
    if unknown := set(given.targets) - set(TARGETS):
        parser.error(f"there is no target {unknown.pop()}: use one of {', '.join(TARGETS)}")
    os.chdir(HOME)
    output = given.output.resolve()
    print(output / build_sdist(str(output)))
    for name in given.targets or TARGETS:
        wheel = make_wheel(TARGETS[name], output)
        check_wheel(wheel, TARGETS[name])
        print(f"{wheel}: {wheel.stat().st_size / 1e6:.2f} MB, checked", flush=True)


if __name__ == "__main__":
    main()
