"""The live view of a training: frames in a browser, and no influence on the result."""

import http.client
import io
import json
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.live import ADDRESS, parse_address, validate_live_options
from mobilegs.live.frame_budget import FrameBudget
from mobilegs.live.frames import (
    error_map,
    letterbox,
    side_by_side,
    view_psnr,
)
from mobilegs.live.page import FORGET_SECONDS, MODES, VISITORS_MAX, Page, Visitor
from mobilegs.live.session import LiveSession
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
from mobilegs.progress_display import printed_log
from mobilegs.train.monitor import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.browser import Chromium
from tests.support.live import browser_at
from tests.support.runs import RECIPE
from tests.support.tiny import CPU, cameras

FREE_PORT = "127.0.0.1:0"
POLLS = 5  # of a paused training, after which it counts as waiting


# --- influence on the training


@pytest.fixture
def sent_frames(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Frames of a browser that sees every step, each in another mode."""
    sent: list[np.ndarray] = []
    visitor = Visitor(browser_at(cameras()[1], width=40, height=30), MODES[0], 0.0, 0.0)

    def send_frame(page: Page, to: Visitor, frame: np.ndarray, said: dict[str, str]) -> None:
        sent.append(frame)
        to.mode = MODES[len(sent) % len(MODES)]

    monkeypatch.setattr(Page, "send_frame", send_frame)
    monkeypatch.setattr(Page, "visitors", lambda page: [visitor])
    monkeypatch.setattr(FrameBudget, "allows", lambda budget, *, urgent: True)
    return sent


@pytest.mark.thorough
def test_a_run_with_a_live_view_writes_the_same_bytes(
    capture: Path, finished: Path, tmp_path: Path, sent_frames: list[np.ndarray], capfd
) -> None:
    run = TrainRun(capture, tmp_path / "run", live=True, live_at=FREE_PORT)
    with printed_log():
        train_capture(run, recipe=RECIPE)
    assert len(sent_frames) == RECIPE.teacher.steps + RECIPE.student.steps
    assert all(frame.std() > 1 for frame in sent_frames)
    for name in ("teacher.ply", "scene.mgs"):
        assert (run.output / name).read_bytes() == (finished / name).read_bytes()
    printed = capfd.readouterr()
    assert "live view: http://127.0.0.1:" in printed.out and printed.err == ""


@pytest.mark.thorough
def test_a_paused_run_uses_no_cpu_and_can_be_stopped(
    capture: Path, finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    polls: list[tuple[float, float]] = []  # wall and CPU seconds

    def set_status(page: Page, rows: dict[str, str]) -> None:
        if rows.get("student", "").startswith("5 "):
            polls.append((time.monotonic(), time.process_time()))
            if len(polls) == 1:
                page.pause(True)
        if len(polls) == POLLS + 3:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("mobilegs.live.session.STATUS_SECONDS", 0.0)
    monkeypatch.setattr(Page, "set_status", set_status)
    run = TrainRun(capture, tmp_path / "run", live=True, live_at=FREE_PORT)
    with pytest.raises(KeyboardInterrupt):
        train_capture(run, recipe=RECIPE)
    wall, cpu = np.subtract(polls[-1], polls[2])  # without the first frames of the pause
    assert wall > 0.5 and cpu < 0.5 * wall
    assert (run.output / "checkpoint.safetensors").exists()
    monkeypatch.undo()
    resumed = replace(run, resume=True, live=False, live_at=ADDRESS)
    metrics = train_capture(resumed)
    assert (run.output / "scene.mgs").read_bytes() == (finished / "scene.mgs").read_bytes()
    assert metrics["seconds"]["student"] < 30


def test_a_pause_does_not_count_as_training_time(dataset: Dataset, tmp_path: Path) -> None:
    stage = Teacher(TeacherConfig(steps=10), dataset, seed=0, device=CPU)
    monitor = Monitor(tmp_path / "log", [], {}, silent=True)
    monitor.begin(stage)
    monitor.exclude_time(50.0)
    assert monitor.elapsed() < 0


# --- validation


@pytest.mark.parametrize(
    ("live", "address", "message"),
    [
        (False, "0.0.0.0:9000", "give both"),
        (True, "9000", "HOST:PORT"),
        (True, "127.0.0.1:x", "HOST:PORT"),
        (True, "127.0.0.1:70000", "HOST:PORT"),
        (True, "203.0.113.5:9000", "address of this machine"),
    ],
)
def test_invalid_addresses_are_refused(live: bool, address: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        validate_live_options(live, address)


def test_a_training_in_several_processes_has_no_live_view(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WORLD_SIZE", "2")
    with pytest.raises(InputError, match="one process"):
        validate_live_options(True, ADDRESS)


def test_by_default_only_this_machine_can_connect() -> None:
    assert parse_address(ADDRESS)[0] == "127.0.0.1"


# --- hostile browsers


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


def wishes(camera: Camera, **other: Any) -> dict[str, Any]:
    """Return the message that the page posts for a frame."""
    browser = browser_at(camera, width=40, height=30)
    own = {"visitor": 1, "seen": 0, "mode": "render", "viewmat": list(browser.viewmat)}
    return own | {"focal": browser.focal, "width": 40, "height": 30} | other


@pytest.fixture
def page(dataset: Dataset) -> Iterator[Page]:
    """A page without a training."""
    made = Page("127.0.0.1", 0, dataset)
    yield made
    made.close()


def test_only_people_with_the_address_reach_the_training(page: Page) -> None:
    client, body = Client(page), json.dumps(wishes(cameras()[0])).encode()
    look = f"{page.path}look"
    assert client.ask("GET", page.path)[0] == 200
    assert client.ask("POST", look, body)[0] == 200
    for path in ("/", "/look", "/wrong/", "//", f"{page.path}../x", f"{page.path}viewer.js"):
        assert client.ask("GET", path)[0] == 404
    for host in ("evil.example", "evil.example:80", "", None, "127.0.0.1.evil.example"):
        assert client.ask("GET", page.path, Host=host)[0] == 403
        assert client.ask("POST", look, body, Host=host, Origin=f"http://{host}")[0] == 403
    for origin in (None, "null", "http://evil.example", "http://127.0.0.1:1"):
        assert client.ask("POST", look, body, Origin=origin)[0] == 403
        assert client.ask("POST", f"{page.path}pause", b'{"paused":true}', Origin=origin)[0] == 403
    assert client.ask("POST", look, body, Content_Type="text/plain")[0] == 415
    assert client.ask("POST", look, body, Content_Length=None)[0] == 411
    assert client.ask("POST", look, body, Content_Length="9" * 9)[0] == 413
    assert not page.paused and len(page.visitors()) == 1


BIG = 10**400
WRONG: list[dict[str, Any]] = [
    *({"viewmat": value} for value in (None, [], [1, 2], [0] * 16, [1e300] * 16, ["1"] * 16, {})),
    *({"viewmat": [*np.eye(4).flatten().tolist()[:15], value]} for value in (2, True, None, BIG)),
    *({"focal": value} for value in (0, -1, 1e-9, 1e9, None, "30", BIG, [30])),
    *({"width": value} for value in (0, -1, 1.5, 10**12, BIG, None, True, "40", 8000)),
    *({"height": value} for value in (0, -1, 10**12, BIG, None, 8000)),
    *({"mode": value} for value in (None, 0, "", "Render", ["render"], {})),
    *({"visitor": value} for value in (None, -1, 0.5, "1", BIG, [1])),
    *({"seen": value} for value in (None, -1, "1")),
]


def test_what_the_page_does_not_send_is_refused(page: Page) -> None:
    client = Client(page)
    faults = []
    for change in WRONG:
        status, body = client.post("look", wishes(cameras()[0], **change))
        if status != 400 or not json.loads(body)["error"]:
            faults.append((change, status, body))
    assert not faults
    for body in (b"", b"x", b"[" * 4000, b"NaN", b"\xff", b"null", b"[]", b'"look"', b"1e999"):
        assert client.ask("POST", f"{page.path}look", body)[0] == 400
    nan = json.dumps(wishes(cameras()[0], focal=float("nan"))).encode()
    assert client.ask("POST", f"{page.path}look", nan)[0] == 400
    for paused in (None, 0, "yes", []):
        assert client.post("pause", {"paused": paused})[0] == 404
    assert not page.visitors() and not page.paused and not page.changed.is_set()


def test_a_crowd_is_limited_and_forgotten(dataset: Dataset) -> None:
    now = [0.0]
    page = Page("127.0.0.1", 0, dataset, clock=lambda: now[0])
    try:
        ask = [page.look(wishes(cameras()[0], visitor=number)) for number in range(VISITORS_MAX)]
        assert all(frame is None for _, frame in ask)
        with pytest.raises(InputError, match="already"):
            page.look(wishes(cameras()[0], visitor=99))
        now[0] += FORGET_SECONDS + 1
        assert page.visitors() == []
        page.look(wishes(cameras()[0], visitor=99))
    finally:
        page.close()


def message(noise: np.random.Generator) -> dict[str, Any]:
    """A message: half are valid, from anywhere, of any size; the others have a wrong field."""
    size = noise.integers(200, 8000, 2).clip(max=1200 if noise.random() < 0.9 else 8192)
    asked = wishes(
        cameras()[int(noise.integers(4))],
        visitor=int(noise.integers(12)),
        mode=MODES[noise.integers(len(MODES))],
        seen=int(noise.integers(50)),
        width=int(size[0]),
        height=int(size[1]),
    )
    turn = np.linalg.qr(noise.standard_normal((3, 3)))[0]
    place = noise.standard_normal((3, 1)) * 10 ** noise.uniform(-3, 11)
    asked["viewmat"] = [*np.hstack([turn, place]).flatten().tolist(), 0, 0, 0, 1]
    asked["focal"] = asked["height"] * float(10 ** noise.uniform(-1.2, 1.6))
    if noise.random() < 0.5:
        values = [None, -1, 1e308, BIG, "x", [], {}, float("nan"), "sorted"]
        asked[list(asked)[noise.integers(len(asked))]] = values[noise.integers(len(values))]
    return asked


@pytest.mark.thorough
def test_a_training_with_a_thousand_random_messages_has_the_same_result(
    dataset: Dataset, tmp_path: Path
) -> None:
    noise, statuses, drawn = np.random.default_rng(0), [], 0
    attacked = Training(dataset, tmp_path / "attacked")
    for number in range(1000):
        statuses.append(attacked.client.post("look", message(noise))[0])
        if number % 100 == 99:
            drawn += sum(visitor.frames for visitor in attacked.visitors())
    steps = attacked.stage.done
    attacked.close()
    steps, scene = attacked.stage.done, attacked.stage.gaussians().tensors()
    assert {*statuses} == {200, 400} and statuses.count(200) > 300 and drawn > 100
    quiet = Training(dataset, tmp_path / "quiet", last=steps)
    quiet.join()
    alone = quiet.stage.gaussians().tensors()
    quiet.close()
    assert all(torch.equal(scene[name], alone[name]) for name in scene)


def test_a_photo_that_is_gone_does_not_end_the_training(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    training = Training(dataset, tmp_path)

    def gone(frame: Any) -> None:
        raise InputError("cannot read 0.png: there is no such file")

    monkeypatch.setattr("mobilegs.live.session.load_view", gone)
    try:
        end = time.monotonic() + 60
        said: dict[str, str] = {}
        while "no picture" not in said and time.monotonic() < end:
            state, _ = training.page.look(wishes(cameras()[0], mode="photo"))
            said = dict(state["rows"])
        assert "0.png" in said["no picture"]
        done = training.stage.done
        while training.stage.done < done + 3:
            assert time.monotonic() < end
            time.sleep(0.01)
    finally:
        training.close()


def test_a_browser_at_rest_does_not_keep_another_from_moving(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FrameBudget, "allows", lambda budget, *, urgent: urgent)
    training = Training(dataset, tmp_path)

    def frames(visitor: int, mode: str) -> int:
        return training.page.look(wishes(cameras()[0], visitor=visitor, mode=mode))[0]["seen"]

    try:
        end, mode = time.monotonic() + 60, "render"
        while min(frames(1, "render"), frames(2, mode)) < 1 or frames(2, mode) < 4:
            mode = "depth" if mode == "render" else "render"
            assert time.monotonic() < end
            time.sleep(0.05)
    finally:
        training.close()


# --- in the browser


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


@pytest.fixture
def training(dataset: Dataset, tmp_path: Path) -> Iterator[Training]:
    """A training with a live view."""
    made = Training(dataset, tmp_path)
    yield made
    made.close()


@pytest.fixture
def browser(chromium: Chromium, training: Training) -> Iterator[Any]:
    """The page of the training, once its first frame is there."""
    page = chromium.foreign()
    page.requested = []
    page.on("request", lambda request: page.requested.append(request.url))
    page.goto(training.page.address)
    until(page, lambda: any(visitor.frames for visitor in training.visitors()))
    yield page
    page.close()


def until(page: Any, condition: Callable[[], bool], seconds: float = 60.0) -> None:
    """Wait until a condition is true."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "the condition never became true"
        page.wait_for_timeout(50)


def pause(page: Any, training: Training) -> None:
    """Pause the training, and wait until it stands still."""
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: training.changed.waits > 0)


