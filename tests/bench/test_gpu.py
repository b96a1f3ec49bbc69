"""What bench/gpu does around the GPU: shares out time, keeps results, goes on elsewhere."""

import json
import os
import shutil
import signal
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path

import paper
import pytest
import torch
from paper_places import PLACES, Place

sys.path.insert(0, str(Path(__file__).parents[2] / "bench" / "gpu"))
import bring
import parcel
import ready
from compact import STEPS, TooLargeError, grown, shrunk
from figures import Figures

from mobilegs.errors import InputError
from mobilegs.formats.ply import write_ply
from mobilegs.pipeline.train import TrainRun, train_run
from mobilegs.train.student.trainer import Student

ROOT = Path(__file__).parents[2]
Run = Callable[..., subprocess.CompletedProcess]
# stands for a Python with a GPU: notes what it is asked, fails or takes long where it is told to
STAND_IN = """#!/usr/bin/env bash
echo "$* [data ${MOBILEGS_DATA:-none}]" >>"$ASKED"
for word in ${FAILING:-}; do case "$*" in *"$word"*) exit 3 ;; esac; done
for word in ${SLOW:-}; do case "$*" in *"$word"*) sleep 30 ;; esac; done
case "$*" in
  *"parcel.py ${REALLY:-never}"*) exec "$REAL" "$@" ;;
  *frames_gpu.py*) while [ "$1" != --json ]; do shift; done; echo '"ms"' >>"$2" ;;
esac
"""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs bench/gpu/run.sh with a stand-in for Python; `asked()` has what it was asked since."""
    python = tmp_path / "python"
    python.write_text(STAND_IN)
    python.chmod(0o755)
    monkeypatch.delenv("MOBILEGS_DATA", raising=False)
    folders = {"KEPT": "kept", "RUNS": "runs", "BROUGHT": "brought", "ASKED": "asked.txt"}
    given = {name: str(tmp_path / folder) for name, folder in folders.items()}

    def call(*words: str, **more: object) -> subprocess.CompletedProcess:
        (tmp_path / "asked.txt").write_text("")
        env = {**os.environ, **given, "PYTHON": str(python), "REAL": sys.executable}
        env |= {name: str(value) for name, value in more.items()}
        command = [str(ROOT / "bench/gpu/run.sh"), str(tmp_path / "out"), *words]
        return subprocess.run(command, env=env, capture_output=True, text=True, timeout=60)

    return call


def asked(folder: Path, word: str) -> list[str]:
    """What the stand-in was asked by the last call, of lines with a word."""
    return [line for line in (folder / "asked.txt").read_text().splitlines() if word in line]


def parts(folder: Path) -> list[list[str]]:
    """Name and exit code of each part."""
    return [line.split()[:2] for line in (folder / "runs/logs/parts.txt").read_text().splitlines()]


def test_the_script_is_one_that_bash_can_read(run: Run) -> None:
    subprocess.run(["bash", "-n", ROOT / "bench/gpu/run.sh"], check=True)
    wrong = run("frames")
    assert wrong.returncode == 2 and "no agenda frames" in wrong.stderr


def test_what_has_succeeded_is_not_repeated(run: Run, tmp_path: Path) -> None:
    assert run(FAILING="test_cuda").returncode == 1
    assert [["tests", "3"], ["kernels", "0"]] == [
        part for part in parts(tmp_path) if "gsplat" not in part[0]
    ]
    assert asked(tmp_path, "collect.py") and asked(tmp_path, "packed.py")  # all the same
    assert run().returncode == 0
    assert asked(tmp_path, "test_cuda") and not asked(tmp_path, "bench/gpu/kernels_gpu.py --json")
    assert parts(tmp_path)[-1] == ["tests", "0"]


def test_a_part_ends_when_the_time_does_and_results_are_written(run: Run, tmp_path: Path) -> None:
    found = run(SLOW="test_cuda", SECONDS_IN_ALL=2, SECONDS_AT_LEAST=1)
    assert found.returncode == 1
    assert parts(tmp_path) == [["tests", "124"]]
    assert "kernels: left to the next call" in found.stdout
    assert asked(tmp_path, "collect.py") and asked(tmp_path, "packed.py")


def test_gsplat_has_its_own_time_once(run: Run, tmp_path: Path) -> None:
    lock = tmp_path / "kept/extensions/gsplat_cuda/lock"
    lock.parent.mkdir(parents=True)
    lock.touch()  # of a build that was cut short
    found = run(SLOW="gsplat.cuda", SECONDS_OF_GSPLAT=1)
    assert found.returncode == 0 and not lock.exists()  # nothing of ours is lost
    assert not asked(tmp_path, "--by gsplat") and asked(tmp_path, "kernels_gpu.py")
    assert (tmp_path / "runs/gsplat.failed").exists()
    run()
    assert not asked(tmp_path, "gsplat.cuda")
    (tmp_path / "runs/gsplat.failed").unlink()
    run()
    assert asked(tmp_path, "gsplat.cuda")
    [by_gsplat] = asked(tmp_path, "--by gsplat")
    assert "kernels_gpu.py" in by_gsplat
    assert run(FAILING="find_spec").returncode == 0  # it is there already, and not looked for


def test_what_calls_bring_adds_up(run: Run, tmp_path: Path) -> None:
    brought, kept = tmp_path / "brought", tmp_path / "kept"
    for name in (
        "data/lpips/a.npz",
        "wheels/tyro.whl",
        "parcel/parcel-0.bin",
        "parcel/parcel-1.bin",
    ):
        (brought / name).parent.mkdir(parents=True, exist_ok=True)
        (brought / name).write_text(name)
    assert run("load").returncode == 0
    [install] = asked(tmp_path, "pip install")
    assert "--no-index" in install and "tyro.whl" in install
    assert not asked(tmp_path, "ready.py")
    shutil.rmtree(brought)
    for name in ("data/bonsai/photo.jpg", "parcel/parcel-0.bin"):
        (brought / name).parent.mkdir(parents=True)
        (brought / name).write_text(name)
    assert run("load").returncode == 0
    assert not asked(tmp_path, "pip install")
    assert {path.name for path in (kept / "data").iterdir()} == {"lpips", "bonsai"}
    assert [path.name for path in (kept / "parcel").iterdir()] == ["parcel-0.bin"]

    shutil.rmtree(brought)
    shutil.rmtree(kept / "parcel")
    assert run(SECONDS_IN_ALL=5, SECONDS_AT_LEAST=1).returncode == 0
    [bonsai] = asked(tmp_path, "mobilegs train")
    assert f"{kept}/data/bonsai" in bonsai and f"[data {kept}/data]" in bonsai
    assert run(FAILING="ready.py").returncode == 1  # says so, and tries nothing
    assert not asked(tmp_path, "test_cuda")


def test_checks_of_several_machines_add_up(run: Run, tmp_path: Path) -> None:
    def moved() -> None:
        """To another machine, with what came back of the last call."""
        for name in ("runs", "kept", "brought"):
            shutil.rmtree(tmp_path / name, ignore_errors=True)
        shutil.copytree(tmp_path / "out", tmp_path / "brought/parcel")
        shutil.rmtree(tmp_path / "out")
        (tmp_path / "kept/data/bonsai").mkdir(parents=True)

    (tmp_path / "kept/data/bonsai").mkdir(parents=True)
    assert run(FAILING="train", REALLY="pack").returncode == 1
    assert asked(tmp_path, "test_cuda") and asked(tmp_path, "gsplat.cuda")
    moved()
    assert run(FAILING="train", REALLY="open").returncode == 1
    assert parts(tmp_path)[-2:] == [["bonsai", "3"]] * 2
    again = ("test_cuda", "kernels_gpu", "gsplat.cuda")
    assert not any(asked(tmp_path, word) for word in again)

    scene = tmp_path / "runs/scene/bonsai/scene.mgs"
    scene.parent.mkdir(parents=True)
    scene.write_bytes(b"whole")  # the training has ended, and nothing was timed yet
    run(FAILING="gsplat.cuda frames_gpu", REALLY="pack")
    assert asked(tmp_path, "gsplat.cuda") and (tmp_path / "runs/gsplat.failed").exists()
    moved()
    assert run(REALLY="open").returncode == 0
    assert scene.read_bytes() == b"whole"
    assert asked(tmp_path, "frames_gpu") and not asked(tmp_path, "gsplat.cuda")
    assert not any(asked(tmp_path, word) for word in (*again, "mobilegs train", "native.py"))


def test_kernels_of_another_machine_are_not_on_this_one(run: Run, tmp_path: Path) -> None:
    (tmp_path / "runs/logs").mkdir(parents=True)
    (tmp_path / "runs/logs/parts.txt").write_text("build 0 70\ntests 0 90\n")
    found = run(FAILING="kernel_level", SECONDS_IN_ALL=1)
    assert "build: left to the next call" in found.stdout
    assert "tests: left" not in found.stdout


def test_frames_are_timed_once_for_each_scene(run: Run, tmp_path: Path) -> None:
    scene = tmp_path / "runs/horns-499"
    for name in ("ours-60000-0/scene.mgs", "teacher-mini-splatting-30000-0/seconds.json"):
        (scene / name).parent.mkdir(parents=True)
        (scene / name).touch()
    generator = torch.Generator().manual_seed(3)
    write_ply(scene / "teacher-mini-splatting-30000-0/teacher.ply", blobs(50, generator))
    (tmp_path / "kept/data/llff_horns").mkdir(parents=True)
    assert run("paper", REALLY="pack").returncode == 0
    [frames] = asked(tmp_path, "frames_gpu.py")
    assert f"--capture {tmp_path}/kept/data/llff_horns" in frames
    assert run("paper", FAILING="bench/paper.py").returncode == 1  # something is missing
    assert not asked(tmp_path, "frames_gpu.py")

    # on another machine, from what came back of the first call
    shutil.copytree(tmp_path / "out", tmp_path / "brought/parcel")
    for name in ("runs", "kept"):
        shutil.rmtree(tmp_path / name)
    found = run("paper", REALLY="open")
    assert "goes on from what was brought, rounded" in found.stdout
    assert (scene / "teacher-mini-splatting-30000-0/teacher.ply").exists()
    order = [line.split()[0] for line in (tmp_path / "asked.txt").read_text().splitlines()]
    assert order.index("bench/gpu/parcel.py") < order.index("bench/paper.py")


# --- what a machine lacks


def test_what_a_machine_lacks_is_said_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def said() -> str:
        with pytest.raises(SystemExit) as end:
            ready.main()
        return str(end.value)

    nvrtc = types.SimpleNamespace(nvrtcVersion=lambda: (0, 13, 0))
    modules = {
        name: types.SimpleNamespace(**dict.fromkeys(names)) for name, names in ready.NEEDED.items()
    }
    for name, module in (modules | {"cuda.bindings.nvrtc": nvrtc}).items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(ready, "lacks", lambda name: False)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert "offers" in said() and "no CUDA device" in said()

    def broken() -> None:
        raise RuntimeError("libnvrtc.so.13 was not found")

    nvrtc.nvrtcVersion = broken
    assert "cannot compile kernels (libnvrtc.so.13 was not found)" in said()
    del modules["cuda.core"].ObjectCode
    assert "cannot compile kernels (cuda.core has no ObjectCode)" in said()
    versions = {"cuda-core": "0.9.1", "torch": "2.13.0a0+git1", "numpy": "1.9"}
    monkeypatch.setattr(ready, "version", lambda name: versions.get(name, "99"))
    assert "has numpy 1.9, not 1.26 or later; cuda-core 0.9.1, not 1.0 or later" in said()
    monkeypatch.setattr(ready, "lacks", lambda name: name == "cuda.core")
    assert "has no cuda.core: PYTHON=" in said()


# --- tensors that travel


def blobs(count: int, generator: torch.Generator):
    """A scene whose numbers are like those of trained ones."""
    from mobilegs.gaussians import Gaussians

    def normal(*shape: int, by: float = 1.0) -> torch.Tensor:
        return by * torch.randn(*shape, generator=generator)

    sh = torch.cat([normal(count, 1, 3), normal(count, 15, 3, by=0.1)], dim=1)
    quats = normal(count, 4)
    return Gaussians(
        means=normal(count, 3),
        quats=quats / quats.norm(dim=1, keepdim=True),
        log_scales=normal(count, 3) - 4,
        logit_opacities=normal(count, by=2.0),
        sh=sh,
    )


def test_tensors_come_back_as_near_as_it_is_said(generator: torch.Generator) -> None:
    def normal(*shape: int) -> torch.Tensor:
        return torch.randn(*shape, generator=generator)

    tensors = {
        "/state/adam/means/value": normal(500, 3),
        "/state/adam/means/exp_avg": normal(500, 3),
        "/state/adam/means/step": torch.tensor(7.0),
        "/state/adam/sh_rest/value": 30 * normal(500, 15, 3),
        "/state/adam/log_scales/value": 40 * normal(500, 3),  # more than 16 bits of steps
        "/state/adam/lobe_latents/value": normal(500, 12),
        "/state/adam/empty/value": torch.zeros(500, 0, 3),
        "/state/strategy/views": torch.ones(900, dtype=torch.int32),
        "/state/strategy/gradients": normal(500),
        "/state/shared/network.weight/exp_avg": normal(64, 60),
        "/state/generator": torch.arange(200, dtype=torch.uint8),
    }
    content = shrunk(tensors.items(), 500, 1 << 20)
    found = grown(content)
    assert [(n, t.shape, t.dtype) for n, t in found.items()] == [
        (n, t.shape, t.dtype) for n, t in tensors.items()
    ]
    for name, tensor in tensors.items():
        error = (
            float((found[name].double() - tensor.double()).abs().amax()) if tensor.numel() else 0
        )
        of = name.split("/")[-2]
        if name.endswith(("means/exp_avg", "means/step", "strategy/views")):
            assert not found[name].any(), name  # begun anew; of before the draw
        elif of in STEPS:
            assert 0 < error < 0.501 * STEPS[of], name
        elif of == "lobe_latents":
            assert 0 < error < 2**-10 * float(tensor.abs().max()), name
        else:
            assert error == 0, name
    with pytest.raises(TooLargeError):
        shrunk(tensors.items(), 500, len(content) // 2)


def test_a_teacher_that_travelled_looks_as_before(
    tmp_path: Path, generator: torch.Generator, capture: Path
) -> None:
    from mobilegs.data import load_capture
    from mobilegs.evaluate.metrics import psnr
    from mobilegs.scene_file import open_scene

    there, here = (tmp_path / name / "blobs/teacher-x/teacher.ply" for name in ("a", "b"))
    there.parent.mkdir(parents=True)
    write_ply(there, blobs(2000, generator))
    [told] = parcel.pack(tmp_path / "a", tmp_path / "out")
    assert told.startswith("blobs/teacher-x/teacher.ply travels")
    assert parcel.unpack(tmp_path / "out", tmp_path / "b") == ["blobs/teacher-x/teacher.ply"]
    camera = load_capture(capture).test[0].camera
    device = torch.device("cpu")
    pictures = [open_scene(path, device).render(camera).image for path in (there, here)]
    assert 50 < psnr(*pictures) < 90
    size = sum(path.stat().st_size for path in (tmp_path / "out").iterdir())
    assert size < there.stat().st_size / 3
    # what is there stays
    assert parcel.unpack(tmp_path / "out", tmp_path / "b") == []


def test_what_does_not_fit_is_named_and_the_rest_travels(
    tmp_path: Path, generator: torch.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    for scene, count, when in (("old", 100, 1), ("large", 4000, 2), ("new", 1000, 3)):
        path = tmp_path / "runs" / scene / "teacher-x" / "teacher.ply"
        path.parent.mkdir(parents=True)
        write_ply(path, blobs(count, generator))
        os.utime(path, (when, when))
    note = tmp_path / "runs/large/ours-1-0/cell.json"
    note.parent.mkdir()
    note.write_text("{}")
    monkeypatch.setattr(parcel, "THERE_BYTES", 300_000)
    monkeypatch.setattr(parcel, "PART_BYTES", 40_000)
    out = tmp_path / "out"
    told = parcel.pack(tmp_path / "runs", out)
    assert [line.split()[:2] for line in told] == [
        ["new/teacher-x/teacher.ply", "travels,"],
        ["large/teacher-x/teacher.ply", "stays,"],
        ["old/teacher-x/teacher.ply", "travels,"],
    ]
    assert 2 <= len(list(out.iterdir())) <= parcel.FILES
    assert max(path.stat().st_size for path in out.iterdir()) <= 40_000
    taken = parcel.unpack(out, tmp_path / "there")
    assert set(taken) == {"new/teacher-x/teacher.ply", "old/teacher-x/teacher.ply"}
    assert (tmp_path / "there/large/ours-1-0/cell.json").exists()
    (out / "parcel-1.bin").unlink()
    with pytest.raises(InputError, match="bring"):
        parcel.unpack(out, tmp_path / "elsewhere")


def test_a_training_goes_on_on_another_machine(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = ("teacher.steps=5000", "teacher.max_splats=300")
    monkeypatch.setitem(
        PLACES, "blobs", Place("small", (capture.name,), 1, preset="cpu", settings=settings)
    )
    steps, advance = [], Student.advance

    def one_machine(runs: Path, *, until: int) -> None:
        """Trains as long as it may."""

        def counted(stage: Student, views: list) -> object:
            result = advance(stage, views)
            steps.append(stage.done)
            if stage.done == until:
                os.kill(os.getpid(), signal.SIGINT)
            return result

        monkeypatch.setattr(Student, "advance", counted)
        words = ("paper.py", "--data", str(capture.parent), "--scenes", "blobs", "--steps", "40")
        rows = ("--rows", "teacher", "ours", "--runs", str(runs), "--json", str(runs / "all.json"))
        monkeypatch.setattr("sys.argv", [*words, *rows])
        paper.main()

    first, second = tmp_path / "first", tmp_path / "second"
    with pytest.raises(KeyboardInterrupt):
        one_machine(first, until=12)
    told = parcel.pack(first, tmp_path / "out")
    assert ["travels," in line for line in told] == [True, True]  # a teacher, and a checkpoint
    [before] = first.glob("blobs/teacher-*/cell.json")
    begun = steps[-1]
    parcel.unpack(tmp_path / "out", second)
    one_machine(second, until=0)
    assert steps[:begun] == list(range(1, 13)) and steps[begun:] == list(range(13, 21))
    cells = json.loads((second / "all.json").read_text())["cells"].values()
    assert {cell["row"] for cell in cells} == {"ours", "teacher"}
    assert json.loads(before.read_text()) in cells  # not measured again
    assert all(cell["psnr"] > 10 for cell in cells)
    travelled = json.loads((second / parcel.TRAVELLED).read_text())
    names = [entry["went_on_from"].split("/")[-1] for entry in travelled]
    assert names == ["teacher.ply", "checkpoint.safetensors"]
    # done: there is no checkpoint any more, and none is brought back
    assert parcel.unpack(tmp_path / "out", second) == []


def test_a_run_with_its_teacher_beside_it_goes_on_on_another_machine(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps, advance = [], Student.advance

    def counted(stage: Student, views: list) -> object:
        result = advance(stage, views)
        steps.append(stage.done)
        if len(steps) == 12:
            os.kill(os.getpid(), signal.SIGINT)
        return result

    def too_large(path: Path, most: int) -> bytes:
        raise TooLargeError

    def one_machine(runs: Path) -> dict:
        folder = runs / "scene" / "blobs"
        settings = (("teacher.max_splats=300",),)
        options = {"preset": "cpu", "steps": 40, "resume": True, "settings": settings}
        return train_run(TrainRun(capture, folder, downscale=1, device="cpu", **options))

    monkeypatch.setattr(Student, "advance", counted)
    first, second = tmp_path / "first", tmp_path / "second"
    with pytest.raises(KeyboardInterrupt):
        one_machine(first)
    told = parcel.pack(first, tmp_path / "out")
    assert ["travels," in line for line in told] == [True, True]
    with monkeypatch.context() as patched:
        patched.setattr(parcel, "_teacher", too_large)
        [sentence] = parcel.pack(first, tmp_path / "less")
    assert "teacher.ply stays" in sentence  # and the checkpoint, which is of no use without it
    parcel.unpack(tmp_path / "out", second)
    metrics = one_machine(second)
    assert steps == list(range(1, 21)) and metrics["student"]["psnr"] > 10
    parcel.pack(second, tmp_path / "out")
    parcel.unpack(tmp_path / "out", tmp_path / "third")
    scenes = [runs / "scene/blobs/scene.mgs" for runs in (second, tmp_path / "third")]
    assert scenes[0].read_bytes() == scenes[1].read_bytes()
    assert one_machine(tmp_path / "third") == metrics and len(steps) == 20


# --- what comes back, and what goes there


def test_figures_are_whole_after_every_row_and_rows_are_shared(tmp_path: Path) -> None:
    path = tmp_path / "frames.json"
    ours = Figures(path, device="one")
    ours.add("student", ms=1.5)
    assert json.loads(path.read_text())["rows"] == {"student": {"ms": 1.5}}
    ours.add("teacher", ms=2.5)
    Figures(path, device="one").add("teacher", gsplat_ms=3.0)
    content = json.loads(path.read_text())
    assert content["rows"] == {"student": {"ms": 1.5}, "teacher": {"ms": 2.5, "gsplat_ms": 3.0}}
    assert content["device"] == "one"


def test_what_travels_is_weighed(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr(bring, "repository_bytes", lambda: 1 << 20)
    (tmp_path / "out").mkdir()
    (tmp_path / "out/parcel-0.bin").write_bytes(bytes(1 << 20))
    (tmp_path / "out/cells-0.tar").write_bytes(b"stays here")
    words = ["bring.py", "--data", str(capture.parent), "--captures", capture.name]
    words += ["--parcel", str(tmp_path / "out"), "--to", str(tmp_path / "to")]
    monkeypatch.setattr("sys.argv", [*words, "--most", "2.5"])
    bring.main()
    assert "together" in capsys.readouterr().out
    photos = {path.name for path in capture.rglob("*") if path.is_file()}
    there = {path.name for path in (tmp_path / "to").rglob("*") if path.is_file()}
    assert there == {*photos, "parcel-0.bin"}
    monkeypatch.setattr("sys.argv", [*words, "--most", "1.5"])
    with pytest.raises(SystemExit, match=r"more than 1\.5 MiB: bring it in several calls"):
        bring.main()
