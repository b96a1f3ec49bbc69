"""Compare all decoders of `.mgs` on the same inputs.

| decoder | code |
|---|---|
| C++ | `mobilegs.mgs` with the library |
| reference | `mobilegs.mgs` without it: numpy and PyTorch |
| JavaScript with WebAssembly, and without it | `viewer/src/mgs` |
| independent | `examples/read_mgs.py`, which checks only what it needs to decode safely |

C++ and the reference must give equal codes to the last bit, or refuse with the same sentence. All
others must refuse what they refuse, and give the same arrays within `TOLERANCES`.
"""

import contextlib
import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch

from fuzz.viewer import Ran, Viewer
from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene, scenes_equal
from mobilegs.render.lobes import constant_lobes
from mobilegs.representation.lobes import COEFFICIENT_MAX

# errors relative to the largest number of an array, or to 1e-6: sums have no specified order
TOLERANCES = {"means": 0.0, "log_scales": 0.0, "quats": 1e-6, "sh": 2e-5, "lobes": 2e-5}
INDEPENDENT = Path(__file__).parents[1] / "examples" / "read_mgs.py"
# messages of the viewer about scenes that only Python opens
ONLY_THERE = re.compile(r"has sh_degree '[023]'")
Arrays = dict[str, np.ndarray]


@contextlib.contextmanager
def reference() -> Iterator[None]:
    """Decode without the C++ library."""
    decoders = binding.decoders
    binding.decoders = lambda: None  # type: ignore[assignment]
    try:
        yield
    finally:
        binding.decoders = decoders


@torch.no_grad()
def decoded(data: bytes) -> tuple[QuantizedScene, Arrays] | str:
    """Return the scene of a file with its arrays, or the sentence of a refusal."""
    try:
        codes = decode_mgs(data)
    except InputError as error:
        return str(error)
    scene = codes.decode()
    lobes = scene.lobes
    if lobes is None:
        lobes = constant_lobes(scene.gaussians.logit_opacities)
    parts = {
        "means": scene.gaussians.means,
        "log_scales": scene.gaussians.log_scales,
        "quats": torch.nn.functional.normalize(scene.gaussians.quats, dim=1),
        "sh": scene.gaussians.sh.flatten(1),
        "lobes": lobes.flatten(1),
    }
    return codes, {name: part.numpy() for name, part in parts.items()}


def difference(found: Arrays, expected: Arrays, *, exact: bool = True) -> str | None:
    """Return which array differs by more than its tolerance, and by how much; None if none does."""
    for name, tolerance in TOLERANCES.items():
        if name not in found:
            continue
        here, there = found[name].reshape(-1), expected[name].reshape(-1)
        if name == "lobes":  # decoders may clamp them (docs/reference/format.md, section 8)
            here = here.clip(-COEFFICIENT_MAX, COEFFICIENT_MAX)
        if here.shape != there.shape:
            return f"{name} has {here.size} numbers instead of {there.size}"
        error = np.abs(here.astype(np.float64) - there).max(initial=0)
        largest = max(float(np.abs(there).max(initial=0)), 1e-6)
        if not error <= (tolerance or (0.0 if exact else 1e-7)) * largest:
            return f"{name} differs by {error / largest:.1e}"
    return None


class Agreement:
    """Runs all decoders on batches of inputs.

    Attributes:
        scenes: inputs that all of them decoded.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.scenes = folder, 0
        self.fast, self.plain = Viewer(folder, "--coverage"), Viewer(folder, "--without-wasm")
        self.independent = runpy.run_path(str(INDEPENDENT))["decode"]

    def __call__(self, batch: list[bytes]) -> Ran:
        answers = {}
        for name, viewer in (("wasm", self.fast), ("no wasm", self.plain)):
            out = self.folder / f"{name}.f32"
            answers[name] = viewer.ask("mgs", batch, out=str(out))
            answers[name]["numbers"] = np.fromfile(out, "<f4")
        errors = [
            self.disagreement(
                data, {n: _javascript(a["verdicts"][i], a["numbers"]) for n, a in answers.items()}
            )
            for i, data in enumerate(batch)
        ]
        return answers["wasm"]["novel"], answers["wasm"]["blocks"], errors

    def disagreement(self, data: bytes, javascript: dict[str, Arrays | str]) -> str | None:
        """Return how the decoders differ on an input, or None."""
        ours = decoded(data)
        with reference():
            theirs = decoded(data)
        if isinstance(ours, str) or isinstance(theirs, str):
            if ours != theirs:
                return f"C++: {_short(ours)}, reference: {_short(theirs)}"
        else:
            if not scenes_equal(ours[0], theirs[0]):
                return "the codes of C++ and of the reference differ"
            if found := difference(ours[1], theirs[1]):
                return f"C++ and reference: {found}"
        for name, found in javascript.items():
            if isinstance(found, str) or isinstance(ours, str):
                there = isinstance(found, str) and ONLY_THERE.search(found)
                if isinstance(found, str) != isinstance(ours, str) and not there:
                    return f"{name}: {_short(found)}, C++: {_short(ours)}"
            elif apart := difference(found, ours[1]):
                return f"JavaScript ({name}) and C++: {apart}"
        if isinstance(ours, str):
            return None
        try:
            _, arrays = self.independent(data)
        except Exception as error:
            return f"read_mgs.py: {type(error).__name__}: {error}, C++: a scene"
        if apart := difference(arrays, ours[1], exact=False):
            return f"read_mgs.py and C++: {apart}"
        self.scenes += 1
        return None

    def close(self) -> None:
        """End the processes."""
        self.fast.close()
        self.plain.close()


def _javascript(row: Any, numbers: np.ndarray) -> Arrays | str:
    if isinstance(row, str):
        return row
    if isinstance(row, dict):
        return f"failed: {row['error']}"
    found = {name: numbers[start : start + length] for name, start, length in row}
    return {**found, "log_scales": found["logScales"]}


def _short(found: object) -> str:
    return f"'{found}'" if isinstance(found, str) else "a scene"
