"""LPIPS, a perceptual distance between two images. Lower is better.

Zhang et al. 2018, version 0.1, with the VGG-16 or AlexNet backbone. Two conventions are in use
whose values cannot be compared, so each has its own name:

    lpips_vgg, lpips_alex                    images in [0, 1] enter the network: a mistake, but
                                             the values that 3DGS and most papers report
    lpips_vgg_rescaled, lpips_alex_rescaled  images are scaled to [-1, 1], for which the networks
                                             were calibrated

The package contains no weights. A folder holds `lpips_vgg16.npz` and `lpips_alexnet.npz`, each
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
SIDE_MIN = 32  # px; below 31 px AlexNet's last layer is empty
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
    pool: int = 0  # size of the max-pooling of stride 2 before it
    tap: bool = False  # True if LPIPS compares its output


@dataclass(frozen=True)
class Backbone:
    """A network: its file of weights and its convolutions."""

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
    """LPIPS with one backbone, on the device of the images.

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
        """Return the distance of each of `images` from `target`.

        Values are in [0, 1]; sides have at least 32 px. All images share one batch, so the features
        of the target are computed once. `rescale` scales the images to [-1, 1] first; see the
        module for the two conventions.
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
        """Move the weights to `device`."""
        if self.weights[0].device != device:
            for tensors in (self.weights, self.biases, self.heads):
                tensors[:] = [tensor.to(device) for tensor in tensors]


def tap_distances(
    features: Float[Tensor, "images c h w"], head: Float[Tensor, "c"]
) -> Float[Tensor, "m"]:
    """Return the weighted squared distance of each image's unit features from the first image's.

    One image at a time, because the first layers' features take the most memory.
    """
    first = unit(features[0])
    return torch.stack([(unit(f) - first).square().mean((1, 2)) @ head for f in features[1:]])


def unit(features: Float[Tensor, "c h w"]) -> Float[Tensor, "c h w"]:
    """Normalise the feature vector of every pixel."""
    return features / (features.square().sum(0, keepdim=True).sqrt() + EPSILON)


class LpipsSuite:
    """The four LPIPS metrics, from a folder or http(s) address of weights."""

    def __init__(self, weights: Path | str) -> None:
        folder = fetch_weights(weights)
        self.nets: dict[Net, Lpips] = {net: Lpips(net, folder) for net in BACKBONES}

    def distances(
        self, target: Float[Tensor, "h w 3"], images: list[Float[Tensor, "h w 3"]]
    ) -> list[dict[str, float | None]]:
        """Return the distances of each image from `target` by name; None for sides under 32 px."""
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
    """Return the suite of `weights` or else of `MOBILEGS_LPIPS`, or None without either.

    `weights` is a folder or an http(s) address. Raises InputError if the weights are missing or
    damaged.
    """
    chosen = weights or os.environ.get(ENVIRONMENT)
    return LpipsSuite(chosen) if chosen else None


def expected_shapes(backbone: Backbone) -> dict[str, tuple[int, ...]]:
    """Return name and shape of every array in a file of weights."""
    shapes: dict[str, tuple[int, ...]] = {}
    for i, layer in enumerate(backbone.layers):
        out, into, side = layer.shape
        shapes[f"conv{i}.weight"] = (out, into, side, side)
        shapes[f"conv{i}.bias"] = (out,)
    taps = [layer for layer in backbone.layers if layer.tap]
    return shapes | {f"lin{i}": (layer.shape[0],) for i, layer in enumerate(taps)}


def read_arrays(path: Path, shapes: dict[str, tuple[int, ...]]) -> dict[str, Tensor]:
    """Return the arrays of an `.npz` as float32.

    Raises InputError unless the file has all arrays in `shapes`.
    """
    if not path.is_file():
        raise InputError(f"no LPIPS weights at {path}: give a folder with them by --lpips-weights")
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > BYTES_MAX:
                raise InputError(f"{path} is too large for a file of LPIPS weights")
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in shapes}
    except KeyError as error:
        raise InputError(f"{path} lacks an array of LPIPS weights: {error.args[0]}") from None
    except (zipfile.BadZipFile, ValueError, EOFError, OSError):
        raise InputError(f"{path} is damaged or not an .npz file of LPIPS weights") from None
    for name, shape in shapes.items():
        if arrays[name].shape != shape or arrays[name].dtype.kind != "f":
            raise InputError(f"{path}: '{name}' should be floats of shape {list(shape)}")
    return {name: torch.from_numpy(array.astype(np.float32)) for name, array in arrays.items()}


def fetch_weights(location: Path | str) -> Path:
    """Return the folder of weights at `location`; download an http(s) address once.

    Downloads are cached in `$XDG_CACHE_HOME/mobilegs` (or `~/.cache/mobilegs`), in a folder per
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
    """Return the bytes at `address`; raises InputError if they cannot be downloaded."""
    try:
        with urllib.request.urlopen(address, timeout=60) as answer:
            content = answer.read(BYTES_MAX + 1)
    except (OSError, ValueError) as error:
        raise InputError(
            f"cannot download LPIPS weights from {address} ({error}): "
            "download them yourself and give their folder by --lpips-weights"
        ) from None
    if len(content) > BYTES_MAX:
        raise InputError(f"{address} is too large for LPIPS weights")
    return content
