"""LPIPS: how different two pictures look to a network. Lower is better.

Zhang et al. 2018, version 0.1, with the VGG-16 or AlexNet backbone. Two conventions are in use
and must never be mixed, so every figure here carries its own name:

    lpips_vgg, lpips_alex                    pictures in [0, 1] are fed as they are: wrong, but
                                             what 3DGS's and most splatting papers report
    lpips_vgg_rescaled, lpips_alex_rescaled  pictures are brought to [-1, 1]: what the networks
                                             were calibrated for

No weights come with the package. A folder holds `lpips_vgg16.npz` and `lpips_alexnet.npz`, each
with arrays `conv{i}.weight [out, in, kh, kw]`, `conv{i}.bias [out]`, `lin{i} [channels]`.
"""

import hashlib
import os
import urllib.request
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import conv2d, max_pool2d

from mobilegs.atomic import atomic_write
from mobilegs.errors import InputError

Net = Literal["vgg", "alex"]
LPIPS_NAMES = ("lpips_vgg", "lpips_vgg_rescaled", "lpips_alex", "lpips_alex_rescaled")
ENVIRONMENT = "MOBILEGS_LPIPS"
SIDE_MIN = 32  # px; AlexNet's last layer has no pixel left below 31
BYTES_MAX = 200 << 20  # VGG-16's weights take 59 MB as float32
SHIFT = (-0.030, -0.088, -0.188)
SCALE = (0.458, 0.448, 0.450)
EPSILON = 1e-10


@dataclass(frozen=True)
class Conv:
    """One convolution of a backbone, always followed by a ReLU."""

    shape: tuple[int, int, int]  # out, in, kernel size
    stride: int = 1
    padding: int = 1
    pool: int = 0  # side of the max-pooling of stride 2 before it
    tap: bool = False  # whether LPIPS compares what leaves it


@dataclass(frozen=True)
class Backbone:
    file: str
    layers: tuple[Conv, ...]


BACKBONES: dict[Net, Backbone] = {
    "vgg": Backbone(
        "lpips_vgg16.npz",
        (
            Conv((64, 3, 3)),
            Conv((64, 64, 3), tap=True),
            Conv((128, 64, 3), pool=2),
            Conv((128, 128, 3), tap=True),
            Conv((256, 128, 3), pool=2),
            Conv((256, 256, 3)),
            Conv((256, 256, 3), tap=True),
            Conv((512, 256, 3), pool=2),
            Conv((512, 512, 3)),
            Conv((512, 512, 3), tap=True),
            Conv((512, 512, 3), pool=2),
            Conv((512, 512, 3)),
            Conv((512, 512, 3), tap=True),
        ),
    ),
    "alex": Backbone(
        "lpips_alexnet.npz",
        (
            Conv((64, 3, 11), stride=4, padding=2, tap=True),
            Conv((192, 64, 5), padding=2, pool=3, tap=True),
            Conv((384, 192, 3), pool=3, tap=True),
            Conv((256, 384, 3), tap=True),
            Conv((256, 256, 3), tap=True),
        ),
    ),
}


class Lpips:
    """The metric with one backbone; it computes on the device of the pictures.

    Raises InputError if `weights_dir` has no usable weights for `net`.
    """

    def __init__(self, net: Net, weights_dir: Path | str) -> None:
        backbone = BACKBONES[net]
        arrays = read_arrays(Path(weights_dir) / backbone.file, expected_shapes(backbone))
        self.layers = backbone.layers
        count = len(self.layers)
        self.weights = [
            # channels last: 1.4x faster on a CPU
            arrays[f"conv{i}.weight"].contiguous(memory_format=torch.channels_last)
            for i in range(count)
        ]
        self.biases = [arrays[f"conv{i}.bias"] for i in range(count)]
        self.heads = [arrays[f"lin{i}"] for i in range(sum(layer.tap for layer in self.layers))]

    @torch.inference_mode()
    def distances(
        self,
        target: Float[Tensor, "h w 3"],
        images: list[Float[Tensor, "h w 3"]],
        *,
        rescale: bool,
    ) -> list[float]:
        """Distance of each of `images` from `target`, all in [0, 1], sides of 32 px or more.

        All go through the network together, so the target's features are computed once.
        `rescale` brings the pictures to [-1, 1] first; see the module for the two conventions.
        """
        self.move(target.device)
        batch = torch.stack([target, *images]).permute(0, 3, 1, 2)  # [1 + m, 3, h, w]
        if rescale:
            batch = 2 * batch - 1
        shift = torch.tensor(SHIFT, device=target.device).view(3, 1, 1)
        scale = torch.tensor(SCALE, device=target.device).view(3, 1, 1)
        x = ((batch - shift) / scale).contiguous(memory_format=torch.channels_last)
        heads = iter(self.heads)
        totals = torch.zeros(len(images), device=target.device)
        for layer, weight, bias in zip(self.layers, self.weights, self.biases, strict=True):
            if layer.pool:
                x = max_pool2d(x, layer.pool, stride=2)
            x = conv2d(x, weight, bias, layer.stride, layer.padding).relu_()
            if layer.tap:
                totals += tap_distances(x, next(heads))
        return totals.tolist()

    def move(self, device: torch.device) -> None:
        """Keep the weights on `device` from now on."""
        if self.weights[0].device != device:
            for tensors in (self.weights, self.biases, self.heads):
                tensors[:] = [tensor.to(device) for tensor in tensors]


