"""The peak memory of this process, as Linux reports it."""

from pathlib import Path

STATUS = Path("/proc/self/status")
RESET = Path("/proc/self/clear_refs")  # tests are skipped where it does not exist


class MemoryMeter:
    """Measures the peak memory of the process since `start`, minus the memory at `start`."""

    def start(self) -> None:
        RESET.write_text("5")
        self.before = self.read("VmRSS")

    def peak(self) -> int:
        """Return the peak in bytes."""
        return self.read("VmHWM") - self.before

    def read(self, name: str) -> int:
        """Return a figure of the process in bytes, such as VmRSS."""
        return int(STATUS.read_text().split(name + ":", 1)[1].split(None, 1)[0]) << 10
