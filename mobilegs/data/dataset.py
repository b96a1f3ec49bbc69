"""Datasets of posed photos, and a loader that decodes, caches and prefetches them."""

import logging
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Literal, NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor
from torch.nn.functional import avg_pool2d, max_pool2d

from mobilegs.camera import NEAR, Camera
from mobilegs.data import images, masks
from mobilegs.data.distortion import Distortion, LensPhoto, undistort
from mobilegs.data.pinhole_views import fields_of_view, pinhole_views
from mobilegs.device import free_bytes
from mobilegs.errors import InputError

CACHE_BYTES = 2 << 30  # of decoded photos that a loader keeps
THREADS = 2  # of a loader
LITTLE = 0.1  # share of photos that masks leave, below which a warning says so
NAMES_MAX = 5  # photos that a warning names
TEST_EVERY = 8  # views 0, 8, 16, ... in order of their names are held back
RECENTRED_FROM = 1000.0  # distance of the cameras from the origin, in their spreads
# Distance of a point from the cameras, in those of half of the points, beyond which it is dropped.
# In real captures the farthest is at 54; ten at 200 cost a teacher of 2,000 points 0.6 dB.
FAR_POINTS = 100.0
Color = tuple[float, float, float]
Offset = tuple[float, float, float]
log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Frame:
    """A posed photo that is not decoded yet.

    Attributes:
        name: file name relative to the folder of images, extension included. Views of a panorama
            have the name of their face at its end.
        camera: pinhole camera at the size at which the photo will be loaded.
        image_path: file of the photo; None if `pixels` hold it.
        mask_path: file of a mask, as `masks.used_pixels` reads it; None uses all of the photo.
        photo: the photo through its lens, from which the view is resampled on load; None for
            pinhole photos.
        group: frames of a group are held back together: views of a panorama, and photos that a
            rig took at one moment. Empty for a frame by itself.
        alpha: meaning of transparency: `mask` leaves those pixels out of the loss, `over`
            composites the photo over `background`.
        background: RGB in [0, 1], used by `over`.
        pixels: the photo in memory, `[h, w, 3]` uint8.
        exposure: `images.exposure_of` the photo that was taken; None if that is not known.
        colors: name of the colours from which the photo is converted; empty for sRGB.
    """

    name: str
    camera: Camera
    image_path: Path | None = None
    mask_path: Path | None = None
    photo: LensPhoto | None = None
    group: str = ""
    alpha: Literal["mask", "over"] = "mask"
    background: Color = (0.0, 0.0, 0.0)
    pixels: UInt8[Tensor, "h w 3"] | None = None
    exposure: float | None = None
    colors: str = ""


@dataclass(frozen=True, eq=False)
class View:
    """A posed photo, decoded.

    Attributes:
        name, camera: those of the frame.
        image: sRGB in [0, 1], `[h, w, 3]`.
        mask: 1 for pixels in the loss, 0 for others, `[h, w]`; None if all are in the loss.
    """

    name: str
    camera: Camera
    image: Float[Tensor, "h w 3"]
    mask: Float[Tensor, "h w"] | None = None

    def to(self, device: torch.device | str) -> "View":
        mask = None if self.mask is None else self.mask.to(device)
        return View(self.name, self.camera.to(device), self.image.to(device), mask)

    def reduced(self, n: int, camera: Camera | None = None) -> "View":
        """Return the view with the mean of each n x n pixels in place of them.

        `camera` is the reduced camera, if it is known.

        Rows and columns that fill no n x n pixels are left out, at the bottom and on the right. A
        pixel is in the loss if all its n x n pixels are.
        """
        if n == 1:
            return self if camera is None else replace(self, camera=camera)
        mask = (
            None if self.mask is None else -_pooled(-self.mask[:, :, None], n, max_pool2d)[..., 0]
        )
        image = _pooled(self.image, n, avg_pool2d)
        return View(self.name, camera or self.camera.reduced(n), image, mask)


def _pooled(
    image: Float[Tensor, "h w c"], n: int, pool: Callable[[Tensor, int], Tensor]
) -> Float[Tensor, "..."]:
    return pool(image.permute(2, 0, 1)[None], n)[0].permute(1, 2, 0).contiguous()


