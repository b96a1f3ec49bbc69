"""Train a capture twice, with two recipes, and compare quality and size.

    python examples/train.py my_capture runs/two --downscale 2

Both students learn from the same teacher: the first run trains it, the second one reads its file.
Every field of docs/reference/settings.md can be changed like this.
"""

import argparse
from pathlib import Path

from mobilegs import TrainRun, short_recipe, train_capture, with_settings, with_steps

VARIANTS = {
    "default": [],
    "codebooks": [
        "student.quantization.method=nvq"
    ],  # vector quantisation, as in the paper, instead of uniform steps
}


def main() -> None:
    options = argparse.ArgumentParser(description="Train a capture with two recipes.")
    options.add_argument("capture", type=Path)
    options.add_argument("runs", type=Path)
    options.add_argument("--downscale", type=int)
    options.add_argument("--steps", type=int, help="training steps of teacher and student together")
    given = options.parse_args()

    teacher = None
    for name, settings in VARIANTS.items():
        recipe = with_settings(short_recipe(), settings)
        if given.steps:
            recipe = with_steps(recipe, given.steps)
        run = TrainRun(
            given.capture,
            given.runs / name,
            downscale=given.downscale,
            teacher=teacher,
            resume=True,  # the same command continues an interrupted run
        )
        student = train_capture(run, recipe=recipe)["student"]
        teacher = given.runs / "default" / "teacher.ply"
        print(f"{name:9} {student['psnr']:.2f} dB  {student['file_bytes']:,} bytes")


if __name__ == "__main__":
    main()
