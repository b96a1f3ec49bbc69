"""The view loader: the same views from the cache, a thread or the disk."""

import threading

import pytest
import torch
from torch.overrides import TorchFunctionMode

from mobilegs.camera import Camera
from mobilegs.data import ViewLoader, load_capture, load_view
from mobilegs.data.dataset import View
from mobilegs.errors import InputError
from tests.support.colmap_capture import write_capture_of_noise


@pytest.mark.parametrize("cache_bytes", [0, 12 * 8 * 3 * 2, 1 << 20])
def test_views_do_not_depend_on_cache_or_prefetching(tmp_path, cache_bytes):
    frames = load_capture(write_capture_of_noise(tmp_path)).train
    expected = [load_view(frame) for frame in frames]
    with ViewLoader(frames, cache_bytes=cache_bytes) as loader:
        for _ in range(2):
            loader.prefetch(range(len(loader)))
            for index in (3, 0, 6, 3, 1, 2, 4, 5):
                view = loader.get(index)
                assert view.name == expected[index].name
                assert torch.equal(view.image, expected[index].image)
                assert view.image.dtype == torch.float32
                assert 0 <= view.image.min() and view.image.max() <= 1


def test_a_cached_view_is_not_read_again(tmp_path):
    root = write_capture_of_noise(tmp_path)
    frames = load_capture(root).train
    loader = ViewLoader(frames, cache_bytes=12 * 8 * 3)
    first = loader.get(0).image
    loader.get(1)  # does not fit into the cache
    for frame in frames:
        assert frame.image_path is not None
        frame.image_path.unlink()
    assert torch.equal(loader.get(0).image, first)
    with pytest.raises(InputError):
        loader.get(1)


def test_photos_stay_on_a_gpu_while_there_is_room(tmp_path, monkeypatch):
    size = 12 * 8 * 3
    monkeypatch.setattr("mobilegs.data.dataset.free_bytes", lambda device: 4 * 2 * size)
    frames = load_capture(write_capture_of_noise(tmp_path)).train
    loader = ViewLoader(frames, cache_bytes=size)
    first = [loader.get(index, "meta") for index in range(3)]
    for frame in frames:
        assert frame.image_path is not None
        frame.image_path.unlink()
    again = [loader.get(index, "meta") for index in range(3)]  # the third is in main memory
    assert [view.camera is old.camera for view, old in zip(again, first, strict=True)] == [
        *(True, True, False)
    ]
    assert all(view.image.device.type == "meta" for view in again)
    with pytest.raises(InputError):
        loader.get(3, "meta")


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs an NVIDIA GPU")
def test_photos_without_room_on_a_gpu_come_from_pinned_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("mobilegs.data.dataset.free_bytes", lambda device: 0)
    copied = []

    class RecordCopies(TorchFunctionMode):
        def __torch_function__(self, func, types, args=(), kwargs=None):
            if func is torch.Tensor.to and args[0].shape[:2] == (8, 12):
                copied.append((args[0].is_pinned(), (kwargs or {}).get("non_blocking")))
            return func(*args, **(kwargs or {}))

    frames = load_capture(write_capture_of_noise(tmp_path)).train
    loader = ViewLoader(frames, cache_bytes=12 * 8 * 3)  # of one photo
    for _ in range(2):
        for index in range(3):
            with RecordCopies():
                view = loader.get(index, "cuda")
            assert torch.equal(view.image.cpu(), load_view(frames[index]).image)
    assert copied == [(True, True)] * 6


def test_changing_a_view_does_not_change_the_cache(tmp_path):
    loader = ViewLoader(load_capture(write_capture_of_noise(tmp_path)).train)
    before = loader.get(0).image.clone()
    loader.get(0).image.zero_()
    assert torch.equal(loader.get(0).image, before)


def test_a_view_moves_to_the_device_with_8_bits_per_channel(tmp_path, monkeypatch):
    monkeypatch.setattr("mobilegs.data.dataset.free_bytes", lambda device: 0)
    moved = []

    class RecordMoves(TorchFunctionMode):
        def __torch_function__(self, func, types, args=(), kwargs=None):
            if func is torch.Tensor.to and args[0].shape[:2] == (8, 12):
                moved.append(args[0].dtype)
            return func(*args, **(kwargs or {}))

    loader = ViewLoader(load_capture(write_capture_of_noise(tmp_path)).train)
    with RecordMoves():
        view = loader.get(0, "meta")
    assert moved == [torch.uint8]
    assert view.image.is_meta and view.image.dtype == torch.float32
    assert view.camera.viewmat.is_meta and view.image.shape == loader.get(0).image.shape


def test_get_raises_the_error_of_a_damaged_photo_with_and_without_prefetching(tmp_path):
    root = write_capture_of_noise(tmp_path)
    frames = load_capture(root).train
    path = root / "images" / frames[2].name
    path.write_bytes(path.read_bytes()[:200])
    with ViewLoader(frames) as loader:
        loader.prefetch([1, 2])
        loader.get(1)
        for _ in range(2):
            with pytest.raises(InputError, match=frames[2].name):
                loader.get(2)


def test_close_ends_the_threads_and_get_still_works(tmp_path):
    frames = load_capture(write_capture_of_noise(tmp_path)).train
    loader = ViewLoader(frames)
    loader.prefetch(range(7))
    assert any(thread.name.startswith("views") for thread in threading.enumerate())
    loader.close()
    assert not any(thread.name.startswith("views") for thread in threading.enumerate())
    assert torch.equal(loader.get(4).image, load_view(frames[4]).image)


def test_a_reduced_view_averages_pixels_and_keeps_its_rays():
    K = torch.tensor([[20.0, 0.0, 5.0], [0.0, 21.0, 3.0], [0.0, 0.0, 1.0]])
    camera = Camera(torch.eye(4), K, 11, 7)
    image = torch.rand(7, 11, 3, generator=torch.Generator().manual_seed(0))
    mask = torch.ones(7, 11)
    mask[4, 5] = 0
    small = View("a", camera, image, mask).reduced(3)
    assert (small.camera.width, small.camera.height) == (3, 2)
    assert torch.allclose(small.image[1, 2], image[3:6, 6:9].mean((0, 1)))
    assert small.mask is not None and small.mask.tolist() == [[1, 1, 1], [1, 0, 1]]
    # the centre of pixel (2, 1) is that of the pixels 6 to 8 and 3 to 5
    centres = torch.tensor([2.5, 1.5, 1.0]), torch.tensor([7.5, 4.5, 1.0])
    small_ray, ray = (
        torch.linalg.solve(k, at) for k, at in zip((small.camera.K, K), centres, strict=True)
    )
    assert torch.allclose(small_ray, ray)
    assert View("a", camera, image).reduced(1).image is image
