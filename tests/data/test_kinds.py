"""Captures as other tools and other machines leave them: places, spellings, coordinates."""

import json
import logging
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.data import load_capture
from mobilegs.data.colmap_files import read_images
from mobilegs.data.images import image_size
from mobilegs.data.points import read_points_ply
from mobilegs.formats.ply import read_ply, write_ply
from tests.data.test_nerfstudio import SHARED, capture, edit
from tests.support.colmap_capture import images_txt, random_poses, write_capture_of_noise
from tests.support.random_scenes import random_scene

# --- places


def test_transforms_json_comes_before_the_colmap_folder_it_was_made_from(tmp_path: Path) -> None:
    write_capture_of_noise(tmp_path, model="colmap/sparse/0")
    capture(tmp_path, views=5, meta={**SHARED, "test_filenames": [], "train_filenames": []})
    edit(tmp_path, lambda meta: [meta.pop(f"{part}_filenames") for part in ("test", "train")])
    names = {frame.name for frame in load_capture(tmp_path).train}
    assert names == {f"f{i:02d}.png" for i in range(1, 5)}


def test_the_largest_of_several_models_is_used_and_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_capture_of_noise(tmp_path, model="sparse/1")
    small = tmp_path / "sparse" / "0"
    shutil.copytree(tmp_path / "sparse" / "1", small)
    for kind in (".bin", ".txt"):
        (small / f"images{kind}").unlink(missing_ok=True)
    (small / "images.txt").write_bytes(images_txt(random_poses(3), "1.0 2.0 -1"))
    with caplog.at_level(logging.WARNING):
        dataset = load_capture(tmp_path)
    assert len(dataset.train) + len(dataset.test) == 9
    assert caplog.text.count("0 of 3 photos, 1 of 9 photos: the largest is used") == 1


def test_photos_in_the_capture_s_root_are_read_from_inside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    capture(tmp_path, folder=".")
    expected = [frame.name for frame in load_capture(tmp_path).train]
    monkeypatch.chdir(tmp_path)
    for spelled in (".", "./", f"../{tmp_path.name}", ""):
        dataset = load_capture(spelled)
        assert [frame.name for frame in dataset.train] == expected
        assert dataset.name == tmp_path.name


def test_a_capture_has_the_name_of_what_it_was_made_from(tmp_path: Path) -> None:
    root = capture(tmp_path / "garden" / "capture")
    assert load_capture(root).name == "garden"
    (root / "capture.json").write_text('{"source": "walk.mp4"}')
    assert load_capture(root).name == "walk"
    name = load_capture(root).train[0].name
    assert load_capture(root).train[0].exposure is None
    (root / "capture.json").write_text(json.dumps({"exposures": {name: -3.5}}))
    assert load_capture(root).train[0].exposure == -3.5
    (root / "capture.json").write_text(json.dumps({"exposures": {name: "bright"}}))
    assert load_capture(root).train[0].exposure is None
    (root / "capture.json").write_text("{")
    assert load_capture(root).name == "garden"


# --- spellings


@pytest.mark.parametrize(
    "spelled",
    [
        "images\\{name}",
        "C:\\Users\\me\\garden\\images\\{name}",
        "/home/me/garden/images/{name}",
        "./images/{name}",
    ],
)
def test_paths_of_other_machines_are_found_in_the_capture(tmp_path: Path, spelled: str) -> None:
    root = capture(tmp_path, mask_path="images/f00.png")

    def respell(meta: dict) -> None:
        for index, frame in enumerate(meta["frames"]):
            frame["file_path"] = spelled.format(name=f"f{index:02d}.png")
            frame["mask_path"] = spelled.format(name="f00.png")
        meta["train_filenames"] = [frame["file_path"] for frame in meta["frames"][:6]]
        meta["test_filenames"] = [frame["file_path"] for frame in meta["frames"][6:]]

    dataset = load_capture(edit(root, respell))
    assert [frame.name for frame in dataset.test] == ["f06.png", "f07.png", "f08.png"]
    assert {frame.mask_path for frame in dataset.train} == {root / "images" / "f00.png"}


def test_absolute_and_relative_paths_mix(tmp_path: Path) -> None:
    root = capture(tmp_path)

    def change(meta: dict) -> None:
        meta["frames"][2]["file_path"] = str(root / "images/f02.png")

    assert len(load_capture(edit(root, change)).train) == 7


