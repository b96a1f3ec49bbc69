"""Run the tests that a state of the machine affects, in that state: `make test-states`.

    python -m tests.states             # every state
    python -m tests.states opengl c    # some
    python -m tests.states --list

States are emulated: variables hide drivers, a folder of links hides programs, and namespaces of
Linux hide the network and the privileges of root. A state that cannot be emulated here is named.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
NOWHERE = "/nonexistent"
NO_VULKAN = {"VK_DRIVER_FILES": NOWHERE, "VK_ICD_FILENAMES": NOWHERE}
NO_GPU = NO_VULKAN | {"__EGL_VENDOR_LIBRARY_FILENAMES": NOWHERE}
RENDERERS = ("tests/view/test_wgpu_renderer.py", "tests/view/test_window.py")
COMMAND_LINE = ("tests/cli", "tests/view/test_export.py")
UNSHARE = ("unshare", "--net", "--map-root-user")
PROGRAMS = re.compile(
    r"(chromium|google-chrome|node|npm|npx|ffmpeg|ffprobe|(.*-)?(cc|c\+\+|gcc|g\+\+|clang|clang\+\+|cpp)"
    r"(-[\d.]+)?|wasm-ld(-\d+)?|make|cmake|ninja|git)"
)


@dataclass(frozen=True)
class State:
    """A state of the machine.

    Attributes:
        tests: the tests that it affects.
        about: the state in a few words.
        environment: variables that make it.
        prefix: a command that runs another one in it.
        hidden: True to hide the programs of `PROGRAMS`.
    """

    about: str
    tests: tuple[str, ...]
    environment: dict[str, str] = field(default_factory=dict)
    prefix: tuple[str, ...] = ()
    hidden: bool = False


STATES = {
    "bare": State(
        "no GPU renderer, browser, compiler, Node.js, ffmpeg or git",
        (*RENDERERS, "tests/cli", "tests/view", "tests/web", "tests/fuzz/test_fuzz.py",
         "tests/render/test_cuda_on_host.py", "tests/bench/test_modules.py",
         "tests/bench/test_phone.py", "tests/bench/test_record.py", "tests/csrc"),
        NO_GPU,
        hidden=True,
    ),
    "opengl": State("OpenGL and no Vulkan", (*RENDERERS, "tests/cli/test_main.py"), NO_VULKAN),
    "vulkan": State("Vulkan in software", RENDERERS, {"__EGL_VENDOR_LIBRARY_FILENAMES": NOWHERE}),
    "offline": State(
        "no network but the machine's own",
        ("tests/view", "tests/batch", "tests/live", "tests/web/test_viewer.py"),
        prefix=(*UNSHARE, "sh", "-c", 'ip link set lo up && exec "$@"', "-"),
    ),
    "user": State(
        "no privileges of root",
        ("tests/test_atomic.py", "tests/cli/test_main.py", "tests/pipeline/test_run_folder.py",
         "tests/view/test_export.py"),
        prefix=("setpriv", "--bounding-set=-all", "--inh-caps=-all", "--no-new-privs"),
    ),
    "c": State(
        "locale C",
        ("tests/cli/test_main.py", "tests/capture/test_photos.py"),
        {"LC_ALL": "C", "LANG": "C"},
    ),
    "ascii": State(
        "locale C without UTF-8",
        COMMAND_LINE,
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ),
}  # fmt: skip


def links_without_programs(folder: Path) -> None:
    """Fill a folder with links to all programs on PATH but those of `PROGRAMS`."""
    for place in os.environ["PATH"].split(os.pathsep):
        if not Path(place).is_dir():
            continue
        for program in Path(place).iterdir():
            link = folder / program.name
            if not PROGRAMS.fullmatch(program.name) and not link.is_symlink():
                link.symlink_to(program)


def run(state: State, arguments: list[str]) -> tuple[int, str]:
    """Run the state's tests; return the exit code and pytest's last lines."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", **state.environment}
    with tempfile.TemporaryDirectory() as folder:
        if state.hidden:
            links_without_programs(Path(folder))
            environment["PATH"] = folder
        command = [*state.prefix, sys.executable, "-m", "pytest", "--numprocesses", "auto"]
        command += ["--dist", "loadfile", "-q", "--color=no", *state.tests, *arguments]
        process = subprocess.Popen(
            command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        lines = []
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line.strip())
    last = [line for line in lines[-3:] if re.search(" passed| failed|not run", line)]
    return process.wait(), "; ".join(last)


def main() -> int:
    parser = argparse.ArgumentParser(description="Run tests in states of the machine.")
    parser.add_argument("states", nargs="*", metavar="STATE", help=", ".join(STATES))
    parser.add_argument("--list", action="store_true", help="list the states")
    given, arguments = parser.parse_known_args()
    if unknown := set(given.states) - STATES.keys():
        parser.error(f"there is no state {', '.join(unknown)}")
    if given.list:
        print("\n".join(f"{name:8} {state.about}" for name, state in STATES.items()))
        return 0
    results = {}
    for name in given.states or STATES:
        state = STATES[name]
        if state.prefix and subprocess.run([*state.prefix, "true"], capture_output=True).returncode:
            results[name] = (0, f"not emulated here: {' '.join(state.prefix[:2])} is not allowed")
            continue
        print(f"--- {name}: {state.about}", flush=True)
        results[name] = run(state, arguments)
    print("--- states")
    for name, (code, last) in results.items():
        print(f"{name:8} {'failed' if code else 'passed'}  {STATES[name].about}: {last}")
    return 1 if any(code for code, _ in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
