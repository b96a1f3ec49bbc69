"""The tiles of a Gaussian are the same in every function that a compiler makes of one source."""

import ctypes
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mobilegs.csrc.binding import cpu_flags
from mobilegs.render.kernels.cuda import CSRC

COMPILER = shutil.which("g++") or shutil.which("c++")
SOURCE = """
#include "pairs.h"
extern "C" int spans(int n, const float* in, float* out) {
  for (int i = 0; i < n; i++) {
    const float* p = in + 8 * i;
    Splat s = {};
    s.x = p[0], s.y = p[1], s.A = p[2], s.B = p[3], s.C = p[4];
    s.det = p[2] * p[4] * 0.5f, s.reach = p[5];
    row_span(s, p[6], p[7], out[2 * i], out[2 * i + 1]);
  }
  return 0;
}
"""


@pytest.mark.skipif(COMPILER is None or sys.platform == "win32", reason="needs a C++ compiler")
@pytest.mark.skipif("fma" not in cpu_flags(), reason="needs a CPU with FMA")
def test_spans_do_not_depend_on_how_products_are_added(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    count = 20_000
    inputs = np.empty((count, 8), dtype=np.float32)
    inputs[:, :2] = random.uniform(-20, 300, (count, 2))
    inputs[:, 2] = 10 ** random.uniform(-3, 1, count)
    inputs[:, 4] = 10 ** random.uniform(-3, 1, count)
    inputs[:, 3] = random.uniform(-0.99, 0.99, count) * np.sqrt(inputs[:, 2] * inputs[:, 4])
    inputs[:, 5] = random.uniform(0.1, 9, count)
    inputs[:, 6] = np.floor(inputs[:, 1]) + random.integers(-9, 9, count) + 0.5
    inputs[:, 7] = inputs[:, 6] + 15
    found = []
    for contract in ("off", "fast"):
        source, built = tmp_path / "spans.cpp", tmp_path / f"spans_{contract}.so"
        source.write_text(SOURCE)
        flags = f"-std=c++17 -O3 -mfma -ffp-contract={contract} -fPIC -shared".split()
        command = [str(COMPILER), *flags, f"-I{CSRC}", str(source), "-o", str(built)]
        subprocess.run(command, check=True)
        outputs = np.empty((count, 2), dtype=np.float32)
        pointers = (ctypes.c_void_p(array.ctypes.data) for array in (inputs, outputs))
        ctypes.CDLL(str(built)).spans(count, *pointers)
        assert np.isfinite(outputs).all()
        found.append(outputs)
    assert (found[0].view(np.int32) == found[1].view(np.int32)).all()
