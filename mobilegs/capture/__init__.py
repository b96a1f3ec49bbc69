"""Photos or a video -> a capture: where every photo was taken, by structure from motion."""

from mobilegs.capture.run import CaptureRun, capture_photos, is_source

__all__ = ["CaptureRun", "capture_photos", "is_source"]
