"""What this machine can do, and what to install for what it cannot."""

import importlib
import importlib.util
import os
import platform
import shutil
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

SHOWN = 160  # characters of somebody else's error


@dataclass(frozen=True)
class Finding:
    """One thing looked at.

    `state` is `yes`, `no` where something useful could be installed, or `none` where the
    machine simply lacks it.
    """

    what: str
    state: Literal["yes", "no", "none"]
    found: str
    remedy: str = ""


def examine() -> list[Finding]:
    """Everything that decides what mobilegs can do here; nothing is changed."""
    return [
        version(),
        python(),
        torch(),
        memory(),
        compiler(),
        cpu_kernels(),
        gpu(),
        gpu_kernels(),
        gpu_renderer(),
        window(),
        phones(),
        capture(),
        live(),
        lpips_weights(),
    ]


def as_json(findings: list[Finding]) -> list[dict[str, Any]]:
    """The findings as plain data."""
    return [asdict(finding) for finding in findings]


def version() -> Finding:
    from mobilegs import __version__

    return Finding("mobilegs", "yes", f"{__version__}, {Path(__file__).parents[1]}")


def python() -> Finding:
    where = f"{platform.python_version()} on {platform.system()} {platform.machine()}"
    return Finding("Python", "yes", f"{where}, {sys.executable}")


def torch() -> Finding:
    import torch

    build = f"CUDA {torch.version.cuda}" if torch.version.cuda else "CPU only"
    cores, threads = os.cpu_count(), torch.get_num_threads()
    used = f"{threads} of {cores} CPU cores are used"
    return Finding("PyTorch", "yes", f"{torch.__version__} ({build}), {used}")


def memory() -> Finding:
    try:
        total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return Finding("Memory", "none", "this system does not say")
    return Finding("Memory", "yes", f"{total / (1 << 30):.1f} GiB")


def compiler() -> Finding:
    path = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if path:
        return Finding("C++ compiler", "yes", path)
    remedies = {"Darwin": "xcode-select --install", "Windows": "Visual Studio's build tools"}
    remedy = remedies.get(platform.system(), "apt-get install g++, or what your system calls it")
    return Finding("C++ compiler", "no", "none; needed only to install from source", remedy)


def cpu_kernels() -> Finding:
    """Which of the compiled libraries this processor runs."""
    from mobilegs.csrc.binding import LEVELS, cpu_flags, kernel_level

    flags = cpu_flags()
    able = [level for level, needed in LEVELS.items() if needed and needed <= flags]
    runs = f"this CPU runs {', '.join(able)}" if able else "instruction sets unknown"
    try:
        return Finding("CPU kernels", "yes", f"using {kernel_level()}; {runs}")
    except ImportError as error:
        return Finding("CPU kernels", "no", f"not built; {runs}", str(error))


def gpu() -> Finding:
    import torch

    if torch.cuda.is_available():
        properties = torch.cuda.get_device_properties(0)
        size = f"{properties.total_memory / (1 << 30):.0f} GiB"
        major, minor = properties.major, properties.minor
        return Finding("GPU", "yes", f"{properties.name}, {size}, sm_{major}{minor}")
    if not has_nvidia():
        return Finding("GPU", "none", "no NVIDIA GPU: training runs on the CPU")
    if torch.version.cuda is None:
        remedy = "install a CUDA build of torch, see https://pytorch.org/get-started/locally"
        return Finding("GPU", "no", "there is one, but this torch is built for the CPU", remedy)
    remedy = f"bring the NVIDIA driver to a version that supports CUDA {torch.version.cuda}"
    return Finding("GPU", "no", "there is one, but torch cannot open it", remedy)


def has_nvidia() -> bool:
    """Whether there is a graphics card of NVIDIA's, usable or not."""
    return Path("/proc/driver/nvidia").exists() or shutil.which("nvidia-smi") is not None


