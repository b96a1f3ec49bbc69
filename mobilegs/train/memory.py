"""Memory of a training on a CPU: what a run needs, what is free, and keeping what was freed."""

import ctypes
import platform
from pathlib import Path

import psutil

from mobilegs.data.dataset import CACHE_BYTES
from mobilegs.train.student.config import StudentConfig
from mobilegs.viewpoints.virtual_views import DIVISOR, views_per_camera

# Measured by bench/memory.py without a depth pass, rounded up; the buffers of the pass are added.
PROCESS_BYTES = 700e6  # of the process itself: torch, and the photo that is decoded
BYTES_PER_PIXEL = 230  # of a step
BYTES_PER_SPLAT = 2350  # of a Gaussian, its gradients and moments
# Ratio of a cache's memory to its content: in an hour on bonsai, it was fragmented.
CACHE_RATIO = 1.5
# per pixel of a cached photo, and of the teacher's cached image and coverage
PHOTO_BYTES, TARGET_BYTES = 3, 9
CGROUP = Path("/sys/fs/cgroup")  # limits of a container under Linux

# Parameters of glibc's mallopt: its malloc.h.
TRIM_THRESHOLD, TOP_PAD, MMAP_MAX = -1, -2, -4
HEAP_GROWTH = 64 << 20  # bytes, at least


def keep_freed_memory() -> bool:
    """Let this process keep the memory that it frees, for its next tensors; for programs only.

    Otherwise glibc returns large tensors to the system, and each step fetches and clears their
    pages again: a third of a teacher's step. Results do not change. Returns False where the C
    library is not glibc; nothing changes there.
    """
    if platform.libc_ver()[0] != "glibc":
        return False
    mallopt = ctypes.CDLL(None).mallopt
    return all([mallopt(MMAP_MAX, 0), mallopt(TRIM_THRESHOLD, -1), mallopt(TOP_PAD, HEAP_GROWTH)])


def return_freed_memory() -> bool:
    """Give memory that is kept, but free, back to the system; True where the library can."""
    if platform.libc_ver()[0] != "glibc":
        return False
    return bool(ctypes.CDLL(None).malloc_trim(0))


def needed_memory(config: StudentConfig, *, photos: int, pixels: int, splats: int) -> int:
    """Return the bytes that teacher and student take at most.

    Args:
        config: of the student.
        photos: number of training photos.
        pixels: of a photo.
        splats: most Gaussians.
    """
    loss = config.loss
    images, smaller = photos, 1
    if loss.virtual_view_every:
        images, smaller = views_per_camera(photos) * photos, DIVISOR**2
    caches = min(CACHE_BYTES, PHOTO_BYTES * pixels * photos)
    caches += min(config.cache_mib << 20, TARGET_BYTES * pixels * images // smaller)
    return round(
        PROCESS_BYTES + BYTES_PER_PIXEL * pixels + BYTES_PER_SPLAT * splats + CACHE_RATIO * caches
    )


def free_memory() -> int:
    """Return the bytes that are free on this machine, or in the container of this process."""
    free = psutil.virtual_memory().available
    try:
        limit = int((CGROUP / "memory.max").read_text())
        used = int((CGROUP / "memory.current").read_text())
        stat = (CGROUP / "memory.stat").read_text().split()
    except (OSError, ValueError):  # no container, or one without a limit
        return free
    # the cache of files counts as used, but can be reclaimed
    values = dict(zip(stat[::2], stat[1::2], strict=True))
    reclaimable = int(values.get("inactive_file", 0))
    return max(0, min(free, limit - used + reclaimable))