def test_text_of_windows_is_read(tmp_path: Path) -> None:
    root = capture(tmp_path / "a")
    text = (root / "transforms.json").read_bytes()
    (root / "transforms.json").write_bytes(b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n"))
    assert len(load_capture(root).train) == 7
    plain = images_txt(random_poses(4), "1.0 2.0 -1 4 5 6")
    for name, content in (("a", plain), ("b", b"\xef\xbb\xbf" + plain.replace(b"\n", b"\r\n"))):
        (tmp_path / f"{name}.txt").write_bytes(content)
    assert read_images(tmp_path / "a.txt") == read_images(tmp_path / "b.txt")


@pytest.mark.parametrize("observations", ["", "1.0 2.0 -1", "1 2 3 4 5 6 7 8 9 10 11 12"])
def test_models_with_and_without_lines_of_observations_are_read_whole(
    tmp_path: Path, observations: str
) -> None:
    path = tmp_path / "images.txt"
    path.write_bytes(images_txt(random_poses(6), observations))
    expected = read_images(path)
    assert len(expected) == 6
    lines = path.read_text().splitlines()
    kept = [line for line in lines if line.strip() and line != observations]
    path.write_text("\n".join(kept) + "\n")
    assert read_images(path) == expected


def test_points_with_line_ends_of_windows_and_of_double_precision_are_read(tmp_path: Path) -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
    header += "property double z\nend_header\n"
    text = header + "500000.125 4500000.0625 1\n-1 2.5 3\n"
    path = tmp_path / "points.ply"
    path.write_bytes(text.replace("\n", "\r\n").encode())
    points, colors = read_points_ply(path)
    assert points.tolist() == [[500000.125, 4500000.0625, 1.0], [-1.0, 2.5, 3.0]]
    assert (colors == 0.5).all()


# --- coordinates


def test_a_georeferenced_twin_is_the_same_capture(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    near = load_capture(capture(tmp_path / "near"))

    def move(meta: dict) -> None:
        for frame in meta["frames"]:
            for axis, shift in enumerate((500_000.0, 4_500_000.0, 30.0)):
                frame["transform_matrix"][axis][3] += shift

    with caplog.at_level(logging.WARNING):
        far = load_capture(edit(capture(tmp_path / "far"), move))
    assert "positions count from there" in caplog.text
    difference = torch.tensor(far.offset) - torch.tensor([500_000.0, 4_500_000.0, 30.0])
    assert difference.abs().max() < 3 and near.offset == (0.0, 0.0, 0.0)
    for one, other in zip(near.train, far.train, strict=True):
        assert (other.camera.position + difference - one.camera.position).abs().max() < 1e-5
        assert torch.equal(one.camera.viewmat[:3, :3], other.camera.viewmat[:3, :3])
    assert far.extent == pytest.approx(near.extent, rel=1e-5)


# --- scenes of other methods


def test_disks_of_2dgs_are_read_as_flat_gaussians(tmp_path: Path) -> None:
    gaussians = random_scene(5, 0)
    write_ply(tmp_path / "full.ply", gaussians)
    data = (tmp_path / "full.ply").read_bytes()
    head, body = data.split(b"end_header\n", 1)
    names = [line.split()[-1] for line in head.decode().splitlines() if line.startswith("property")]
    rows = np.frombuffer(body, "<f4").reshape(5, len(names))
    kept = [index for index, name in enumerate(names) if name != "scale_2"]
    head = head.replace(b"property float scale_2\n", b"")
    (tmp_path / "flat.ply").write_bytes(head + b"end_header\n" + rows[:, kept].tobytes())
    found = read_ply(tmp_path / "flat.ply")
    assert torch.equal(found.log_scales[:, :2], gaussians.log_scales[:, :2])
    thin = found.scales[:, 2] / found.scales[:, :2].amin(1)
    torch.testing.assert_close(thin, torch.full_like(thin, 1e-3), rtol=0.02, atol=0)


CASES = os.environ.get("MOBILEGS_DATA")
KINDS = ["colmap_two_models", "colmap_utm", "ns_backslash", "ns_colmap_masks", "ns_ply_crlf"]


@pytest.mark.skipif(CASES is None, reason="needs real captures (MOBILEGS_DATA)")
@pytest.mark.parametrize("kind", [*KINDS, "ns_root"])
def test_files_that_tools_wrote_are_read_whole(kind: str) -> None:
    folder = Path(CASES or "").parent / "cases" / kind
    if not folder.exists():
        pytest.skip("needs real captures (MOBILEGS_DATA)")
    dataset = load_capture(folder)
    assert len(dataset.train) + len(dataset.test) == 24
    assert kind != "ns_colmap_masks" or all(frame.mask_path for frame in dataset.train)
    assert kind != "ns_ply_crlf" or len(dataset.points) == 2000
    assert dataset.train[0].image_path is not None
    assert image_size(dataset.train[0].image_path) == (160, 120)
    assert any(dataset.offset) == (kind == "colmap_utm")
