"""Images and depths of the teacher from which the student learns."""

import torch

from mobilegs.evaluate.front import front_coverage
from mobilegs.render.scene import Scene
from mobilegs.train.student.distill import TeacherImages
from tests.support.tiny import blobs, cameras


def test_teacher_renders_do_not_depend_on_the_cache() -> None:
    camera = cameras()[0]
    kept = TeacherImages(Scene(blobs()), cache_bytes=1 << 20)
    drawn = TeacherImages(Scene(blobs()), cache_bytes=0)
    for _ in range(2):
        for a, b in zip(kept.get(0, camera), drawn.get(0, camera), strict=True):
            assert torch.equal(a, b)
    assert kept.free_bytes == (1 << 20) - 24 * 24 * 8 and drawn.free_bytes == 0


def test_the_depth_is_the_mean_of_covered_pixels() -> None:
    camera = cameras()[0]
    rendered = Scene(blobs()).render(camera, depth=True)
    found = TeacherImages(Scene(blobs()), cache_bytes=0).get(0, camera)
    assert rendered.depth is not None
    covered = rendered.alpha > 0.5
    assert covered.any() and not covered.all()
    expected = rendered.depth[covered] / rendered.alpha[covered]
    torch.testing.assert_close(found.depth[covered], expected, rtol=1e-3, atol=0)
    assert (found.depth[~covered] == 0).all()


def test_a_release_depth_is_the_sum_with_the_background() -> None:
    camera = cameras()[0]
    rendered = Scene(blobs()).render(camera, depth=True)
    assert rendered.depth is not None
    for level in (0.0, 1.0):
        scene = Scene(blobs(), background=torch.full((3,), level))
        found = TeacherImages(scene, cache_bytes=0, release_depths=True).get(0, camera)
        expected = rendered.depth + level * (1 - rendered.alpha)
        torch.testing.assert_close(found.depth, expected, rtol=1e-3, atol=0)


def test_coverages_lie_before_a_plane_of_their_view() -> None:
    kept = TeacherImages(Scene(blobs()), cache_bytes=1 << 20)
    drawn = TeacherImages(Scene(blobs()), cache_bytes=0)
    planes = set()
    for index, camera in enumerate(cameras()):
        first, again = kept.front(index, camera), kept.front(index, camera)
        for found in (again, drawn.front(index, camera)):
            assert found.z == first.z and torch.equal(found.coverage, first.coverage)
        expected = front_coverage(Scene(blobs()), camera, first.z)
        torch.testing.assert_close(first.coverage, expected, rtol=0, atol=0.5 / 255 + 1e-6)
        depths = camera.depths(blobs().means)
        assert depths.min() < first.z < depths.max()
        planes |= {first.z, kept.front(100 + index, camera).z}
    assert len(planes) == 2 * len(cameras())
    assert drawn.free_bytes == 0 and kept.free_bytes == (1 << 20) - 2 * len(cameras()) * 24 * 24


def test_a_view_without_surfaces_has_no_plane() -> None:
    empty = Scene(blobs().select(torch.zeros(50, dtype=torch.bool)))
    found = TeacherImages(empty, cache_bytes=0).front(0, cameras()[0])
    assert found.z == 0 and not found.coverage.any()
