"""Edited files: what stays is the same to the last bit, and nothing is overwritten."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.edit.camera_counts import count_cameras, floaters
from mobilegs.edit.regions import Sphere
from mobilegs.edit.scene_edit import (
    SceneEdit,
    edit_file,
    free_name,
    kept_rows,
    read_rows,
    with_notes,
)
from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply, read_ply_up, write_ply
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.container import read_container
from mobilegs.mgs.quantized_scene import QuantizedScene, scenes_equal
from mobilegs.render.scene import Scene
from tests.support.scene_cases import CASES, make_scene
from tests.support.selection import few
from tests.support.viewer_page import MGS

NAMES = ["one hidden layer", "scalars with lobes", "network", "the paper's", "one place"]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.mgs"
    path.write_bytes(MGS)
    return path


def assert_same_rows(edited: QuantizedScene, whole: QuantizedScene, keep: torch.Tensor) -> None:
    """Codes, weights and everything but the number of rows are equal to the last bit."""
    rows = keep.nonzero()[:, 0]
    expected = replace(whole.select(rows), lod_sizes=edited.lod_sizes)
    assert scenes_equal(edited, expected)


@pytest.mark.parametrize("name", few(NAMES, "one hidden layer", "scalars with lobes"))
def test_what_stays_is_bit_identical(name: str) -> None:
    whole = decode_mgs(encode_mgs(make_scene(CASES[name])))
    keep = torch.rand(len(whole), generator=torch.Generator().manual_seed(1)) < 0.6
    edited = decode_mgs(encode_mgs(kept_rows(whole, keep)))
    assert_same_rows(edited, whole, keep)
    before, after = whole.decode(), edited.decode()
    for part, values in after.gaussians.tensors().items():
        assert torch.equal(values, before.gaussians.tensors()[part][keep]), part
    if before.lobes is not None and after.lobes is not None:
        assert torch.equal(after.lobes, before.lobes[keep])


def test_levels_keep_their_gaussians_and_empty_ones_go() -> None:
    case = next(case for case in CASES.values() if len(case.layers) > 1)
    whole = decode_mgs(encode_mgs(make_scene(case)))
    first = whole.lod_slices()[0]
    keep = torch.ones(len(whole), dtype=torch.bool)
    keep[first] = False
    edited = decode_mgs(encode_mgs(kept_rows(whole, keep)))
    assert edited.lod_sizes == whole.lod_sizes[1:]
    assert_same_rows(edited, whole, keep)
    keep[first.start] = True
    assert kept_rows(whole, keep).lod_sizes == (1, *whole.lod_sizes[1:])


def test_notes_leave_the_streams_alone() -> None:
    for case in list(CASES.values())[1:3]:
        data = encode_mgs(make_scene(case))
        changed = with_notes(data, {"title": "A"})
        old, new = read_container(data), read_container(changed)
        assert {k: bytes(v.data) for k, v in old[1].items()} == {
            k: bytes(v.data) for k, v in new[1].items()
        }
        assert new[0]["meta"] == old[0]["meta"] | {"title": "A"}
        assert changed[8:12] == data[8:12]  # the version
        assert with_notes(changed, {"title": ""}) == with_notes(data, {})
        assert scenes_equal(decode_mgs(with_notes(data, {})), decode_mgs(data))


def test_an_edit_without_effect_copies_the_file(scene: Path, tmp_path: Path) -> None:
    edit_file(scene, tmp_path / "new.mgs", SceneEdit(remove=[Sphere((1e9, 0, 0), 1.0)]))
    assert (tmp_path / "new.mgs").read_bytes() == MGS


def test_nothing_is_overwritten(scene: Path, tmp_path: Path) -> None:
    (tmp_path / "other.mgs").write_bytes(b"mine")
    (tmp_path / "link.mgs").symlink_to(scene)
    for output in (scene, tmp_path / "other.mgs", tmp_path / "link.mgs"):
        with pytest.raises(InputError, match="overwrites nothing"):
            edit_file(scene, output, SceneEdit(notes={"title": "A"}))
    assert (tmp_path / "other.mgs").read_bytes() == b"mine" and scene.read_bytes() == MGS
    assert free_name(scene).name == "scene-edited.mgs"
    (tmp_path / "scene-edited.mgs").touch()
    assert free_name(scene).name == "scene-edited-2.mgs"
    assert free_name(tmp_path / "a.splat").name == "a-edited.ply"


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (SceneEdit(keep=[Sphere((1e9, 0, 0), 1.0)]), "no Gaussian of .* would stay: .* outside"),
        (SceneEdit(rows=torch.tensor([10**9])), "rows to remove must lie between"),
        (SceneEdit(min_cameras=1000), "there are only 4|there are only"),
        (SceneEdit(notes={"title": "a\nb"}), "not a short text"),
    ],
)
def test_edits_without_sense_are_refused(scene: Path, edit: SceneEdit, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        edit_file(scene, scene.with_name("new.mgs"), edit)
    assert not scene.with_name("new.mgs").exists()
    assert sorted(path.name for path in scene.parent.iterdir()) == ["scene.mgs"]


def test_a_scene_without_cameras_needs_some_to_count(tmp_path: Path) -> None:
    path = tmp_path / "plain.ply"
    write_ply(path, decode_mgs(MGS).decode().gaussians)
    with pytest.raises(InputError, match="has no cameras to count: give --capture"):
        edit_file(path, tmp_path / "new.ply", SceneEdit(min_cameras=1))


def test_a_ply_keeps_its_numbers(tmp_path: Path) -> None:
    path, output = tmp_path / "plain.ply", tmp_path / "new.ply"
    write_ply(path, decode_mgs(MGS).decode().gaussians, up=np.array([0.0, 0, 1]))
    edit_file(path, output, SceneEdit(rows=torch.arange(10)))
    before, after = read_ply(path), read_ply(output)
    for name, values in after.tensors().items():
        assert torch.equal(values, before.tensors()[name][10:]), name
    assert read_ply_up(output) == pytest.approx([0, 0, 1])
    with pytest.raises(InputError, match="holds no notes"):
        edit_file(path, tmp_path / "b.ply", SceneEdit(notes={"title": "A"}))
    with pytest.raises(InputError, match="does not end in"):
        edit_file(path, tmp_path / "b.mgs", SceneEdit(rows=torch.arange(10)))


def test_rows_come_from_texts_and_arrays(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("3 1\n2\n")
    np.save(tmp_path / "b.npy", np.array([False, True, True, True]))
    np.save(tmp_path / "c.npy", np.array([3, 1, 2], np.uint32))
    for name in ("a.txt", "b.npy", "c.npy"):
        assert sorted(read_rows(tmp_path / name).tolist()) == [1, 2, 3]
    (tmp_path / "d.txt").write_text("3 x")
    np.save(tmp_path / "e.npy", np.zeros((2, 2)))
    for name in ("d.txt", "e.npy", "missing.txt"):
        with pytest.raises(InputError, match=r"does not hold row numbers|cannot read"):
            read_rows(tmp_path / name)


def wall(extra: list[list[float]]) -> Scene:
    """A wall of 900 Gaussians at z = 0, and `extra` ones."""
    grid = torch.linspace(-1, 1, 30)
    y, x = torch.meshgrid(grid, grid, indexing="ij")
    means = torch.stack([x, y, torch.zeros_like(x)], -1).reshape(-1, 3)
    means = torch.cat([means, torch.tensor(extra).reshape(-1, 3)])
    n = len(means)
    scales = torch.full((n, 3), 0.1)
    scales[900:] = 0.05
    return Scene(
        Gaussians(
            means,
            torch.tensor([[1.0, 0, 0, 0]]).repeat(n, 1),
            scales.log(),
            torch.full((n,), 8.0),
            torch.zeros(n, 1, 3),
        )
    )


def looking(count: int) -> list[Camera]:
    K = torch.tensor([[120.0, 0, 64], [0, 120, 64], [0, 0, 1]])
    eyes = [torch.tensor([0.6 * i / count, 0.1, -3.0]) for i in range(count)]
    up = torch.tensor([0.0, -1, 0])
    return [Camera(look_at(eye, torch.zeros(3), up), K, 128, 128) for eye in eyes]


def test_cameras_are_counted_that_saw_a_gaussian() -> None:
    scene = wall([[0, 0, 0.5], [5, 0, 0]])  # behind the wall; outside of the pictures
    calls: list[tuple[int, int]] = []
    counts = count_cameras(scene, looking(6), progress=lambda *at: calls.append(at))
    assert counts.cameras == 6 and calls[-1] == (6, 6)
    assert counts.seen[:900].min() == 6
    assert counts.seen[900:].tolist() == [0, 0]
    assert counts.framed[900:].tolist() == [6, 0]


def test_floaters_are_lonely_and_before_the_scene() -> None:
    scene = wall([[0, 0, 0.5], [0, 0.2, -2]])  # hidden behind the wall; before it
    counts = count_cameras(scene, looking(6))
    assert counts.ahead.nonzero()[:, 0].tolist() == [901]
    # a wall of so few Gaussians weighs little: the one before it is more than the limit
    assert floaters(counts).nonzero()[:, 0].tolist() == [900]
    light = replace(counts, weight=counts.weight.clone())
    light.weight[901] = 0
    assert floaters(light).nonzero()[:, 0].tolist() == [900, 901]
    few = replace(scene, gaussians=scene.gaussians.select(slice(0, 5)))
    assert not floaters(count_cameras(few, looking(1))).any()