def pixels(page: Any) -> np.ndarray:
    """The canvas, as it is seen."""
    png = page.locator("canvas").screenshot()
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), np.float64)


def shows(page: Any, expected: np.ndarray, tolerance: float) -> Callable[[], bool]:
    """A condition: the canvas shows a picture."""

    def condition() -> bool:
        seen = pixels(page)
        size = seen.shape[1], seen.shape[0]
        wide = np.asarray(Image.fromarray(expected).resize(size), np.float64)
        return bool(np.abs(seen - wide).mean() < tolerance)

    return condition


def test_the_browser_shows_the_scene_of_the_training(training: Training, browser: Any) -> None:
    browser.get_by_role("checkbox", name="Cameras").uncheck()
    pause(browser, training)
    [visitor] = training.visitors()
    camera = visitor.camera.camera(visitor.camera.width, visitor.camera.height, training.near)
    expected = to_bytes(training.stage.scene().render(camera).image).numpy()
    until(browser, shows(browser, expected, 3))
    # from where the first photo was taken
    place = training.dataset.train[0].camera.position
    assert torch.allclose(visitor.camera.position.float(), place, atol=1e-4)
    done = training.stage.done
    browser.get_by_text(f"{done:,} of 1,000,000").wait_for()
    waits = training.changed.waits
    until(browser, lambda: training.changed.waits > waits + POLLS)
    assert training.stage.done == done
    browser.get_by_role("button", name="Resume").click()
    until(browser, lambda: training.stage.done > done + 5)


