"""Checks of `mobilegs doctor`: what works on this machine, and what to install for the rest."""

import importlib
import importlib.util
import os
import platform
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

ERROR_CHARACTERS = 160  # shown of an error of another library


@dataclass(frozen=True)
class Finding:
    """The result of one check.

    `state` is `yes` if it works, `no` if an installation would help, and `none` if the machine
    lacks the hardware or it is not needed.
    """

    what: str
    state: Literal["yes", "no", "none"]
    found: str
    remedy: str = ""


def examine() -> list[Finding]:
    """Run all checks; they change nothing."""
    renderer = gpu_renderer()
    return [
        version(),
        python(),
        torch(),
        memory(),
        compiler(),
        cpu_kernels(),
        gpu(),
        gpu_kernels(),
        renderer,
        window(renderer),
        phones(),
        capture(),
        lpips_weights(),
    ]


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
    used = f"uses {threads} of {cores} CPU cores"
    return Finding("PyTorch", "yes", f"{torch.__version__} ({build}), {used}")


def memory() -> Finding:
    try:
        total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return Finding("Memory", "none", "this system does not report it")
    return Finding("Memory", "yes", f"{total / (1 << 30):.1f} GiB")


def compiler() -> Finding:
    path = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if path:
        return Finding("C++ compiler", "yes", path)
    remedies = {
        "Darwin": "xcode-select --install",
        "Windows": "install the build tools of Visual Studio",
    }
    remedy = remedies.get(platform.system(), "apt-get install g++, or the package of your system")
    return Finding("C++ compiler", "no", "none; needed only to install from source", remedy)


def cpu_kernels() -> Finding:
    """Check which of the compiled libraries this processor runs."""
    from mobilegs.csrc.binding import BUILDS, cpu_flags, kernel_build

    flags = cpu_flags()
    able = [build for build, needed in BUILDS.items() if needed and needed <= flags]
    runs = f"this CPU runs {', '.join(able)}" if able else "instruction sets unknown"
    try:
        return Finding("CPU kernels", "yes", f"using {kernel_build()}; {runs}")
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
        return Finding("GPU", "no", "found, but this PyTorch is built for the CPU", remedy)
    remedy = f"update the NVIDIA driver to one that supports CUDA {torch.version.cuda}"
    return Finding("GPU", "no", "found, but PyTorch cannot open it", remedy)


def has_nvidia() -> bool:
    """Return True if there is an NVIDIA graphics card, usable or not."""
    return Path("/proc/driver/nvidia").exists() or shutil.which("nvidia-smi") is not None


def gpu_kernels() -> Finding:
    """Check that CUDA kernels compile, which needs libraries but neither GPU nor toolkit."""
    remedy = "pip install 'mobilegs[cuda]'"
    if not all(find_module(name) for name in ("cuda.core", "cuda.bindings")):
        if not has_nvidia():
            return Finding("CUDA kernels", "none", "not installed, and not needed without a GPU")
        return Finding("CUDA kernels", "no", "cuda-core is not installed; needed for a GPU", remedy)
    try:
        core = importlib.import_module("cuda.core")  # its attributes are invisible to type checkers
        options = core.ProgramOptions(arch="sm_80")
        core.Program('extern "C" __global__ void probe() {}', "c++", options).compile("cubin")
    except Exception as error:  # an incomplete driver installation can raise anything
        why = " ".join(str(error).split())[:ERROR_CHARACTERS]
        if not has_nvidia():
            why = f"NVRTC does not compile, and is not needed without a GPU ({why})"
            return Finding("CUDA kernels", "none", why)
        return Finding("CUDA kernels", "no", f"NVRTC does not compile ({why})", remedy)
    return Finding("CUDA kernels", "yes", "NVRTC compiles them on first use")


def gpu_renderer() -> Finding:
    """Render a small image with each GPU as the viewers do, and compare it with the reference."""
    from mobilegs.errors import InputError
    from mobilegs.view.wgpu_check import check_gpus
    from mobilegs.view.wgpu_device import REMEDY

    try:
        checks = check_gpus()
    except InputError as error:
        problem, _, remedy = str(error).partition(": ")
        return Finding("GPU renderer", "no", problem, remedy)
    told = [
        f"{check.gpu}: {check.problem or f'agrees with the reference ({check.decibels:.0f} dB)'}"
        for check in checks
    ]
    if all(check.problem for check in checks):
        return Finding("GPU renderer", "no", "; ".join(told), REMEDY)
    return Finding("GPU renderer", "yes", "; ".join(told))


def window(renderer: Finding) -> Finding:
    """Check that `mobilegs view --native` can open a window, given the finding of the renderer."""
    if not all(find_module(name) for name in ("wgpu", "rendercanvas", "glfw")):
        problem = "libraries are missing; the browser needs none"
        return Finding("Window", "no", problem, "pip install 'mobilegs[native]'")
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if platform.system() == "Linux" and not any(os.environ.get(name) for name in screens):
        return Finding("Window", "none", "no screen: view --native does not work")
    if renderer.state != "yes":
        return Finding("Window", "no", "needs a GPU renderer; the browser needs none")
    return Finding("Window", "yes", "view --native works")


def phones() -> Finding:
    """Check at which address devices in the same network reach a scene."""
    from mobilegs.view.serve import own_address

    address = own_address()
    if address is None or address.startswith("127."):
        return Finding("Phones", "none", "no network: view --lan does not work")
    return Finding("Phones", "yes", f"view --lan serves at {address}")


def capture() -> Finding:
    """Check that photos without poses, HEIC photos and videos can be used."""
    needs = {"pycolmap": "poses", "pi_heif": "HEIC photos", "av": "videos"}
    missing = [f"{name} ({what})" for name, what in needs.items() if not find_module(name)]
    if missing:
        problem = f"not installed: {', '.join(missing)}"
        return Finding("Capture", "no", problem, "pip install 'mobilegs[capture]'")
    for name in needs:
        try:
            importlib.import_module(name)
        except Exception as error:  # a missing library can raise anything
            remedy = f"pip install --force-reinstall {name.replace('_', '-')}"
            return Finding(
                "Capture", "no", f"{name} is installed but does not load: {error}", remedy
            )
    return Finding("Capture", "yes", "photos, HEIC photos and videos")


def lpips_weights() -> Finding:
    from mobilegs.evaluate.lpips import BACKBONES, ENVIRONMENT

    folder = os.environ.get(ENVIRONMENT)
    remedy = f"give --lpips-weights, or set {ENVIRONMENT}, to measure LPIPS"
    if not folder:
        return Finding("LPIPS weights", "no", f"{ENVIRONMENT} is not set", remedy)
    if folder.startswith(("http://", "https://")):
        return Finding("LPIPS weights", "yes", f"downloaded on first use from {folder}")
    missing = [b.file for b in BACKBONES.values() if not (Path(folder) / b.file).is_file()]
    if missing:
        return Finding("LPIPS weights", "no", f"{folder} lacks {' and '.join(missing)}", remedy)
    return Finding("LPIPS weights", "yes", folder)


def find_module(name: str) -> bool:
    """Return True if a module is installed, without importing it."""
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # its parent package is missing
        return False
