"""A capture, ready for training: posed photos, split in two, and the points that came with them."""

from collections.abc import Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from mobilegs.camera import NEAR, Camera
from mobilegs.data import images
from mobilegs.data.distortion import Distortion, undistort
from mobilegs.errors import InputError

TEST_EVERY = 8  # views 0, 8, 16, ... by sorted name are held back
Color = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Frame:
    """A posed photo that is not decoded yet.

    Attributes:
        name: file name relative to the folder of images, extension included.
        camera: at the size at which the image will be loaded, lens distortion removed.
        image_path: the photo; None where `pixels` hold the picture itself.
        mask_path: white where the photo may be used; None for everywhere.
        distortion: what to undo on load; None for pinhole pictures.
        alpha: what transparency means: `mask` leaves those pixels out of the loss, `over`
            composites the picture over `background`.
        background: colour under `over`, each channel in [0, 1].
        pixels: the picture in memory, `[h, w, 3]` uint8.
    """

    name: str
    camera: Camera
    image_path: Path | None = None
    mask_path: Path | None = None
    distortion: Distortion | None = None
    alpha: Literal["mask", "over"] = "mask"
    background: Color = (0.0, 0.0, 0.0)
    pixels: UInt8[Tensor, "h w 3"] | None = None


@dataclass(frozen=True, eq=False)
class View:
    """A posed photo, decoded: `image [h, w, 3]` sRGB in [0, 1]; `mask [h, w]`, 1 = in the loss.

    `mask` is None where every pixel counts.
    """

    name: str
    camera: Camera
    image: Float[Tensor, "h w 3"]
    mask: Float[Tensor, "h w"] | None = None

    def to(self, device: torch.device | str) -> "View":
        """The same view on `device`."""
        mask = None if self.mask is None else self.mask.to(device)
        return View(self.name, self.camera.to(device), self.image.to(device), mask)


@dataclass(frozen=True, eq=False)
class Dataset:
    """A capture.

    Attributes:
        name: of the capture's folder.
        train, test: posed photos for training, and those held back.
        points: sparse geometry that came with the poses, world units, `[m, 3]`. May be empty:
            training then starts from random points around `center`.
        colors: of the points, in [0, 1], `[m, 3]`.
        extent: 1.1 x the largest distance of a training camera from their mean (3DGS's scale
            of the scene; positive).
        center: the point nearest to the optical axes of all training cameras, `[3]`: what
            they look at, or among them where they look outwards or in parallel.
        background: colour behind everything, in [0, 1], `[3]`.
        near: near plane, `0.2 * min(1, extent)`; every camera carries it.
    """

    name: str
    train: list[Frame]
    test: list[Frame]
    points: Float[Tensor, "m 3"]
    colors: Float[Tensor, "m 3"]
    extent: float
    center: Float[Tensor, "3"]
    background: Float[Tensor, "3"]
    near: float


def assemble(
    name: str,
    train: Iterable[Frame],
    test: Iterable[Frame],
    *,
    points: Float[np.ndarray, "m 3"],
    colors: Float[np.ndarray, "m 3"],
    background: Color,
) -> Dataset:
    """Measure the scene, give every camera its near plane; points that are not finite are left out.

    Raises `InputError` if fewer than two views are left in all, or none to train on.
    """
    train, test = list(train), list(test)
    if len(train) + len(test) < 2:
        raise InputError(f"capture {name} has a single view; a scene needs at least two photos")
    if not train:
        raise InputError(f"capture {name} has no view to train on: all are held back for the test")
    _refuse_twins(train)
    _refuse_twins(test)
    kept = torch.from_numpy(np.concatenate([points, colors], axis=1)).float()
    kept = kept[kept.isfinite().all(1)]
    center, extent = measure([frame.camera for frame in train], kept[:, :3])
    near = NEAR * min(1.0, extent)
    train, test = (
        [replace(frame, camera=replace(frame.camera, near=near)) for frame in frames]
        for frames in (train, test)
    )
    return Dataset(
        name=name,
        train=train,
        test=test,
        points=kept[:, :3].contiguous(),
        colors=kept[:, 3:].clamp(0, 1).contiguous(),
        extent=extent,
        center=center,
        background=torch.tensor(background, dtype=torch.float32),
        near=near,
    )