def test_people_move_the_camera_and_go_to_photos(training: Training, browser: Any) -> None:
    places = training.page.cameras.positions

    def is_at(index: int) -> Callable[[], bool]:
        return lambda: bool(
            torch.allclose(training.visitors()[0].camera.position, places[index], atol=1e-3)
        )

    first = training.visitors()[0].camera
    for mode in (*MODES[1:], MODES[0]):
        browser.get_by_label("Show").select_option(mode)
        until(browser, lambda mode=mode: training.visitors()[0].mode == mode)
    assert training.visitors()[0].camera == first  # modes do not move it
    browser.mouse.move(300, 450)
    browser.mouse.down()
    browser.mouse.move(380, 450, steps=4)
    browser.mouse.up()
    until(browser, lambda: training.visitors()[0].camera.position.allclose(first.position) is False)
    for _ in range(2):  # the same photo twice
        browser.get_by_label("Go to photo").select_option(training.names[3])
        until(browser, is_at(3))
        browser.get_by_role("button", name="Go back to the start").click()
        until(browser, is_at(0))
    browser.mouse.move(300, 450)
    browser.mouse.wheel(0, 300)
    until(browser, lambda: not is_at(0)())
    browser.wait_for_timeout(1000)  # until the page knows what is nearest
    browser.get_by_role("button", name="Go to the nearest photo").click()
    nearest = training.page.cameras.nearest(training.visitors()[0].camera)
    until(browser, is_at(nearest))


