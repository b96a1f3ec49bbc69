"""The profile of training steps, and how many operations a step may have."""

import pytest

import bench.steps
from bench.record import Figures
from bench.steps import PARTS, PERIOD, WARM, begin, count_steps, measure, reference_only
from mobilegs.data.dataset import Dataset, ViewLoader
from mobilegs.render.scene import Scene
from mobilegs.train import optim
from mobilegs.train.distributed import Team
from mobilegs.train.loop import next_views
from mobilegs.train.recipes import short_recipe
from mobilegs.train.student import trainer
from tests.support.cuda_on_host import HostKernels
from tests.support.tiny import CPU, blobs

# operations of torch, calls of the library, and values that the host reads, in a step on a CPU
LIMITS = {
    "teacher": (9, 10, 0),
    "explicit": (28, 9, 0.25),
    "latents": (28, 9, 0.25),
    "rate": (11, 10, 0.25),
    "quantized": (17, 10, 1.5),
}
# on a GPU: kernels started, operations of torch (3 of them on the host), and values that the host
# reads, which come from its own random numbers; a GPU's tile lists take one pass of sorting more
# from 64 tiles on
GPU_LIMITS = {
    "teacher": (22, 8, 0),
    "explicit": (34, 7, 0.25),
    "latents": (34, 7, 0.25),
    "rate": (30, 6, 0.25),
    "quantized": (31, 6.5, 0.25),
}


@pytest.fixture(scope="module")
def rows(dataset: Dataset) -> dict[str, dict]:
    figures = Figures(None)
    teacher = Scene(blobs(), near=0.2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench.steps, "SETTLE_SECONDS", 0)
        patch.setattr(bench.steps, "ROUNDS", 1)
        patch.setattr(bench.steps, "BESIDE_SECONDS", 0.2)
        measure(dataset, short_recipe(), teacher, list(PARTS), 4, [1], figures)
    return figures.rows


@pytest.mark.parametrize("part", PARTS)
def test_a_step_has_no_more_operations_than_it_had(part: str, rows: dict[str, dict]) -> None:
    found, limits = rows[f"{part} 24x24"], LIMITS[part]
    counted = found["operations"], found["native"], found["host_reads"]
    assert all(0 <= count <= limit for count, limit in zip(counted, limits, strict=True)), counted
    assert counted[0] > 0 and found["ms"] > 0 and found["gaussians"] == 50
    assert found["beside_1"] > 0
    assert ("reference_ms" in found) == (part != "teacher")


def test_the_reference_is_taken_only_inside(dataset: Dataset) -> None:
    before = trainer.runs_program
    with reference_only():
        assert trainer.runs_program is not before
    assert trainer.runs_program is before


@pytest.mark.parametrize("part", PARTS)
def test_a_step_starts_no_more_kernels_than_it_did(
    part: str, dataset: Dataset, on_host: HostKernels, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(optim, "_is_native", lambda tensor: False)
    stage, team = begin(part, short_recipe(), dataset, Scene(blobs(), near=0.2)), Team(CPU)
    with ViewLoader(dataset.train) as loader:

        def advance() -> object:
            return stage.advance(next_views(stage, loader, team, 0))

        for _ in range(WARM):
            advance()
        on_host.launched.clear()
        counted = count_steps(advance)
    found = len(on_host.launched) / PERIOD, counted["operations"], counted["host_reads"]
    limits = GPU_LIMITS[part]
    assert all(0 <= count <= limit for count, limit in zip(found, limits, strict=True)), found
    assert found[0] > 15