def tap_distances(
    features: Float[Tensor, "pictures c h w"], head: Float[Tensor, "c"]
) -> Float[Tensor, "m"]:
    """Weighted squared distance of unit feature vectors from the first picture's, of the others.

    One picture at a time: the first layers' features are the largest thing in memory.
    """
    first = unit(features[0])
    return torch.stack([(unit(f) - first).square().mean((1, 2)) @ head for f in features[1:]])


def unit(features: Float[Tensor, "c h w"]) -> Float[Tensor, "c h w"]:
    """Every pixel's feature vector at length 1."""
    return features / (features.square().sum(0, keepdim=True).sqrt() + EPSILON)


class LpipsSuite:
    """All four figures, from one folder (or address) of weights."""

    def __init__(self, weights: Path | str) -> None:
        folder = fetch_weights(weights)
        self.nets: dict[Net, Lpips] = {net: Lpips(net, folder) for net in BACKBONES}

    def distances(
        self, target: Float[Tensor, "h w 3"], images: list[Float[Tensor, "h w 3"]]
    ) -> list[dict[str, float | None]]:
        """For each picture its distances from `target` by name; None where a side is too short."""
        if min(target.shape[:2]) < SIDE_MIN:
            return [dict.fromkeys(LPIPS_NAMES) for _ in images]
        results: list[dict[str, float | None]] = [{} for _ in images]
        for net, metric in self.nets.items():
            for rescale in (False, True):
                name = f"lpips_{net}_rescaled" if rescale else f"lpips_{net}"
                values = metric.distances(target, images, rescale=rescale)
                for result, value in zip(results, values, strict=True):
                    result[name] = value
        return results


def lpips_from(weights: Path | str | None) -> LpipsSuite | None:
    """The suite from a folder or address, from `MOBILEGS_LPIPS` if None is given, or None."""
    chosen = weights or os.environ.get(ENVIRONMENT)
    return LpipsSuite(chosen) if chosen else None


def expected_shapes(backbone: Backbone) -> dict[str, tuple[int, ...]]:
    """Name and shape of every array that a file of weights must hold."""
    shapes: dict[str, tuple[int, ...]] = {}
    for i, layer in enumerate(backbone.layers):
        out, into, side = layer.shape
        shapes[f"conv{i}.weight"] = (out, into, side, side)
        shapes[f"conv{i}.bias"] = (out,)
    taps = [layer for layer in backbone.layers if layer.tap]
    return shapes | {f"lin{i}": (layer.shape[0],) for i, layer in enumerate(taps)}


def read_arrays(path: Path, shapes: dict[str, tuple[int, ...]]) -> dict[str, Tensor]:
    """The arrays of an `.npz` as float32, after checking that they are those of the network."""
    if not path.is_file():
        raise InputError(f"no LPIPS weights at {path}: point --lpips-weights to a folder with them")
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > BYTES_MAX:
                raise InputError(f"{path} is far larger than LPIPS weights are")
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in shapes}
    except KeyError as error:
        raise InputError(f"{path} lacks an array of LPIPS weights: {error.args[0]}") from None
    except (zipfile.BadZipFile, ValueError, EOFError, OSError):
        raise InputError(f"{path} is damaged or no .npz file of LPIPS weights") from None
    for name, shape in shapes.items():
        if arrays[name].shape != shape or arrays[name].dtype.kind != "f":
            raise InputError(f"{path}: '{name}' should be floats of shape {list(shape)}")
    return {name: torch.from_numpy(array.astype(np.float32)) for name, array in arrays.items()}


def fetch_weights(location: Path | str) -> Path:
    """The folder of weights at `location`; an http(s) address is downloaded once and cached.

    The cache lies in `$XDG_CACHE_HOME/mobilegs` (or `~/.cache/mobilegs`), one folder for each
    address. Raises InputError if the download fails.
    """
    address = str(location).rstrip("/")
    if not address.startswith(("http://", "https://")):
        return Path(location)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = cache / "mobilegs" / f"lpips-{hashlib.sha256(address.encode()).hexdigest()[:12]}"
    for backbone in BACKBONES.values():
        if not (folder / backbone.file).exists():
            atomic_write(folder / backbone.file, download(f"{address}/{backbone.file}"))
    return folder


def download(address: str) -> bytes:
    """The bytes at `address`, or an InputError that says why they could not be had."""
    try:
        with urllib.request.urlopen(address, timeout=60) as answer:
            content = answer.read(BYTES_MAX + 1)
    except (OSError, ValueError) as error:
        raise InputError(
            f"cannot download LPIPS weights from {address} ({error}): "
            "fetch them by hand and give the folder with --lpips-weights"
        ) from None
    if len(content) > BYTES_MAX:
        raise InputError(f"{address} is far larger than LPIPS weights are")
    return content