def split_every_eighth(frames: Sequence[Frame]) -> tuple[list[Frame], list[Frame]]:
    """(train, test): of the frames sorted by name, those at 0, 8, 16, ... are the test."""
    _refuse_twins(frames)
    ordered = sorted(frames, key=lambda frame: frame.name)
    train = [frame for index, frame in enumerate(ordered) if index % TEST_EVERY]
    return train, ordered[::TEST_EVERY]


def _refuse_twins(frames: Sequence[Frame]) -> None:
    """Outputs carry the names of the photos, so a name may stand for one only."""
    seen: set[str] = set()
    for frame in frames:
        if frame.name in seen:
            raise InputError(f"the capture lists the photo {frame.name} more than once")
        seen.add(frame.name)


def measure(
    cameras: Sequence[Camera], points: Float[Tensor, "m 3"]
) -> tuple[Float[Tensor, "3"], float]:
    """What the cameras look at, and how far they are spread (see `Dataset`).

    Cameras that are all in one place have no spread: the median distance of the points from
    that place stands in for it, or 1 where there are no points.
    """
    eyes = torch.stack([camera.position for camera in cameras]).double()
    axes = torch.stack([camera.viewmat[2, :3] for camera in cameras]).double()
    mean = eyes.mean(0)
    extent = 1.1 * float((eyes - mean).norm(dim=1).max())
    if extent <= 1e-6 * float(mean.norm()) or extent == 0:
        distances = (points.double() - mean).norm(dim=1)
        extent = float(distances.median()) if len(points) else 1.0
    if not (0 < extent < float("inf")):
        raise InputError("the camera positions of this capture are not finite numbers")
    # least squares over the distances to the axes; the small pull to the mean decides where
    # parallel axes leave the depth open
    across = torch.eye(3, dtype=torch.float64) - axes[:, :, None] * axes[:, None, :]
    pull = 1e-3 * len(cameras) * torch.eye(3, dtype=torch.float64)
    moment = (across @ (eyes - mean)[:, :, None]).sum(0)[:, 0]
    return (mean + torch.linalg.solve(across.sum(0) + pull, moment)).float(), extent


class _Decoded(NamedTuple):
    """What the cache keeps: a third of the bytes of a float image."""

    image: UInt8[Tensor, "h w 3"]
    mask: Bool[Tensor, "h w"] | None

    @property
    def nbytes(self) -> int:
        return self.image.nbytes + (0 if self.mask is None else self.mask.nbytes)


def load_view(frame: Frame) -> View:
    """Decode, reduce, undistort and mask one photo; `InputError` if a file is damaged."""
    return _view(frame, _decode(frame))


