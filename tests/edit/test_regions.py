"""Regions of space: what they contain, and the texts that describe them."""

import numpy as np
import pytest
import torch

from mobilegs.edit.regions import (
    Box,
    HalfSpace,
    Sphere,
    parsed_boxes,
    parsed_plane,
    parsed_spheres,
)
from mobilegs.errors import InputError

POINTS = torch.tensor([[0.0, 0, 0], [0.9, 0, 0], [0.9, 0.9, 0], [0, 2, 0], [1, 1, 1]])


def test_a_box_contains_its_own_faces() -> None:
    inside = Box((-1, -1, -1), (1, 1, 1)).contains(POINTS)
    assert inside.tolist() == [True, True, True, False, True]


def test_a_box_turns_around_its_centre() -> None:
    eighth = (np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8))  # 45 degrees around z
    turned = Box((-1, -1, -1), (1, 1, 1), eighth)
    assert turned.contains(POINTS).tolist() == [True, True, False, False, False]
    moved = Box((4, -1, -1), (6, 1, 1), eighth)
    assert moved.contains(POINTS + torch.tensor([5.0, 0, 0])).tolist() == [True] * 2 + [False] * 3


def test_spheres_and_half_spaces() -> None:
    assert Sphere((0, 0, 0), 0.8).contains(POINTS).tolist() == [True, False, False, False, False]
    assert Sphere((0, 1, 0), 1).contains(POINTS).tolist() == [True, False, True, True, False]
    below = HalfSpace((0, 1, 0), 0.5).contains(POINTS)
    assert below.tolist() == [True, True, False, False, False]


def test_texts_describe_regions() -> None:
    first, second = parsed_boxes("1 1 1 -1 -1 0; 0,0,0,1,1,1,2,0,0,0", "--remove-box")
    assert first == Box((-1, -1, 0), (1, 1, 1))
    assert second.quaternion == (2, 0, 0, 0)
    assert parsed_spheres("1 2 3 4;0 0 0 .5", "--remove-sphere")[1] == Sphere((0, 0, 0), 0.5)
    assert parsed_plane("2 0 0 4", "--floor") == HalfSpace((1, 0, 0), 2)


@pytest.mark.parametrize(
    ("parse", "text", "sentence"),
    [
        (parsed_boxes, "1 2 3", "--x needs X0 Y0 Z0 X1 Y1 Z1"),
        (parsed_boxes, "0 0 0 0 1 1", "the box is flat"),
        (parsed_boxes, "0 0 0 1 1 nan", "--x needs"),
        (parsed_boxes, "0 0 0 1 1 1 0 0 0 0", "quaternion"),
        (parsed_boxes, ";" * 200, "200 are given|201 are given"),
        (parsed_spheres, "0 0 0 -1", "radius must be above 0"),
        (parsed_spheres, "0 0 0 1;", "--x needs X Y Z RADIUS"),
        (parsed_plane, "0 0 0 1", "normal cannot be 0"),
        (parsed_plane, "0 0 1 1;0 0 1 2", "give one plane"),
        (parsed_plane, "0 0 1 1e300", "--x needs"),
    ],
)
def test_other_texts_are_refused(parse, text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        parse(text, "--x")
