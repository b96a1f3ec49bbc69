"""The definitions still draw what they once drew."""

import numpy as np
from PIL import Image

from tests.support.golden import CASES, STORED, sheet


def test_the_definitions_draw_what_they_drew() -> None:
    stored = np.asarray(Image.open(STORED)).astype(int)
    found = sheet().astype(int)
    assert stored.shape == found.shape
    rows = np.abs(stored - found).reshape(len(CASES), -1).max(1)
    changed = [case for case, worst in zip(CASES, rows, strict=True) if worst > 1]
    assert not changed, (
        "if that is meant, run python tests/support/golden.py and look at the picture"
    )
    assert stored.std() > 20
