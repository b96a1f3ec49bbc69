"""The photos among the files of a folder: exports of apps, cards of cameras, versions, links."""

import logging
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.capture import CaptureRun, is_capture_source
from mobilegs.capture.photos import list_photos, prepared_names
from mobilegs.capture.run import digest_inputs, list_inputs, stage_keys
from mobilegs.cli.main import main
from mobilegs.errors import InputError

SHOTS = 3


def write(path: Path, width: int, look: int) -> None:
    """Write a picture whose content depends on `look` only; not an image for other suffixes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() not in (".jpg", ".png"):
        path.write_bytes(b"x" * width)
        return
    colours = np.random.default_rng(look).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    picture = Image.fromarray(colours).resize((width, width * 3 // 4), Image.Resampling.BILINEAR)
    picture.save(path, format="PNG" if path.suffix == ".png" else "JPEG", quality=90)


def write_layout(root: Path, layout: dict[str, int | tuple[int, int]]) -> None:
    """Write the files of a layout: `{}` stands for the number of a shot, the value is the width.

    A pair is the width and what is added to the shot's number: another scene.
    """
    for name, given in layout.items():
        width, scene = given if isinstance(given, tuple) else (given, 0)
        for shot in range(SHOTS if "{}" in name else 1):
            write(root / name.format(shot), width, shot + scene)


# id: (layout, names of the photos, what the warning says)
SETS: dict[str, tuple[dict[str, int | tuple[int, int]], str, list[str]]] = {
    "Polycam": (
        {
            "scan/keyframes/images/17000{}.jpg": 64,
            "scan/keyframes/corrected_images/17000{}.jpg": (64, 50),
            "scan/keyframes/depth/17000{}.png": 16,
            "scan/keyframes/confidence/17000{}.png": 16,
            "scan/thumbnail.jpg": 16,
        },
        "scan/keyframes/images/17000{}.jpg",
        [
            "depth maps (3)",
            "confidence maps (3)",
            "thumbnails and previews (1)",
            "second versions in scan/keyframes/corrected_images (3)",
        ],
    ),
    "Polycam with large corrected images": (
        {"keyframes/images/{}.jpg": 32, "keyframes/corrected_images/{}.jpg": (64, 50)},
        "keyframes/corrected_images/{}.jpg",
        ["second versions in keyframes/images (3)"],
    ),
    "3D Scanner App": (
        {
            "frame_0000{}.jpg": 64,
            "depth_0000{}.png": 16,
            "conf_0000{}.png": 16,
            "thumb_0000{}.jpg": 16,
            "textured_output.jpg": 64,
        },
        "frame_0000{}.jpg",
        ["depth maps (3)", "confidence maps (3)", "thumbnails and previews (3)", "textures (1)"],
    ),
    "Scaniverse": (
        {"imgl/{}.jpg": 64, "img/{}.jpg": 32, "depth/{}.dmp": 8},
        "imgl/{}.jpg",
        ["second versions in img (3)"],
    ),
    "Record3D": (
        {"EXR_RGBD/rgb/{}.png": 64, "EXR_RGBD/depth/{}.png": 16},
        "EXR_RGBD/rgb/{}.png",
        ["depth maps (3)"],
    ),
    "RealityScan": (
        {"IMG_{}.jpg": 64, "IMG_{}.jpg.mask.png": 64, "IMG_{}.jpg.depth.png": 64},
        "IMG_{}.jpg",
        ["depth maps (3)"],
    ),
    "Mip-NeRF 360": (
        {"images/{}.jpg": 64, "images_2/{}.jpg": 32, "images_4/{}.jpg": 16},
        "images/{}.jpg",
        ["images outside images/ (6)"],
    ),
    "sizes in folders of any name": (
        {"a/{}.jpg": 16, "b/{}.jpg": 64, "c/{}.jpg": 32},
        "b/{}.jpg",
        ["second versions in a (3)", "second versions in c (3)"],
    ),
    "copies": (
        {"Album/{}.jpg": 64, "Photos from 2023/{}.jpg": 64},
        "Album/{}.jpg",
        ["second versions in Photos from 2023 (3)"],
    ),
    "masks beside photos": (
        {"{}.jpg": 64, "{}.jpg.png": 64, "{}_mask.png": 64, "dynamic_mask_{}.png": 64},
        "{}.jpg",
        [],
    ),
    "folder of masks": ({"images/{}.jpg": 64, "masks/{}.jpg.png": 64}, "images/{}.jpg", []),
    "DJI": ({"DCIM/DJI_{}.JPG": 64, "DCIM/DJI_{}.DNG": 8}, "DCIM/DJI_{}.JPG", ["camera raws"]),
    "ProRAW": ({"IMG_{}.HEIC": 8, "IMG_{}.DNG": 8}, "IMG_{}.HEIC", ["camera raws"]),
    "Pixel": (
        {"PXL_{}.RAW-01.MP.COVER.jpg": 64, "PXL_{}.RAW-02.ORIGINAL.dng": 8},
        "PXL_{}.RAW-01.MP.COVER.jpg",
        ["camera raws beside another file of the photo (3)"],
    ),
    "raws in their folder": ({"jpg/D{}.jpg": 64, "raw/D{}.nef": 8}, "jpg/D{}.jpg", ["camera raws"]),
    "HEIC as JPEG, too": ({"IMG_{}.heic": 8, "IMG_{}.jpg": 64}, "IMG_{}.jpg", ["HEIC photos"]),
    "edits of an iPhone": (
        {"IMG_100{}.HEIC": 8, "IMG_E100{}.JPG": 64},
        "IMG_100{}.HEIC",
        ["edits beside another file of the photo (3)"],
    ),
    "HEIC converted into a folder": (
        {"phone/{}.png": 64, "converted/{}.jpg": 64},
        "converted/{}.jpg",
        ["second versions in phone (3)"],
    ),
    "small ones beside": (
        {"{}.jpg": 64, "{} (Small).jpg": 32, "{}-64x48.jpg": 64, "{}_thumb.jpg": 16},
        "{}.jpg",
        ["smaller versions beside another file of the photo (6)", "thumbnails and previews (3)"],
    ),
    "estimated maps": (
        {"images/{}.jpg": 64, "mono_depth/{}.png": 64, "normals_from_pretrain/{}.png": 64},
        "images/{}.jpg",
        ["depth maps (3), normal maps (3)"],
    ),
    "edits of a Pixel": ({"PXL_{}.jpg": 64, "PXL_{}~2.jpg": (64, 9)}, "PXL_{}.jpg", ["edits"]),
    "edits of Google Photos": ({"{}.jpg": 64, "{}-edited.jpg": (64, 9)}, "{}.jpg", ["edits"]),
}


@pytest.mark.parametrize(("layout", "photos", "said"), SETS.values(), ids=list(SETS))
def test_one_set_of_photos_is_taken_and_said(
    layout: dict[str, int | tuple[int, int]],
    photos: str,
    said: list[str],
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    write_layout(tmp_path, layout)
    assert list_photos(tmp_path) == [tmp_path / photos.format(shot) for shot in range(SHOTS)]
    assert len(caplog.messages) == bool(said)
    for words in said:
        assert words in caplog.text


# layouts of which everything is a photo
ALL: dict[str, dict[str, int | tuple[int, int]]] = {
    "rig": {"left/{}.jpg": 64, "right/{}.jpg": (64, 9)},
    "frames of two videos": {"a/frame_{}.jpg": 64, "b/frame_{}.jpg": (32, 9)},
    "another shape": {"a/{}.jpg": 64, "b/{}.png": (64, 9)},
    "photos of a mask": {"mask_{}.jpg": 64},
    "only small ones": {"{}_resized.jpg": 64, "old-{}-640x480.jpg": 64},
    "photos of a texture": {"texture_{}.jpg": 64},
    "raws of another day": {"monday/D{}.jpg": 64, "friday/D{}.nef": 8},
}


@pytest.mark.parametrize("layout", ALL.values(), ids=list(ALL))
def test_different_photos_are_all_taken(
    layout: dict[str, int | tuple[int, int]], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_layout(tmp_path, layout)
    assert len(list_photos(tmp_path)) == SHOTS * len(layout)
    assert caplog.messages == []


def test_cameras_of_a_rig_may_have_any_size(tmp_path: Path) -> None:
    write_layout(tmp_path, {"wide/{}.jpg": 64, "tele/{}.jpg": 32, "tele/depth/{}.png": 16})
    assert len(list_photos(tmp_path, rig=True)) == 2 * SHOTS
    assert len(list_photos(tmp_path)) == SHOTS


def test_a_small_version_may_be_turned(tmp_path: Path) -> None:
    """The camera turns a photo by EXIF, the program that reduces it by its pixels."""
    write_layout(tmp_path, {"large/{}.jpg": 64})
    (tmp_path / "web").mkdir()
    for shot in range(SHOTS):
        with Image.open(tmp_path / f"large/{shot}.jpg") as picture:
            small = picture.transpose(Image.Transpose.ROTATE_90).resize((24, 32))
        small.save(tmp_path / f"web/{shot}.png")
    assert list_photos(tmp_path) == [tmp_path / f"large/{shot}.jpg" for shot in range(SHOTS)]


def test_textures_are_those_that_a_model_names(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """KIRI Engine writes 3DModel.jpg, RealityCapture model_u1_v1.png."""
    write_layout(tmp_path, {"3DModel.jpg": 64, "model_u1_v1.png": 64, "p{}.jpg": 64})
    (tmp_path / "m.mtl").write_bytes(b"newmtl a\nmap_Kd 3DModel.jpg\nmap_Kd ./model_u1_v1.png\n")
    assert len(list_photos(tmp_path)) == SHOTS
    assert "textures (2)" in caplog.text


def test_only_images_that_are_no_photos_are_refused(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_layout(tmp_path, {"depth/{}.png": 16})
    with pytest.raises(InputError, match="has no photos in it"):
        list_inputs(tmp_path)
    assert "depth maps (3)" in caplog.text


# --- links ----------------------------------------------------------------------------------------


def test_links_are_followed_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    write_layout(tmp_path, {"disk/deep/{}.jpg": 64, "disk/x.jpg": (64, 9), "mine/y.jpg": (64, 8)})
    mine, disk = tmp_path / "mine", tmp_path / "disk"
    (mine / "a_link.jpg").symlink_to(mine / "y.jpg")  # of what is there already
    (mine / "x.jpg").symlink_to(disk / "x.jpg")
    (mine / "day").symlink_to(disk / "deep")
    (mine / "same_day").symlink_to(disk / "deep")
    (mine / "up").symlink_to("..")
    (disk / "deep" / "back").symlink_to(mine)
    (mine / "gone.jpg").symlink_to("nowhere.jpg")
    (mine / "round.jpg").symlink_to("round.jpg")
    names = ["day/0.jpg", "day/1.jpg", "day/2.jpg", "x.jpg", "y.jpg"]
    assert list_photos(mine) == [mine / name for name in names]
    assert "links to missing files (2)" in caplog.text
    linked = tmp_path / "linked"
    linked.symlink_to(mine)
    assert len(list_photos(linked)) == 5


# --- videos ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("layout", "video", "said"),
    [
        ({"rgb.mp4": 90, "depth/{}.png": 16, "confidence/{}.png": 16}, "rgb.mp4", "rgb.mp4"),
        ({"clip.MOV": 90, "poster.jpg": 64}, "clip.MOV", "too few photos"),
        ({"DCIM/GX.MP4": 900, "DCIM/GX.THM": 9, "DCIM/a.mp4": 9}, "DCIM/GX.MP4", "not a.mp4"),
        ({"a.mp4": 90, "b.mp4": 80}, "", "holds 2 videos (a.mp4, b.mp4): give one of them"),
    ],
)
def test_a_folder_with_one_video_is_that_video(
    layout: dict[str, int], video: str, said: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_layout(tmp_path, dict(layout))
    assert is_capture_source(tmp_path)
    if not video:
        with pytest.raises(InputError) as caught:
            list_inputs(tmp_path)
        assert said in str(caught.value)
        return
    inputs = list_inputs(tmp_path)
    assert inputs == [tmp_path / video] and said in caplog.text
    run = CaptureRun(tmp_path, tmp_path / "out")
    direct = list_inputs(tmp_path / video)
    assert stage_keys(run, digest_inputs(inputs, lambda *_: None)) == stage_keys(
        run, digest_inputs(direct, lambda *_: None)
    )


@pytest.mark.parametrize("verb", ["capture", "train"])
def test_several_videos_are_refused_in_a_sentence(
    verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pycolmap", reason="needs the extra capture")
    write_layout(tmp_path, {"in/a.mp4": 90, "in/b.mp4": 80})
    assert main([verb, str(tmp_path / "in"), "-o", str(tmp_path / "out")]) == 2
    printed = capsys.readouterr().err
    assert "holds 2 videos (a.mp4, b.mp4)" in printed and printed.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_videos_of_live_photos_are_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    write_layout(tmp_path, {"IMG_{}.HEIC": 9, "IMG_{}.MOV": 90})
    assert len(list_inputs(tmp_path)) == SHOTS
    assert "not its videos: IMG_0.MOV, IMG_1.MOV, IMG_2.MOV" in caplog.text


# --- poses that are not read ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "text", "tool"),
    [
        ("keyframes/cameras/1.json", '{"t_00": 1.0}', "Polycam"),
        ("frame_00001.json", '{"cameraPoseARFrame": []}', "3D Scanner App"),
        ("frames.pb", "", "Scaniverse"),
        ("metadata.json", '{"poses": []}', "Record3D"),
        ("p0.xmp", "<xcr:Rotation>1 0 0 0 1 0 0 0 1</xcr:Rotation>", "RealityScan"),
        ("p0.xmp", "<x:xmpmeta crs:Exposure='1'>", ""),
        ("cameras.xml", "<document><chunk>", "Metashape"),
        ("opensfm/reconstruction.json", "[]", "OpenDroneMap"),
    ],
)
def test_poses_that_are_not_read_are_said(
    file: str, text: str, tool: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_layout(tmp_path, {"p{}.jpg": 64})
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / file).write_text(text, encoding="utf-8")
    assert len(list_inputs(tmp_path)) == SHOTS
    assert caplog.messages == [] if not tool else tool in caplog.text
    assert not tool or "poses are computed from the photos" in caplog.text


# --- plain folders --------------------------------------------------------------------------------


def test_plain_folders_keep_their_names_and_say_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_layout(tmp_path, {"a/{}.jpg": 64, "b/c {}.jpg": (64, 9), "{}.jpg": (64, 18)})
    shutil.copy(tmp_path / "0.jpg", tmp_path / "._0.jpg")
    (tmp_path / "run").mkdir()
    shutil.copy(tmp_path / "0.jpg", tmp_path / "run" / "render.jpg")
    (tmp_path / "run" / "config.json").touch()
    with caplog.at_level(logging.WARNING):
        names = list(prepared_names(list_inputs(tmp_path)).values())
    top = [f"{shot}.jpg" for shot in range(SHOTS)]
    assert names == [*top, *(f"a_{name}" for name in top), *(f"b_c_{name}" for name in top)]
    assert caplog.messages == []