class ViewLoader:
    """Views by index, decoded ahead of need by a few threads.

    Decoded photos stay in memory, 8 bits a channel, until `cache_bytes` are used; from then on
    others are decoded anew each time they are asked for. What `get` returns does not depend on
    the cache or on prefetching. Close it, or use it in a `with` block.
    """

    def __init__(
        self, frames: Sequence[Frame], *, cache_bytes: int = 2 << 30, threads: int = 2
    ) -> None:
        self._frames = list(frames)
        self._left = cache_bytes
        self._cache: dict[int, _Decoded] = {}
        self._pending: dict[int, Future[_Decoded]] = {}
        self._threads = threads
        self._pool: ThreadPoolExecutor | None = None

    def __len__(self) -> int:
        return len(self._frames)

    def get(self, index: int, device: torch.device | str = "cpu") -> View:
        """The view of frame `index`, on `device`; `InputError` if it cannot be decoded.

        There it becomes floats: what moves has 8 bits a channel.
        """
        frame = self._frames[index]
        decoded = self._cache.get(index)
        if decoded is None:
            future = self._pending.pop(index, None)
            decoded = _decode(frame) if future is None else future.result()
            if decoded.nbytes <= self._left:
                self._left -= decoded.nbytes
                self._cache[index] = decoded
        return _view(frame, decoded, device)

    def prefetch(self, indices: Iterable[int]) -> None:
        """Begin to decode frames that `get` will ask for soon.

        At most 4 a thread wait to be fetched, which bounds the memory outside the cache; what is
        beyond that is left for `get` to decode.
        """
        for index in indices:
            if len(self._pending) >= 4 * self._threads:
                return
            if index in self._cache or index in self._pending:
                continue
            if self._pool is None:
                self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="views")
            self._pending[index] = self._pool.submit(_decode, self._frames[index])

    def close(self) -> None:
        """Stop the threads; what they had begun is dropped. `get` goes on working."""
        self._pending.clear()
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def __enter__(self) -> "ViewLoader":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _decode(frame: Frame) -> _Decoded:
    """The frame's photo and mask, at the size of its camera, 8 bits a channel."""
    width, height = frame.camera.width, frame.camera.height
    if frame.pixels is not None:
        return _Decoded(frame.pixels, None)
    if frame.image_path is None:
        raise InputError(f"frame {frame.name} has neither a file nor pixels")
    over = frame.background if frame.alpha == "over" else None
    pixels, usable = images.read_pixels(frame.image_path, width, height, over=over)
    image = torch.from_numpy(np.array(pixels))
    mask = None if usable is None else torch.from_numpy(usable)
    if frame.mask_path is not None:
        white = torch.from_numpy(images.read_mask(frame.mask_path, width, height))
        mask = white if mask is None else mask & white
    if frame.distortion:
        image, mask = _undistorted(image, mask, frame.camera.K, frame.distortion)
    return _Decoded(image, None if mask is None or bool(mask.all()) else mask)


def _undistorted(
    image: UInt8[Tensor, "h w 3"],
    mask: Bool[Tensor, "h w"] | None,
    K: Float[Tensor, "3 3"],
    distortion: Distortion,
) -> tuple[UInt8[Tensor, "h w 3"], Bool[Tensor, "h w"]]:
    """Photo and mask as a pinhole camera sees them; a pixel counts if all it reads counts."""
    channels = image.float()
    if mask is not None:
        channels = torch.cat([channels, mask[:, :, None].float()], dim=2)
    channels, known = undistort(channels, K=K, distortion=distortion)
    if mask is not None:
        known = known & (channels[:, :, 3] > 0.999)
    return channels[:, :, :3].round().to(torch.uint8), known


def _view(frame: Frame, decoded: _Decoded, device: torch.device | str = "cpu") -> View:
    mask = None if decoded.mask is None else decoded.mask.to(device).float()
    image = decoded.image.to(device).float() / 255
    return View(frame.name, frame.camera.to(device), image, mask)


def posed_frame(
    name: str,
    camera: Camera,
    *,
    image_path: Path,
    downscale: int | None,
    mask_path: Path | None = None,
    distortion: Distortion | None = None,
    alpha: Literal["mask", "over"] = "mask",
    background: Color = (0.0, 0.0, 0.0),
) -> Frame:
    """A frame at the photo's size divided by `downscale` (None: at most 1600 pixels wide).

    `camera` may be recorded at another resolution than the file has, not with another shape.
    Only headers are read here; raises `InputError` if one cannot be, or if shapes differ.
    """
    size = images.image_size(image_path)
    recorded = (camera.width, camera.height)
    if not images.same_shape(size, recorded):
        raise InputError(
            f"{image_path} is {size[0]}x{size[1]} but its camera was made for "
            f"{recorded[0]}x{recorded[1]}; use the photos the poses were computed from, "
            "neither cropped nor rotated since"
        )
    if mask_path is not None and not images.same_shape(images.image_size(mask_path), size):
        raise InputError(f"mask {mask_path} has another shape than its photo {image_path}")
    if not bool(camera.viewmat.isfinite().all() and camera.K.isfinite().all()):
        raise InputError(f"the camera of {name} has numbers that are not finite")
    return Frame(
        name=name,
        camera=camera.resized(*images.reduced_size(*size, downscale)),
        image_path=image_path,
        mask_path=mask_path,
        distortion=distortion or None,
        alpha=alpha,
        background=background,
    )