@dataclass(frozen=True, eq=False)
class Dataset:
    """A capture that is ready for training.

    Attributes:
        name: of the capture's folder.
        train, test: posed photos for training, and held-back ones.
        points: sparse points of the capture, world units, `[m, 3]`. May be empty: training then
            starts from random points around `center`.
        colors: of the points, in [0, 1], `[m, 3]`.
        extent: 1.1 times the largest distance of a training camera from their mean, as in 3DGS;
            positive, world units.
        center: the point nearest to the optical axes of all training cameras, `[3]`, world
            units. Cameras that look outwards or in parallel have it among them.
        background: RGB in [0, 1], `[3]`.
        near: near plane of every camera, world units: `0.2 * min(1, extent)`.
        offset: of a georeferenced capture, in its world units: what `recentred` subtracted from
            all positions.
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
    offset: Offset = (0.0, 0.0, 0.0)

    def with_near(self, near: float) -> "Dataset":
        """Return the dataset with another near plane of every camera."""
        train, test = (
            [replace(frame, camera=replace(frame.camera, near=near)) for frame in frames]
            for frames in (self.train, self.test)
        )
        return replace(self, train=train, test=test, near=near)


def assemble(
    name: str,
    train: Iterable[Frame],
    test: Iterable[Frame],
    *,
    points: Float[np.ndarray, "m 3"],
    colors: Float[np.ndarray, "m 3"],
    background: Color,
    offset: Offset = (0.0, 0.0, 0.0),
) -> Dataset:
    """Build a dataset: compute extent, centre and near plane.

    Points that are not finite are dropped, and those far behind all others, which would start as
    Gaussians that cover every photo.

    Raises `InputError` if there are fewer than two views, none for training, or two of one name.
    """
    train, test = _without_masked([*train], [*test])
    if len(train) + len(test) < 2:
        raise InputError(f"capture {name} has fewer than two views; give at least two photos")
    if not train:
        raise InputError(f"capture {name} has no training view: all views are held back")
    _validate_unique_names(train)
    _validate_unique_names(test)
    _report_views([*train, *test])
    kept = torch.from_numpy(np.concatenate([points, colors], axis=1)).float()
    kept = kept[kept.isfinite().all(1)]
    cameras = [frame.camera for frame in train]
    center, extent = center_and_extent(cameras, kept[:, :3])
    kept = _without_far_points(kept, cameras)
    dataset = Dataset(
        name=name,
        train=train,
        test=test,
        points=kept[:, :3].contiguous(),
        colors=kept[:, 3:].clamp(0, 1).contiguous(),
        extent=extent,
        center=center,
        background=torch.tensor(background, dtype=torch.float32),
        near=NEAR,
        offset=offset,
    )
    return dataset.with_near(NEAR * min(1.0, extent))


def _without_far_points(
    points: Float[Tensor, "n 6"], cameras: Sequence[Camera]
) -> Float[Tensor, "m 6"]:
    """Return points with colours without those beyond `FAR_POINTS`, and say how many those are."""
    if not len(points):
        return points
    middle = torch.stack([camera.position for camera in cameras]).double().mean(0)
    distances = (points[:, :3].double() - middle).norm(dim=1)
    near = distances <= FAR_POINTS * distances.median()
    if not near.all():
        log.warning(
            "%d of %d sparse points are left out: they are more than %.0f times as far away as "
            "half of the points",
            int((~near).sum()),
            len(points),
            FAR_POINTS,
        )
    return points[near]


@np.errstate(over="ignore", invalid="ignore")  # cameras that are not finite are refused later
def recentred(
    viewmats: Sequence[Float[np.ndarray, "4 4"]], points: Float[np.ndarray, "m 3"]
) -> tuple[list[Float[np.ndarray, "4 4"]], Float[np.ndarray, "m 3"], Offset]:
    """Return poses and points with an offset subtracted from all positions, and the offset.

    Cameras that are much farther from the origin than from each other, as in UTM or ECEF
    coordinates, lose their digits in float32. Then the offset is their mean in whole units, and
    else 0. All inputs and outputs are float64.
    """
    eyes = np.array([-v[:3, :3].T @ v[:3, 3] for v in viewmats]).reshape(-1, 3)
    middle = np.median(eyes, axis=0) if len(eyes) else np.zeros(3)
    near = np.abs(points - middle)[np.isfinite(points).all(1)]
    spread = max(np.abs(eyes - middle).max(initial=0.0), float(np.median(near)) if near.size else 0)
    if not np.isfinite(eyes).all() or not 0 < RECENTRED_FROM * spread < np.abs(middle).max():
        return list(viewmats), points, (0.0, 0.0, 0.0)
    offset = np.round(middle)
    moved = [v.copy() for v in viewmats]
    for viewmat in moved:
        viewmat[:3, 3] += viewmat[:3, :3] @ offset
    x, y, z = (float(part) for part in offset)
    log.warning("cameras lie around (%.0f, %.0f, %.0f): positions count from there", x, y, z)
    return moved, points - offset, (x, y, z)


def split_every_eighth(frames: Sequence[Frame]) -> tuple[list[Frame], list[Frame]]:
    """Split frames into (train, test): in order of names, frames 0, 8, 16, ... are the test.

    A group of frames counts as one, at its first name.
    """
    _validate_unique_names(frames)
    ordered = sorted(frames, key=lambda frame: frame.name)
    groups = list(dict.fromkeys(frame.group or frame.name for frame in ordered))
    held = set(groups[::TEST_EVERY])
    parts: tuple[list[Frame], list[Frame]] = [], []
    for frame in ordered:
        parts[(frame.group or frame.name) in held].append(frame)
    return parts


def _without_masked(*lists: list[Frame]) -> list[list[Frame]]:
    """Return the frames without those of photos that are masked nearly whole; say which.

    Raises `InputError` if those are more than half of the photos.
    """
    frames = [frame for each in lists for frame in each if frame.image_path is not None]
    photos = {frame.image_path: frame for frame in frames}
    with ThreadPoolExecutor(THREADS) as pool:
        shares = dict(zip(photos, pool.map(_used_share, photos.values()), strict=True))
    gone = [path for path, share in shares.items() if share < masks.SHARE_MIN]
    if 2 * len(gone) > len(photos):
        raise InputError(
            f"masks leave less than 1 % of {len(gone)} of {len(photos)} photos, such as "
            f"{gone[0]}: {masks.RULE}"
        )
    if gone:
        names = ", ".join(path.name for path in gone[:NAMES_MAX] if path)
        log.warning("%d photos are left out, masked nearly whole: %s", len(gone), names)
    partly = [share for share in shares.values() if masks.SHARE_MIN <= share < 1]
    if partly and np.mean(partly) < LITTLE:
        log.warning("masks leave %.0f %% of their photos: %s", 100 * np.mean(partly), masks.RULE)
    return [[frame for frame in each if frame.image_path not in gone] for each in lists]


def _used_share(frame: Frame) -> float:
    """Return the share of the pixels of a photo that its mask and its transparency leave."""
    at, path, used = frame.photo or frame.camera, frame.image_path, None
    if path is not None and frame.alpha == "mask" and images.has_alpha(path):
        used = images.read_pixels(path, at.width, at.height, over=None)[1]
    if frame.mask_path is not None:
        mask = masks.read_mask(frame.mask_path, at.width, at.height)
        used = mask if used is None else mask & used
    return 1.0 if used is None else float(used.mean())


def _report_views(frames: Sequence[Frame]) -> None:
    """Say which photos are converted to sRGB, and which views stand for fisheyes and panoramas."""
    colors = {frame.image_path: frame.colors for frame in frames if frame.colors}
    for name, number in Counter(colors.values()).items():
        log.warning("converted to sRGB: %d photos in %s", number, name)
    fisheye, panoramas = [], set()
    for frame in frames:
        projection = "perspective" if frame.photo is None else frame.photo.distortion.projection
        if projection == "equirectangular":
            panoramas.add(frame.image_path)
        elif projection != "perspective":
            fisheye.append(fields_of_view(frame.camera))
    if fisheye:
        across, down = (max(angles) for angles in zip(*fisheye, strict=True))
        log.warning(
            "%d fisheye photos become pinhole views of up to %.0f x %.0f degrees: what the photos "
            "show beyond is not used",
            len(fisheye),
            across,
            down,
        )
    if panoramas:
        log.warning("%d panoramas become six pinhole views each, a cube's faces", len(panoramas))


def _validate_unique_names(frames: Sequence[Frame]) -> None:
    """Raise InputError if two frames share a name: outputs are named after photos."""
    seen: set[str] = set()
    for frame in frames:
        if frame.name in seen:
            raise InputError(f"the capture lists the photo {frame.name} more than once")
        seen.add(frame.name)


def center_and_extent(
    cameras: Sequence[Camera], points: Float[Tensor, "m 3"]
) -> tuple[Float[Tensor, "3"], float]:
    """Return (center, extent), as `Dataset` defines them.

    Cameras that are all in one place have no extent: it becomes the median distance of the points
    from that place, or 1 without points. Raises `InputError` if it is not finite.
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
    # least squares over the distances to the axes; a small pull to the mean fixes the depth if
    # all axes are parallel
    across = torch.eye(3, dtype=torch.float64) - axes[:, :, None] * axes[:, None, :]
    pull = 1e-3 * len(cameras) * torch.eye(3, dtype=torch.float64)
    moment = (across @ (eyes - mean)[:, :, None]).sum(0)[:, 0]
    return (mean + torch.linalg.solve(across.sum(0) + pull, moment)).float(), extent


