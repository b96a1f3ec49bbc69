"""Makes a capture from photos or a video: camera poses by structure from motion (COLMAP)."""

from mobilegs.capture.run import CaptureRun, capture_photos, is_capture_source

__all__ = ["CaptureRun", "capture_photos", "is_capture_source"]
