"""Images and depths of the teacher from which the student learns."""

import torch

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
