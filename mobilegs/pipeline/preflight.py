"""Validation of options before the expensive work that precedes a training."""

from mobilegs.evaluate.lpips import lpips_from
from mobilegs.live import validate_live_options
from mobilegs.pipeline.train import TrainRun, budget_of, repeat_run, resolve_recipe
from mobilegs.train.run_dir import RunDir


def validate_run(run: TrainRun) -> None:
    """Raise InputError for invalid options, or an output folder that the run cannot use."""
    run_dir = RunDir(run.output)
    if run.resume and run_dir.config.exists():
        validate_live_options(run.live, run.live_at)
    else:
        run_dir.validate_new()
        budget_of(run)
        resolve_recipe(run, None if run.recipe is None else repeat_run(run).recipe)
    lpips_from(run.lpips_weights)
