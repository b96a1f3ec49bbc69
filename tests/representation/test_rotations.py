"""The largest angles of a file: both decoders agree on them, and on the limit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.representation.rotations import encode_rotations
from mobilegs.representation.uniform_quantizer import ANGLE_STEP_RANGE, StepSizes
from tests.support.node import assert_close, assert_same_refusals, decoded
from tests.support.quantized_scenes import join, split
from tests.support.scene_cases import Case, make_scene


def flat() -> QuantizedScene:
    """Return a scene whose angles have many refinement bits."""
    coded = make_scene(Case(600, steps=StepSizes()))
    g = torch.Generator().manual_seed(0)
    scales = torch.randint(-60, 10, coded.indices["scale"].shape, generator=g).int()
    return replace(coded, indices=coded.indices | {"scale": scales})


def turned(step: float, cells: list[int]) -> QuantizedScene:
    """Return a scene of random angles in these cells."""
    coded = flat()
    g = torch.Generator().manual_seed(1)
    parts = 1 << coded.refinement_bits.int()
    picked = torch.tensor(cells)[torch.randint(len(cells), parts.shape, generator=g)]
    rest = (torch.rand(parts.shape, generator=g) * parts).int()
    rest[0] = parts[0] - 1  # the end of its cell
    rotations = (picked * parts + rest).int()
    return replace(
        coded,
        indices=coded.indices | {"rotation": rotations},
        step_sizes=coded.step_sizes | {"rotation": step},
    )


def refused(data: bytes) -> bool:
    try:
        inspect(data)
    except InputError as error:
        assert "'scalars.rotation'" in str(error)
        return True
    return False


@pytest.mark.parametrize(
    ("step", "cells"), [(16.0, [0]), (5.333333, [-1, 1]), (0.25, [-31, 0, 31])]
)
def test_both_decoders_agree_on_the_largest_angles(
    step: float, cells: list[int], tmp_path: Path
) -> None:
    data = encode_mgs(turned(step, cells))
    expected = decode_mgs(data).decode().gaussians.quats
    vectors = decoded(tmp_path, {"file": data}, seed=0)["file"]["arrays"]["quats"]
    assert_close("quats", vectors, normalize(expected, dim=1), 3e-6)


def test_both_decoders_refuse_larger_ones_from_the_header(tmp_path: Path) -> None:
    """The limit holds for the step size as a float32 value."""
    cases = {
        (0, 16.0): False,
        (0, 16.0000001): False,
        (0, float(np.nextafter(np.float32(16), np.float32(17)))): True,
        (0, 1000.0): True,
        (1, 5.333333): False,
        (1, 16 / 3): True,  # a product of 8, but rounded up first
        (-1, 5.333333): False,
        (-1, 16 / 3): True,
        (-31, 0.253): False,
        (-31, 0.254): True,
    }
    files = []
    for cell, step in cases:
        header, body = split(encode_mgs(turned(0.002, [cell])))
        header["scalars"]["rotation"]["step"] = step
        files.append(join(header, body))
    assert [refused(file) for file in files] == list(cases.values())
    found = assert_same_refusals(tmp_path, files)
    assert [sentence is not None for sentence in found] == list(cases.values())
    assert all("'scalars.rotation'" in sentence for sentence in found if sentence)


@pytest.mark.parametrize("cell", [-2, 2])
def test_a_scene_of_larger_angles_is_not_written(cell: int) -> None:
    encode_mgs(turned(3.19, [cell]))
    with pytest.raises(InputError, match=r"3\.3 is too large"):
        encode_mgs(turned(3.3, [cell]))


@pytest.mark.parametrize("step", [*ANGLE_STEP_RANGE, 2 * torch.pi / 3])
def test_every_encoded_rotation_can_be_written(step: float) -> None:
    g = torch.Generator().manual_seed(0)
    coded = flat()
    quats = torch.randn(len(coded), 4, generator=g)
    quats[::2, 0] = 0  # half turns, a third of them about an axis
    quats[::3, 1:3] = 0
    codes = encode_rotations(quats, coded.values()["scale"], step)
    coded = replace(
        coded,
        indices=coded.indices | {"rotation": codes},
        step_sizes=coded.step_sizes | {"rotation": step},
    )
    decode_mgs(encode_mgs(coded))


def test_a_step_size_without_valid_angles_is_refused() -> None:
    StepSizes(rotation=4.0)
    with pytest.raises(InputError, match=r"rotation must lie within .* 4\.1"):
        StepSizes(rotation=4.1)