def gpu_kernels() -> Finding:
    """Whether CUDA kernels can be compiled, which needs libraries but no GPU and no toolkit."""
    remedy = "pip install 'mobilegs[cuda]'"
    if not all(find_module(name) for name in ("cuda.core", "cuda.bindings")):
        if not has_nvidia():
            return Finding("CUDA kernels", "none", "not installed, and without a GPU not needed")
        return Finding("CUDA kernels", "no", "cuda-core is not installed; needed for a GPU", remedy)
    try:
        core = importlib.import_module("cuda.core")  # loads its contents in a way types cannot see
        options = core.ProgramOptions(arch="sm_80")
        core.Program('extern "C" __global__ void probe() {}', "c++", options).compile("cubin")
    except Exception as error:  # whatever breaks a half-installed driver stack is worth showing
        why = " ".join(str(error).split())[:SHOWN]
        if not has_nvidia():
            why = f"NVRTC does not compile, and without a GPU need not ({why})"
            return Finding("CUDA kernels", "none", why)
        return Finding("CUDA kernels", "no", f"NVRTC does not compile ({why})", remedy)
    return Finding("CUDA kernels", "yes", "NVRTC compiles them on first use")


def gpu_renderer() -> Finding:
    """Which device draws scenes as the viewers do."""
    from mobilegs.errors import InputError
    from mobilegs.view.wgpu_device import adapter

    try:
        about = adapter().info
    except InputError as error:
        found, _, remedy = str(error).partition(": ")
        return Finding("GPU renderer", "no", found, remedy)
    slow = ", in software: slow" if about["adapter_type"] == "CPU" else ""
    return Finding("GPU renderer", "yes", f"{about['device']}, {about['backend_type']}{slow}")


def window() -> Finding:
    """Whether `mobilegs view --native` can open one."""
    if not all(find_module(name) for name in ("wgpu", "rendercanvas", "glfw")):
        found = "libraries are missing; the browser shows scenes without them"
        return Finding("Window", "no", found, "pip install 'mobilegs[native]'")
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if platform.system() == "Linux" and not any(os.environ.get(name) for name in screens):
        return Finding("Window", "none", "this session has no screen: view --native opens nothing")
    return Finding("Window", "yes", "view --native")


def phones() -> Finding:
    """Where devices in the same network would reach a scene."""
    from mobilegs.view.serve import own_address

    address = own_address()
    if address is None or address.startswith("127."):
        return Finding("Phones", "none", "this machine is in no network: view --lan reaches nobody")
    return Finding("Phones", "yes", f"in this network view --lan is reached at {address}")


def capture() -> Finding:
    """Whether photos without poses, HEIC and videos can be used."""
    needs = {"pycolmap": "poses", "pi_heif": "HEIC photos", "av": "videos"}
    missing = [f"{name} ({what})" for name, what in needs.items() if not find_module(name)]
    if missing:
        found = f"not installed: {', '.join(missing)}"
        return Finding("Capture", "no", found, "pip install 'mobilegs[capture]'")
    for name in needs:
        try:
            importlib.import_module(name)
        except Exception as error:  # whatever its own libraries lack
            remedy = f"pip install --force-reinstall {name.replace('_', '-')}"
            return Finding("Capture", "no", f"{name} is there, but does not load: {error}", remedy)
    return Finding("Capture", "yes", "poses of photos and videos, HEIC included")


def live() -> Finding:
    """Whether a training can be watched."""
    if not find_module("viser"):
        found = "viser is not installed; needed for --live"
        return Finding("Watching training", "no", found, "pip install 'mobilegs[live]'")
    return Finding("Watching training", "yes", "train --live shows it in the browser")


def lpips_weights() -> Finding:
    from mobilegs.evaluate.lpips import BACKBONES, ENVIRONMENT

    folder = os.environ.get(ENVIRONMENT)
    remedy = f"give --lpips-weights, or set {ENVIRONMENT}, to have LPIPS among the figures"
    if not folder:
        return Finding("LPIPS weights", "no", f"{ENVIRONMENT} is not set", remedy)
    if folder.startswith(("http://", "https://")):
        return Finding("LPIPS weights", "yes", f"downloaded on first use from {folder}")
    missing = [b.file for b in BACKBONES.values() if not (Path(folder) / b.file).is_file()]
    if missing:
        return Finding("LPIPS weights", "no", f"{folder} lacks {' and '.join(missing)}", remedy)
    return Finding("LPIPS weights", "yes", folder)


def find_module(name: str) -> bool:
    """Whether a module could be imported, without importing it."""
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # its parent package is missing
        return False