def test_a_click_on_a_camera_goes_to_its_photo(training: Training, browser: Any) -> None:
    places = training.page.cameras.positions.numpy()
    browser.mouse.move(300, 300)
    browser.mouse.wheel(0, 1500)  # away from the scene, so that cameras are in the picture
    browser.wait_for_timeout(1500)
    seen = training.visitors()[0].camera
    scale = browser.evaluate("devicePixelRatio")
    matrix = np.array(seen.viewmat).reshape(4, 4)
    x, y, z = (matrix[:3, :3] @ places.T + matrix[:3, 3:]).clip(-1e6, 1e6)
    u = (seen.width / 2 + seen.focal * x / z) / scale
    v = (seen.height / 2 + seen.focal * y / z) / scale
    inside = (z > 0) & (u > 20) & (u < seen.width / scale - 20) & (v > 20) & (v < 580)
    away = np.hypot(u[:, None] - u, v[:, None] - v) + np.diag(np.full(len(u), np.inf))
    index = int(np.argmax(np.where(inside, away.min(1), -1)))
    assert inside[index]
    browser.mouse.move(u[index], v[index])
    until(browser, lambda: browser.evaluate("document.querySelector('canvas').style.cursor") != "")
    browser.mouse.click(u[index], v[index])
    until(
        browser,
        lambda: np.allclose(training.visitors()[0].camera.position, places[index], atol=1e-3),
    )