class _Decoded(NamedTuple):
    """A cached photo: 8 bits per channel, a quarter of a float32 image."""

    image: UInt8[Tensor, "h w 3"]
    mask: Bool[Tensor, "h w"] | None

    @property
    def nbytes(self) -> int:
        return self.image.nbytes + (0 if self.mask is None else self.mask.nbytes)

    def pinned(self) -> "_Decoded":
        """Return it in memory from which a GPU copies while the host goes on."""
        return _Decoded(*(None if t is None else t.pin_memory() for t in self))  # pyright: ignore

    def to(self, device: torch.device) -> "_Decoded":
        """Move it; a copy from pinned memory to a GPU does not make the host wait."""
        on = {"device": device, "non_blocking": device.type == "cuda"}
        return _Decoded(*(None if t is None else t.to(**on) for t in self))  # pyright: ignore


def load_view(frame: Frame) -> View:
    """Decode, downscale, undistort and mask one photo. Raises `InputError` if a file is damaged."""
    return _view(frame, _decode(frame), frame.camera)


class ViewLoader:
    """A loader of views by index that decodes photos ahead in background threads.

    Decoded photos stay in memory, 8 bits per channel, until `cache_bytes` are used; others are
    decoded on every request. Those of a GPU stay there instead, while they take at most a quarter
    of its free memory; others go there from pinned memory. The result of `get` does not depend on
    caches or on prefetching. Close the loader, or use it in a `with` block.
    """

    def __init__(self, frames: Sequence[Frame], *, cache_bytes: int = CACHE_BYTES) -> None:
        self._frames = list(frames)
        self._left = cache_bytes
        self._cache: dict[int, _Decoded] = {}
        self._on_gpu: dict[int, tuple[_Decoded, Camera]] = {}
        self._room: int | None = None  # bytes left on the GPU
        self._pending: dict[int, Future[_Decoded]] = {}
        self._pool: ThreadPoolExecutor | None = None

    def __len__(self) -> int:
        return len(self._frames)

    def get(self, index: int, device: torch.device | str = "cpu") -> View:
        """Return the view of frame `index` on `device`. Raises `InputError` if it is damaged.

        The photo moves to the device with 8 bits per channel and becomes float32 there.
        """
        frame, device = self._frames[index], torch.device(device)
        if index in self._on_gpu and device == self._on_gpu[index][0].image.device:
            return _view(frame, *self._on_gpu[index])
        decoded = self._cache.get(index)
        if decoded is None:
            future = self._pending.pop(index, None)
            decoded = _decode(frame) if future is None else future.result()
            if device.type != "cpu" and self._fits(decoded, device):
                self._on_gpu[index] = decoded.to(device), frame.camera.to(device)
                return _view(frame, *self._on_gpu[index])
            if device.type == "cuda":
                decoded = decoded.pinned()
            if decoded.nbytes <= self._left:
                self._left -= decoded.nbytes
                self._cache[index] = decoded
        return _view(frame, decoded.to(device), frame.camera.to(device))

    def _fits(self, decoded: _Decoded, device: torch.device) -> bool:
        """Take the bytes of a photo from those that the GPU has for photos; False if too few."""
        if self._room is None:
            self._room = free_bytes(device) // 4
        fits = decoded.nbytes <= self._room
        self._room -= decoded.nbytes if fits else 0
        return fits

    def prefetch(self, indices: Iterable[int]) -> None:
        """Start to decode frames in the background.

        At most 4 frames per thread are pending, which bounds the memory outside the cache; `get`
        decodes any others.
        """
        for index in indices:
            if len(self._pending) >= 4 * THREADS:
                return
            if index in self._cache or index in self._on_gpu or index in self._pending:
                continue
            if self._pool is None:
                self._pool = ThreadPoolExecutor(THREADS, thread_name_prefix="views")
            self._pending[index] = self._pool.submit(_decode, self._frames[index])

    def close(self) -> None:
        """Stop the threads, drop pending frames and free a GPU. `get` still works."""
        self._pending.clear()
        self._on_gpu.clear()
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def __enter__(self) -> "ViewLoader":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _decode(frame: Frame) -> _Decoded:
    """Decode the photo and mask of a frame, 8 bits per channel, and undistort them."""
    at = frame.photo or frame.camera
    if frame.pixels is not None:
        return _Decoded(frame.pixels, None)
    if frame.image_path is None:
        raise InputError(f"frame {frame.name} has neither image_path nor pixels")
    over = frame.background if frame.alpha == "over" else None
    pixels, usable = images.read_pixels(frame.image_path, at.width, at.height, over=over)
    image = torch.from_numpy(np.array(pixels))
    mask = None if usable is None else torch.from_numpy(usable)
    if frame.mask_path is not None:
        used = torch.from_numpy(masks.read_mask(frame.mask_path, at.width, at.height))
        mask = used if mask is None else mask & used
    if frame.photo is not None:
        image, mask = undistorted(image, mask, frame.photo, frame.camera)
    return _Decoded(image, None if mask is None or bool(mask.all()) else mask)


