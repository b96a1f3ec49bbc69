"""Reading captures with a transforms.json, and the errors for invalid ones."""

import json
import math

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.camera import look_at
from mobilegs.data import load_capture, load_view
from mobilegs.errors import InputError

SHARED = {"fl_x": 20.0, "fl_y": 21.0, "cx": 6.5, "cy": 4.5, "w": 12, "h": 8}


def viewmat_of(index):
    eye = torch.tensor([2.0 * math.cos(index), 2.0 * math.sin(index), 1.0 + 0.1 * index])
    return look_at(eye, torch.zeros(3), torch.tensor([0.0, 0.0, 1.0])).double()


def pose_of(index):
    """Return camera-to-world with OpenGL axes: right, up and back as columns."""
    to_world = torch.linalg.inv(viewmat_of(index))
    right, down, forward, eye = to_world.T
    return torch.stack([right, -down, -forward, eye], dim=1).tolist()


def capture(root, *, views=9, meta=SHARED, file="transforms.json", folder="images", **entry):
    """Write a capture of one-coloured photos into `root`; `entry` is added to every frame."""
    (root / folder).mkdir(parents=True, exist_ok=True)
    frames = []
    for index in range(views):
        name = f"{folder}/f{index:02d}.png"
        Image.new("RGB", (12, 8), (10 * index, 20, 30)).save(root / name)
        frames.append({"file_path": name, "transform_matrix": pose_of(index), **entry})
    (root / file).write_text(json.dumps({**meta, "frames": frames}))
    return root


def edit(root, change, file="transforms.json"):
    meta = json.loads((root / file).read_text())
    change(meta)
    (root / file).write_text(json.dumps(meta))
    return root


def error_of(path):
    with pytest.raises(InputError) as caught:
        load_capture(path)
    return str(caught.value)


def test_opengl_poses_become_opencv_world_to_camera(tmp_path):
    dataset = load_capture(capture(tmp_path))
    for index, frame in zip([1, 2, 3, 4, 5, 6, 7], dataset.train, strict=True):
        torch.testing.assert_close(
            frame.camera.viewmat.double(), viewmat_of(index), atol=1e-6, rtol=0
        )
    assert [frame.name for frame in dataset.test] == ["f00.png", "f08.png"]


def test_intrinsics_are_shared_unless_a_frame_has_its_own(tmp_path):
    root = edit(capture(tmp_path), lambda meta: meta["frames"][2].update(fl_x=33.0, cx=5.0))
    first, second = load_capture(root).train[:2]
    assert first.camera.K.tolist() == [[20, 0, 6.5], [0, 21, 4.5], [0, 0, 1]]
    assert second.camera.K.tolist() == [[33, 0, 5], [0, 21, 4.5], [0, 0, 1]]


def test_a_field_of_view_gives_focal_length_and_central_principal_point(tmp_path):
    frame = load_capture(capture(tmp_path, meta={"camera_angle_x": math.pi / 2})).train[0]
    np.testing.assert_allclose(frame.camera.K, [[6, 0, 6], [0, 6, 4], [0, 0, 1]], rtol=1e-6)


def test_downscale_divides_size_and_intrinsics(tmp_path):
    camera = load_capture(capture(tmp_path), downscale=2).train[0].camera
    assert (camera.width, camera.height) == (6, 4)
    assert camera.K.tolist() == [[10, 0, 3.25], [0, 10.5, 2.25], [0, 0, 1]]


def test_a_uniform_scale_in_the_matrix_is_divided_out(tmp_path):
    def enlarge(meta):
        for frame in meta["frames"]:
            pose = np.array(frame["transform_matrix"])
            pose[:3, :3] *= 2.5
            frame["transform_matrix"] = pose.tolist()

    camera = load_capture(edit(capture(tmp_path), enlarge)).train[0].camera
    torch.testing.assert_close(camera.viewmat.double(), viewmat_of(1), atol=1e-6, rtol=0)


def test_lists_of_file_names_decide_the_split(tmp_path):
    names = {
        "train_filenames": [f"images/f{i:02d}.png" for i in (0, 1, 2, 3)],
        "test_filenames": ["images/f05.png"],
    }
    dataset = load_capture(edit(capture(tmp_path), lambda meta: meta.update(names)))
    assert [frame.name for frame in dataset.train] == [f"f{i:02d}.png" for i in (0, 1, 2, 3)]
    assert [frame.name for frame in dataset.test] == ["f05.png"]


def test_a_transforms_test_file_decides_the_split(tmp_path):
    capture(tmp_path, views=2, file="transforms_test.json", folder="held")
    dataset = load_capture(capture(tmp_path, views=4))
    assert (len(dataset.train), len(dataset.test)) == (4, 2)


def test_masks_of_frames_are_used(tmp_path):
    mask = Image.new("L", (12, 8), 0)
    mask.putpixel((3, 2), 1)
    mask.save(tmp_path / "m.png")
    view = load_view(load_capture(capture(tmp_path, mask_path="m.png")).train[0])
    assert view.mask is not None and view.mask.nonzero().tolist() == [[2, 3]]


