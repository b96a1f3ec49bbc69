"""What a run would be refused for in the end, said before minutes go into its capture."""

from mobilegs.evaluate.lpips import lpips_from
from mobilegs.live import refuse
from mobilegs.pipeline.train import TrainRun, resolved
from mobilegs.train.run_dir import RunFolder


def refuse_beforehand(run: TrainRun) -> None:
    """Raise InputError for options that cannot be, and for a folder that no such run can go to."""
    folder = RunFolder(run.output)
    if run.resume and folder.config.exists():
        refuse(run.live, run.live_at)
    else:
        folder.refuse()
        resolved(run, None)
    lpips_from(run.lpips_weights)