def undistorted(
    image: UInt8[Tensor, "H W 3"],
    mask: Bool[Tensor, "H W"] | None,
    photo: LensPhoto,
    camera: Camera,
) -> tuple[UInt8[Tensor, "h w 3"], Bool[Tensor, "h w"]]:
    """Return (image, mask) of a view of a photo; the mask has pixels made of masked ones only."""
    channels = image.float()
    if mask is not None:
        channels = torch.cat([channels, mask[:, :, None].float()], dim=2)
    channels, known = undistort(channels, photo, K=camera.K, size=(camera.width, camera.height))
    if mask is not None:
        known = known & (channels[:, :, 3] > 0.999)
    return channels[:, :, :3].round().to(torch.uint8), known


def _view(frame: Frame, decoded: _Decoded, camera: Camera) -> View:
    mask = None if decoded.mask is None else decoded.mask.float()
    return View(frame.name, camera, decoded.image / 255, mask)


def posed_frames(
    name: str,
    camera: Camera,
    *,
    image_path: Path,
    downscale: int | None,
    mask_path: Path | None,
    distortion: Distortion,
    background: Color,
    group: str = "",
    alpha: Literal["mask", "over"] = "mask",
) -> list[Frame]:
    """Return the frames of a photo at its size divided by `downscale` (None: at most 1600 wide).

    A panorama has six, any other photo one. `camera` has the pose of the photo and its intrinsics
    before the `distortion`, at any resolution of the same aspect ratio. Only headers of files are
    read. Raises `InputError` if a file cannot be read, if the aspect ratios of camera, photo and
    mask differ, or if the lens leaves no view.
    """
    recorded = (camera.width, camera.height)
    with images.open_image(image_path) as image, images.decoding(image_path):
        turned = images.is_turned(image, recorded)
        size = (image.height, image.width) if turned else image.size
        colors = images.colors_name(image)
    if not images.same_shape(size, recorded):
        raise InputError(
            f"{image_path} is {size[0]}x{size[1]} but its camera is "
            f"{recorded[0]}x{recorded[1]}; use the photos from which the poses were computed, "
            "not cropped or rotated"
        )
    if mask_path is not None and not images.same_shape(images.image_size(mask_path), size):
        raise InputError(f"mask {mask_path} has another aspect ratio than its photo {image_path}")
    if not bool(camera.viewmat.isfinite().all() and camera.K.isfinite().all()):
        raise InputError(f"the camera of {name} has numbers that are not finite")
    views = pinhole_views(str(image_path), camera, size, distortion=distortion, downscale=downscale)
    path = PurePosixPath(name)
    return [
        Frame(
            name=str(path.with_stem(f"{path.stem}_{view.face}")) if view.face else name,
            camera=view.camera,
            image_path=image_path,
            mask_path=mask_path,
            photo=view.photo,
            group=group or (name if view.face else ""),
            alpha=alpha,
            background=background,
            colors=colors,
        )
        for view in views
    ]