def test_photo_modes_show_the_nearest_photo(training: Training, browser: Any) -> None:
    pause(browser, training)
    browser.get_by_label("Show").select_option("photo | render | error")
    view = load_view(training.dataset.train[0])
    image = training.stage.scene().render(view.camera).image
    browser.get_by_text(f"{view_psnr(image, view):.2f} dB").wait_for()
    size = training.visitors()[0].camera.width, training.visitors()[0].camera.height
    row = side_by_side([view.image, image, error_map(image, view)], size[0] / size[1])
    until(browser, shows(browser, to_bytes(letterbox(row, *size)).numpy(), 6))


def test_names_of_photos_are_text_and_nothing_comes_from_the_internet(
    dataset: Dataset, tmp_path: Path, chromium: Chromium
) -> None:
    name = "<img src=x onerror=window.attacked=1>.png"
    named = replace(dataset, name=name, train=[replace(f, name=name) for f in dataset.train])
    training, page, requested = Training(named, tmp_path), chromium.foreign(), []
    try:
        page.on("request", lambda request: requested.append(request.url))
        page.goto(training.page.address)
        page.get_by_label("Show").select_option("photo")
        page.locator("dt", has_text=name).wait_for()
        page.wait_for_timeout(300)
        assert page.evaluate("window.attacked") is None and name in page.title()
        own = (training.page.address, "data:", "blob:")
        assert not [url for url in requested if not url.startswith(own)]
    finally:
        page.close()
        training.close()


def test_the_page_says_when_the_training_has_ended(
    dataset: Dataset, tmp_path: Path, chromium: Chromium
) -> None:
    training, page = Training(dataset, tmp_path), chromium.foreign()
    page.goto(training.page.address)
    page.locator("dt", has_text="teacher").wait_for()
    training.close()
    page.locator("dd", has_text="has ended").wait_for()
    page.close()