def test_distortion_is_undone_on_load(tmp_path):
    root = capture(tmp_path, k1=2.0, p1=0.01)
    ramp = np.tile(np.arange(12, dtype=np.uint8) * 20, (8, 1))
    Image.fromarray(np.stack([ramp] * 3, axis=2)).save(root / "images/f01.png")
    view = load_view(load_capture(root).train[0])
    assert (view.image[..., 0] * 255 - torch.from_numpy(ramp)).abs().max() > 1
    assert view.mask is not None and view.mask[0, 0] == 0


def test_transparent_renders_are_composited_over_the_background(tmp_path):
    root = capture(tmp_path / "c", file="transforms_train.json", folder="train")
    rgba = np.zeros((8, 12, 4), np.uint8)
    rgba[:, :, 0], rgba[:, :6, 3], rgba[:, 6:, 3] = 200, 255, 51
    Image.fromarray(rgba).save(root / "train/f01.png")
    dataset = load_capture(root)
    image = load_view(dataset.train[0]).image
    assert dataset.background.tolist() == [1, 1, 1]
    assert (image[0, 0] * 255).round().tolist() == [200, 0, 0]
    np.testing.assert_allclose(image[0, 9] * 255, [0.2 * 200 + 0.8 * 255] + [204] * 2, atol=0.51)
    dark = load_capture(root, background=(0.0, 0.0, 1.0))
    np.testing.assert_allclose(load_view(dark.train[0]).image[0, 9] * 255, [40, 0, 204], atol=0.51)


def test_blender_captures_are_read_without_suffixes_and_with_their_split(tmp_path):
    meta = {"camera_angle_x": 0.7}
    capture(tmp_path, meta=meta, views=5, file="transforms_train.json", folder="train")
    capture(tmp_path, meta=meta, views=3, file="transforms_test.json", folder="test")

    def strip(meta):
        for frame in meta["frames"]:
            frame["file_path"] = "./" + frame["file_path"].removesuffix(".png")
            frame["rotation"] = 0.1

    for file in ("transforms_train.json", "transforms_test.json"):
        edit(tmp_path, strip, file)
    dataset = load_capture(tmp_path)
    assert [frame.name for frame in dataset.train] == [f"f{i:02d}.png" for i in range(5)]
    assert [frame.name for frame in dataset.test] == [f"f{i:02d}.png" for i in range(3)]
    assert len(dataset.points) == 0


HEADER = """ply
format {} 1.0
comment made by hand
element vertex 2
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 0
property list uchar int vertex_indices
end_header
"""
ROWS = [((1.0, 2.0, 3.0), (255, 0, 51)), ((-1.0, 0.5, 0.25), (0, 102, 255))]


def ply(kind):
    head = HEADER.format(kind).encode()
    if kind == "ascii":
        return (
            head + "".join(f"{x} {y} {z} {r} {g} {b}\n" for (x, y, z), (r, g, b) in ROWS).encode()
        )
    order = "<" if kind == "binary_little_endian" else ">"
    layout = [("xyz", order + "f4", 3), ("rgb", "u1", 3)]
    return head + np.array(ROWS, dtype=layout).tobytes()


@pytest.mark.parametrize("kind", ["ascii", "binary_big_endian"])
def test_points_are_read_from_the_ply_file(tmp_path, kind):
    root = capture(tmp_path, meta={**SHARED, "ply_file_path": "points.ply"})
    (root / "points.ply").write_bytes(ply(kind))
    dataset = load_capture(root)
    assert dataset.points.tolist() == [list(xyz) for xyz, _ in ROWS]
    np.testing.assert_allclose(dataset.colors * 255, [rgb for _, rgb in ROWS], atol=1e-4)


def test_errors_name_the_cause(tmp_path):
    def broken(name, change):
        return error_of(edit(capture(tmp_path / name), change))

    first = lambda meta: meta["frames"][1]  # noqa: E731
    assert "file_path" in broken("b", lambda m: first(m).pop("file_path"))
    assert "transform_matrix" in broken("c", lambda m: first(m).pop("transform_matrix"))
    assert "rotation" in broken("d", lambda m: first(m).update(transform_matrix=[[1.0] * 4] * 4))
    assert "FISHEYE624" in broken("e", lambda m: m.update(camera_model="FISHEYE624"))
    assert "fl_x" in broken("f", lambda m: m.pop("fl_x"))
    assert "no.ply" in broken("g", lambda m: m.update(ply_file_path="no.ply"))
    assert "no.png" in broken("h", lambda m: first(m).update(mask_path="no.png"))
    assert "frames" in broken("i", lambda m: m.update(frames="none"))
    assert "fewer than two views" in error_of(capture(tmp_path / "j", views=1))
    root = capture(tmp_path / "k")
    (root / "transforms.json").write_text("{")
    assert "not JSON" in error_of(root)


@pytest.mark.parametrize("folder", [".", "images"])
def test_the_error_for_photos_without_poses_names_the_capture_command(tmp_path, folder):
    (tmp_path / folder).mkdir(exist_ok=True)
    Image.new("RGB", (4, 4)).save(tmp_path / folder / "a.jpg")
    assert "mobilegs capture" in error_of(tmp_path)


def test_a_path_that_is_not_a_capture_raises_an_error(tmp_path):
    assert "no such folder" in error_of(tmp_path / "nowhere")
    assert "not a capture" in error_of(tmp_path)
    (tmp_path / "file").write_text("")
    assert "is a file" in error_of(tmp_path / "file")
