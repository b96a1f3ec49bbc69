"""Trainings with a live view, and browsers that look at them."""

import http.client
import json
import threading
from pathlib import Path
from typing import Any

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, load_view
from mobilegs.live.frames import BrowserCamera
from mobilegs.live.page import Page, Visitor
from mobilegs.live.session import LiveSession
from mobilegs.train.monitor import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.tiny import CPU


def browser_at(camera: Camera, *, width: int = 24, height: int = 24) -> BrowserCamera:
    """A browser's camera in the place of a photo's."""
    focal = float(camera.K[1, 1]) * height / camera.height
    viewmat = (*camera.viewmat[:3].flatten().tolist(), 0.0, 0.0, 0.0, 1.0)
    return BrowserCamera(viewmat, focal, width, height)


def wishes(camera: Camera, **other: Any) -> dict[str, Any]:
    """Return the message that the page posts for a frame."""
    browser = browser_at(camera, width=40, height=30)
    own = {"visitor": 1, "seen": 0, "mode": "render", "viewmat": list(browser.viewmat)}
    return own | {"focal": browser.focal, "width": 40, "height": 30} | other


class Client:
    """A browser that speaks HTTP by hand."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.host = f"127.0.0.1:{page.server_port}"

    def ask(
        self, method: str, path: str, body: bytes | None = None, **headers: str | None
    ) -> tuple[int, bytes]:
        """Send one request; headers of None are left out."""
        given: dict[str, str | None] = {"Host": self.host}
        if method == "POST":
            given |= {"Origin": f"http://{self.host}", "Content-Type": "application/json"}
            given["Content-Length"] = str(len(body or b""))
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection("127.0.0.1", self.page.server_port, timeout=20)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in given.items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders(body)
        answer = connection.getresponse()
        found = answer.status, answer.read()
        connection.close()
        return found

    def post(self, asked: str, content: Any) -> tuple[int, bytes]:
        """Post something as JSON, as the page does."""
        return self.ask("POST", self.page.path + asked, json.dumps(content).encode())


class CountedEvent(threading.Event):
    """An event that counts how often somebody waited for it."""

    waits = 0

    def wait(self, timeout: float | None = None) -> bool:
        self.waits += 1
        return super().wait(timeout)


class Training:
    """A teacher that trains slowly, with a live view, in its own thread until `close`."""

    def __init__(self, dataset: Dataset, folder: Path, last: int = 1_000_000) -> None:
        fixed = TeacherConfig(steps=1_000_000, densify=DensifyConfig(strategy="fixed"))
        self.last = last
        self.stage = Teacher(fixed, dataset, seed=0, device=CPU)
        self.page = Page("127.0.0.1", 0, dataset)
        self.client = Client(self.page)
        self.page.changed = self.changed = CountedEvent()
        self.monitor = Monitor(folder / "log", [], {}, silent=True)
        self.monitor.begin(self.stage)
        self.live = LiveSession(self.page, dataset, self.monitor)
        self.stop = StopRequest()
        self.dataset, self.near = dataset, dataset.near
        self.names = [frame.name for frame in dataset.train]
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._train)
        self._thread.start()

    def visitors(self) -> list[Visitor]:
        return self.page.visitors()

    def join(self) -> None:
        """Wait for the last step."""
        self._thread.join()

    def close(self) -> None:
        self.stop.requested = True
        self._closed.set()
        self._thread.join()
        self.page.close()

    def _train(self) -> None:
        frames = self.dataset.train
        while not self.stop and self.stage.done < self.last:
            [index] = view_order(len(frames), self.stage.done, 1, 0)
            self.monitor.after_step(
                self.stage, self.stage.advance([(index, load_view(frames[index]))])
            )
            self.live.after_step(self.stage, self.stop)
            self._closed.wait(0.01)  # leaves time for the server's threads
