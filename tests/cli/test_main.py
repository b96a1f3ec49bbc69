"""The command line: output, files, error messages."""

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.cli import doctor
from mobilegs.cli.main import VERBS, main
from mobilegs.cli.render import open_scene_and_capture, png_names
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.render.scene import Scene
from tests.support.gpus import GPU
from tests.support.mgs_parts import Piece, parse_parts
from tests.support.tiny import blobs

CONFORMANCE = Path(__file__).parents[1] / "mgs" / "conformance"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain 3DGS scene of fifty blobs."""
    path = tmp_path_factory.mktemp("scene") / "scene.ply"
    write_ply(path, blobs())
    return path


def test_help_names_every_verb_and_imports_nothing_heavy() -> None:
    code = (
        "import sys; from mobilegs.cli.main import main; main(['--help']);"
        "assert not {'torch', 'scipy', 'PIL'} & sys.modules.keys()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for verb in ("demo", "train", "capture", "eval", "render", "info", "doctor"):
        assert f"\n  {verb} " in done.stdout


def test_no_verb_prints_the_help_and_exits_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "mobilegs VERB --help" in capsys.readouterr().out


def test_ctrl_c_prints_one_line_and_exits_with_130(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(doctor, "examine", interrupted)
    assert main(["doctor"]) == 130
    assert capsys.readouterr().err == "mobilegs: interrupted\n"


def test_demo_trains_on_the_built_in_capture_and_prints_a_summary(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from mobilegs.data.demo import capture
    from mobilegs.pipeline import train
    from mobilegs.view import report

    runs: list[train.TrainRun] = []

    def train_capture(run: train.TrainRun, **options: object) -> dict[str, dict[str, float]]:
        runs.append(run)
        return {
            "student": {"psnr": 27.125, "gaussians": 12345, "file_bytes": 67890},
            "teacher": {"psnr": 27.5},
        }

    written: list[Path] = []
    monkeypatch.setattr(capture, "demo_capture", lambda **options: None)
    monkeypatch.setattr(capture, "write_capture", lambda path, dataset: written.append(path))
    monkeypatch.setattr(train, "train_capture", train_capture)
    monkeypatch.setattr(report, "write_report", lambda run_dir: None)
    assert main(["demo", "-o", str(tmp_path / "demo"), "--seed", "3"]) == 0
    [run] = runs
    assert written == [run.capture] == [tmp_path / "demo" / "capture"]
    assert (run.output, run.preset, run.seed) == (tmp_path / "demo", "demo", 3)
    said = capsys.readouterr().out
    assert "12,345 Gaussians, 67,890 bytes" in said
    assert "27.12 dB on held-back photos (teacher: 27.50 dB)" in said


def test_an_interrupted_training_says_how_to_continue(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from mobilegs.pipeline import train

    def train_capture(run: train.TrainRun, **options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(train, "train_capture", train_capture)
    assert main(["train", str(tmp_path), "-o", "there"]) == 130
    assert capsys.readouterr().err == "mobilegs: interrupted: add --resume to continue there\n"


def test_render_writes_a_png_with_the_name_of_each_photo(
    scene: Path, capture: Path, tmp_path: Path
) -> None:
    out = tmp_path / "new" / "folder"
    assert main(["render", str(scene), "--capture", str(capture), "-o", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["view_0.png", "view_8.png"]
    dataset = open_scene_and_capture(scene, capture, None, "cpu")[2]
    drawn = Scene(read_ply(scene)).render(dataset.test[1].camera).image
    written = np.array(Image.open(out / "view_8.png"))
    np.testing.assert_array_equal(written, to_bytes(drawn).numpy())
    assert written.std() > 5


@GPU
def test_render_with_wgpu_gives_the_same_image(scene: Path, capture: Path, tmp_path: Path) -> None:
    words = ["render", str(scene), "--capture", str(capture), "-o", str(tmp_path)]
    assert main([*words, "--renderer", "wgpu"]) == 0
    dataset = open_scene_and_capture(scene, capture, None, "cpu")[2]
    drawn = to_bytes(Scene(read_ply(scene)).render(dataset.test[1].camera).image).int()
    written = torch.from_numpy(np.array(Image.open(tmp_path / "view_8.png"))).int()
    assert (written - drawn).abs().max() <= 2 and written.float().std() > 5


def test_render_of_the_other_split_at_half_size(scene: Path, capture: Path, tmp_path: Path) -> None:
    words = ["render", str(scene), "--capture", str(capture), "-o", str(tmp_path)]
    assert main([*words, "--split", "train", "--downscale", "2"]) == 0
    assert len(list(tmp_path.iterdir())) == 7
    with Image.open(tmp_path / "view_1.png") as picture:
        assert picture.size == (12, 10)


def test_photos_keep_their_folders_but_never_leave_the_output() -> None:
    photos = ["left/a.JPG", "../../b.jpg", "/etc/c.png", "d.jpg", "d.png", "v1.2.jpeg"]
    names = png_names(photos)
    assert [str(names[photo]) for photo in photos] == [
        "left/a.png", "b.png", "etc/c.png", "d.jpg.png", "d.png.png", "v1.2.png",
    ]  # fmt: skip


def test_eval_prints_json_and_nothing_else(
    scene: Path,
    capture: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("MOBILEGS_LPIPS", raising=False)
    assert main(["eval", str(scene), "--capture", str(capture), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert 3 < figures["psnr"] < 40
    assert figures["psnr"] == pytest.approx(np.mean([v["psnr"] for v in figures["views"]]))
    assert figures["lpips_vgg"] is None
    assert (figures["gaussians"], figures["blend"]) == (50, "sorted")
    assert figures["file_bytes"] == scene.stat().st_size
    assert figures["fragments"] > 0 and "fragments_by_level" not in figures


def test_eval_counts_fragments_by_level(capture: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["eval", str(CONFORMANCE / "sq_picture.mgs"), "--capture", str(capture)]
    assert main([*words, "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert len(figures["fragments_by_level"]) == 4
    assert 0 < sum(figures["fragments_by_level"]) < figures["fragments"]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert f"{figures['fragments']:.1f} fragments per pixel; with levels " in printed
    assert "view_8.png" in printed and "mean" in printed


def test_info_counts_a_ply(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(scene), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["gaussians"], found["sh_degree"], found["blend"]) == (50, 1, "sorted")
    assert found["bytes_per_gaussian"] == found["file_bytes"] / 50


@pytest.mark.parametrize(
    ("name", "sentences"),
    [
        ("sq_layers", ["500 Gaussians, 13,080 bytes", "viewers that sort", "31 + 94 + 375"]),
        ("sq_layers", ["step sizes (sq)", "lobes of degree 1", "2 for a first look"]),
        ("nvq_network", ["a network, evaluated for every view", "codebooks (nvq)", "codebooks"]),
        ("nvq_constant", ["the same from all directions", "2.1 of the format"]),
        ("sq_sorted", ["in order of depth", "generator"]),
        ("sq_sorted_lobes_picture", ["in order of depth", "view-dependent: lobes of degree 2"]),
    ],
)
def test_info_describes_a_file(
    name: str, sentences: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    path = CONFORMANCE / f"{name}.mgs"
    assert main(["info", str(path)]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert all(sentence in text for sentence in sentences), text
    assert "unused streams" not in text and "header" in text


def test_info_counts_unused_streams_separately(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts, path = parse_parts((CONFORMANCE / "sq_sorted.mgs").read_bytes()), tmp_path / "idle.mgs"
    spare = {"view-network": 1000, "lobe-decoder": 200, "scale.3": 30, "positions@1": 4, "new": 0}
    parts.pieces += [Piece(name, "raw", bytes(size)) for name, size in spare.items()]
    path.write_bytes(parts.to_bytes())
    shown = []
    for file in (path, CONFORMANCE / "sq_sorted.mgs"):
        assert main(["info", str(file)]) == 0
        shown.append([line.split() for line in capsys.readouterr().out.splitlines()])
    assert ["opacity", "the", "same", "from", "all", "directions"] in shown[0]
    (unused,) = (line for line in shown[0] if line[:1] == ["unused"])
    assert unused[:3] == ["unused", "streams", "1,234"]
    heading = ["part", "bytes", "share", "bytes", "per", "Gaussian"]
    taken = [
        {" ".join(line[:-3]): line[-3] for line in lines[lines.index(heading) + 1 :]}
        for lines in shown
    ]
    assert {**taken[1], "unused streams": "1,234", "header": taken[0]["header"]} == taken[0]


def test_the_parts_in_info_add_up_to_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    for path in sorted(CONFORMANCE.glob("*.mgs")):
        assert main(["info", str(path)]) == 0
        lines = capsys.readouterr().out.splitlines()
        table = lines[next(i for i, line in enumerate(lines) if line.startswith(" part")) + 1 :]
        found = sum(int(line.split("%")[0].split()[-2].replace(",", "")) for line in table)
        assert found == path.stat().st_size


def test_doctor_checks_kernels_and_gpu(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    examined = doctor.examine()
    monkeypatch.setattr(doctor, "examine", lambda: examined)
    assert main(["doctor", "--json"]) == 0
    findings = {finding["what"]: finding for finding in json.loads(capsys.readouterr().out)}
    assert findings["PyTorch"]["found"].startswith(torch.__version__)
    assert all(f["remedy"] for f in findings.values() if f["state"] == "no")
    assert {"CPU kernels", "GPU", "CUDA kernels", "LPIPS weights"} <= findings.keys()
    assert main(["doctor"]) == 0
    assert "CPU kernels" in capsys.readouterr().out


def test_doctor_suggests_only_installations_that_help(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "find_module", lambda name: False)
    monkeypatch.setattr(doctor, "has_nvidia", lambda: False)
    assert doctor.gpu_kernels().state == "none"  # not needed without such a card
    monkeypatch.setattr(doctor, "has_nvidia", lambda: True)
    assert "mobilegs[cuda]" in doctor.gpu_kernels().remedy
    able = doctor.Finding("GPU renderer", "yes", "made up")
    assert "mobilegs[native]" in doctor.window(able).remedy
    monkeypatch.setattr(doctor, "find_module", lambda name: True)
    monkeypatch.setattr(doctor.platform, "system", lambda: "Linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert doctor.window(able).state == "none"
    monkeypatch.setenv("DISPLAY", ":0")
    assert doctor.window(able).state == "yes"


def test_doctor_prints_the_address_for_phones(monkeypatch: pytest.MonkeyPatch) -> None:
    from mobilegs.view import serve

    monkeypatch.setattr(serve, "own_address", lambda: "192.168.7.4")
    assert "192.168.7.4" in doctor.phones().found
    for nowhere in ("127.0.0.1", None):
        monkeypatch.setattr(serve, "own_address", lambda found=nowhere: found)
        assert doctor.phones().state == "none"


def test_a_full_disk_gives_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setitem(VERBS, "doctor", full)
    assert main(["doctor"]) == 2
    assert capsys.readouterr().err == "mobilegs: the disk is full; make room\n"


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("scene.obj", b"", "not a scene: a .mgs, .ply, .spz, .sog, .glb or .splat"),
        ("scene.ply", b"ply", "is not a PLY file"),
        ("scene.mgs", b"ply", "is not a .mgs scene but looks like a PLY"),
        ("gone.ply", None, "gone.ply does not exist"),
        ("gone.obj", None, "gone.obj does not exist"),
    ],
)
def test_files_that_are_not_scenes_are_refused_in_one_line(
    name: str,
    content: bytes | None,
    sentence: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert main(["info", str(tmp_path / name)]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert sentence in printed.err
