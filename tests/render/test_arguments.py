"""Wrong arguments of the public functions of rendering and training: an error, never a crash."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import torch
from torch import Tensor

from mobilegs import Camera, look_at, photo_loss, render_sorted, render_sortfree
from mobilegs.errors import InputError
from mobilegs.render import measure_contributions, visible_rows

COUNT, SIDE = 5, 16
VIEW = look_at(torch.tensor([0.0, 0, -3]), torch.zeros(3), torch.tensor([0.0, -1, 0]))
K = torch.tensor([[16.0, 0, 8], [0, 16, 8], [0, 0, 1]])


def arguments() -> dict[str, Any]:
    """Right arguments of all functions, by name."""
    some = torch.Generator().manual_seed(0)

    def drawn(*shape: int) -> Tensor:
        return torch.rand(*shape, generator=some)

    return {
        "means": drawn(COUNT, 3) - 0.5, "quats": drawn(COUNT, 4), "scales": drawn(COUNT, 3) / 5,
        "opacities": drawn(COUNT), "lobes": drawn(COUNT, 4, 2), "sh": drawn(COUNT, 4, 3),
        "camera": Camera(VIEW, K, SIDE, SIDE), "background": torch.zeros(3), "depth": True,
        "screen_grads": torch.zeros(COUNT, 2), "image": drawn(SIDE, SIDE, 3),
        "photo": drawn(SIDE, SIDE, 3),
    }  # fmt: skip


SHAPES = ("means", "quats", "scales")
VIEWED = ("camera", "background", "depth", "screen_grads")
FUNCTIONS: dict[Callable[..., Any], tuple[str, ...]] = {
    render_sorted: (*SHAPES, "opacities", "sh", *VIEWED),
    render_sortfree: (*SHAPES, "lobes", "sh", *VIEWED),
    measure_contributions: (*SHAPES, "opacities", "camera"),
    visible_rows: (*SHAPES, "camera"),
    photo_loss: ("image", "photo"),
}
OPTIONAL = {"sh", "background", "screen_grads"}  # that may be None


def spoiled(value: Any) -> Iterator[Any]:
    """Yield what is wrong in the place of an argument, or unusual."""
    yield from (None, 7, "text", [], object())
    if isinstance(value, Camera):
        for change in ({"K": K[:2, :2]}, {"viewmat": VIEW[:2]}, {"K": K * torch.nan}):
            yield Camera(**{**vars(value), **change})
        for size in (0, -1, 40_000, 1.5):
            yield Camera(VIEW, K, size, SIDE)  # pyright: ignore[reportArgumentType]
        yield from ([value, None], [value, Camera(VIEW, K, 8, 8)])
    if not isinstance(value, Tensor):
        return
    for kind in (
        torch.float64,
        torch.float16,
        torch.int32,
        torch.int64,
        torch.bool,
        torch.complex64,
    ):
        yield value.to(kind)
    yield from (value[:0], value[:-1], value[None], value.flatten(), torch.tensor(1.0))
    yield value.repeat(2, *[1] * (value.ndim - 1))
    yield from (
        value.to_sparse(),
        value.to("meta"),
        value.numpy(),
        torch.full_like(value, torch.nan),
    )
    yield value[:1].expand_as(value)
    yield torch.stack([value, value], dim=-1)[..., 0]  # right, but with gaps


def try_all() -> int:
    """Call every function with each argument spoiled; return the number of refusals."""
    refused = 0
    for function, names in FUNCTIONS.items():
        for name in names:
            for wrong in spoiled(arguments()[name]):
                given = {key: value for key, value in arguments().items() if key in names}
                given[next(iter(names))].requires_grad_()
                given[name] = wrong
                try:
                    result = function(**given)
                    image = result[0] if isinstance(result, tuple) else result
                    if image.requires_grad:
                        image.sum().backward()
                except InputError:
                    refused += 1
                except (TypeError, ValueError, AttributeError, LookupError, RuntimeError):
                    assert name in ("camera", "image", "photo", "background"), (
                        function,
                        name,
                        wrong,
                    )
    return refused


def test_no_argument_ends_the_process() -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "tests.render.test_arguments"], capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr[-2000:]
    assert int(ended.stdout) > 250


if __name__ == "__main__":
    print(try_all())
