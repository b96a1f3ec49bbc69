"""The live view of a training: frames in a browser, and no influence on the result."""

import io
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.cli.main import main
from mobilegs.data.dataset import Dataset, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.live import ADDRESS, parse_address, validate_live_options
from mobilegs.live.frame_budget import FrameBudget
from mobilegs.live.frames import (
    BrowserCamera,
    TrainingCameras,
    error_map,
    letterbox,
    side_by_side,
    view_psnr,
)
from mobilegs.pipeline.train import TrainRun, train_run
from mobilegs.progress_display import printed_log
from mobilegs.train.progress import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.browser import Chromium
from tests.support.live import browser_at
from tests.support.runs import RECIPE
from tests.support.tiny import CPU, cameras

pytest.importorskip("viser", reason="needs the extra live")

from mobilegs.live.page import BALL_RADIUS, CHOOSE, MODES, Page
from mobilegs.live.session import LiveSession

FREE_PORT = "127.0.0.1:0"
POLLS = 5  # of a paused training, after which it counts as waiting


# --- influence on the training


@pytest.fixture
def sent_frames(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Frames of a client that sees every step, each in another mode."""
    sent: list[np.ndarray] = []
    browser = browser_at(cameras()[1], width=40, height=30)

    def send_frame(page: Page, number: int, frame: np.ndarray) -> None:
        sent.append(frame)
        page.mode = MODES[len(sent) % len(MODES)]

    monkeypatch.setattr(Page, "send_frame", send_frame)
    monkeypatch.setattr(Page, "clients", lambda page: {1: browser})
    monkeypatch.setattr(FrameBudget, "allows", lambda budget, *, urgent: True)
    return sent


@pytest.mark.thorough
def test_a_run_with_a_live_view_writes_the_same_bytes(
    capture: Path, finished: Path, tmp_path: Path, sent_frames: list[np.ndarray], capfd
) -> None:
    run = TrainRun(capture, tmp_path / "run", live=True, live_at=FREE_PORT)
    with printed_log():
        train_run(run, recipe=RECIPE)
    assert len(sent_frames) == RECIPE.teacher.steps + RECIPE.student.steps
    assert all(frame.std() > 1 for frame in sent_frames)
    for name in ("teacher.ply", "scene.mgs"):
        assert (run.output / name).read_bytes() == (finished / name).read_bytes()
    printed = capfd.readouterr()
    assert "live view: http://127.0.0.1:" in printed.out
    assert printed.err == "" and "viser" not in printed.out


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
        train_run(run, recipe=RECIPE)
    wall, cpu = np.subtract(polls[-1], polls[2])  # without the first frames of the pause
    assert wall > 0.5 and cpu < 0.5 * wall
    assert (run.output / "checkpoint.safetensors").exists()
    monkeypatch.undo()
    resumed = replace(run, resume=True, live=False, live_at=ADDRESS)
    metrics = train_run(resumed)
    assert (run.output / "scene.mgs").read_bytes() == (finished / "scene.mgs").read_bytes()
    assert metrics["seconds"]["student"] < 30


def test_a_pause_does_not_count_as_training_time(dataset: Dataset, tmp_path: Path) -> None:
    stage = Teacher(TeacherConfig(steps=10), dataset, seed=0, device=CPU)
    monitor = Monitor(tmp_path / "log", [], {}, silent=True)
    monitor.begin(stage)
    monitor.exclude_time(50.0)
    assert monitor.elapsed() < 0


# --- validation


def test_without_viser_the_message_says_how_to_install_it(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    scene = tmp_path / "scene.ply"
    scene.touch()
    for verb in (["train", str(capture)], ["demo"], ["compress", str(scene)]):
        assert main([*verb, "--output", str(tmp_path / "run"), "--live"]) == 2
        said = capsys.readouterr().err
        assert "pip install 'mobilegs[live]'" in said and said.count("\n") == 1
    assert not (tmp_path / "run").exists()


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


def test_training_without_a_live_view_does_not_import_viser() -> None:
    code = "import sys, mobilegs.pipeline.train as _; print('viser' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


# --- in the browser


class CountedEvent(threading.Event):
    """An event that counts how often somebody waited for it."""

    waits = 0

    def wait(self, timeout: float | None = None) -> bool:
        self.waits += 1
        return super().wait(timeout)


class Training:
    """A teacher that trains slowly, with a live view, in its own thread until `close`."""

    def __init__(self, dataset: Dataset, folder: Path) -> None:
        fixed = TeacherConfig(steps=1_000_000, densify=DensifyConfig(strategy="fixed"))
        self.stage = Teacher(fixed, dataset, seed=0, device=CPU)
        self.page = Page("127.0.0.1", 0, dataset)
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

    def clients(self) -> list[BrowserCamera]:
        return list(self.page.clients().values())

    def close(self) -> None:
        self.stop.requested = True
        self._closed.set()
        self._thread.join()
        self.page.close()

    def _train(self) -> None:
        frames = self.dataset.train
        while not self.stop:
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
def browser(chromium: Chromium, training: Training) -> Iterator[object]:
    """The page of the training, once its camera is at the start."""
    page = chromium.foreign()
    page.requested = []
    page.on("request", lambda request: page.requested.append(request.url))
    page.goto(training.page.address)
    start = training.page.cameras.positions[0].numpy()
    until(
        page,
        lambda: any(np.allclose(found.position, start, atol=1e-4) for found in training.clients()),
    )
    yield page
    page.close()


def until(page, condition: Callable[[], bool], seconds: float = 60.0) -> None:
    """Wait until a condition is true."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "the condition never became true"
        page.wait_for_timeout(50)


def wait_steps(page, training: Training, steps: int) -> None:
    """Wait until the training has taken more steps."""
    done = training.stage.done
    until(page, lambda: training.stage.done >= done + steps)


def pause(page, training: Training) -> None:
    """Pause the training, and wait until it stands still."""
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: training.changed.waits > 0)


def settle(page, training: Training) -> BrowserCamera:
    """Wait until the camera has not moved for some steps, and return it."""
    before = training.clients()[0]
    while True:
        wait_steps(page, training, 20)
        after = training.clients()[0]
        if pose(before) == pose(after):
            return after
        before = after


def pose(browser: BrowserCamera) -> tuple:
    return browser.position, browser.rotation, browser.fov


def canvas(browser: BrowserCamera) -> tuple[int, int]:
    """The size of the canvas on the page; viser reports fewer pixels where drawing is slow."""
    return round(600 * browser.width / browser.height), 600


def on_screen(browser: BrowserCamera, point: np.ndarray) -> tuple[float, float]:
    """Project a point in the world to pixels of the page."""
    width, height = canvas(browser)
    camera = browser.camera(width, height, 0.1)
    x, y, z = camera.viewmat[:3, :3].numpy() @ point + camera.viewmat[:3, 3].numpy()
    focal, _, middle = camera.K[0].tolist()
    return (focal * x / z + middle, focal * y / z + height / 2) if z > 0 else (-1, -1)


def visible_balls(browser: BrowserCamera, views: TrainingCameras) -> list[tuple[int, float, float]]:
    """Cameras whose balls are on the page, not under the panel, and their pixels."""
    points = (views.positions - 2 * BALL_RADIUS * views.extent * views.forwards).numpy()
    places = [(index, *on_screen(browser, point)) for index, point in enumerate(points)]
    width = canvas(browser)[0]
    return [(index, x, y) for index, x, y in places if 20 < x < width - 20 and 200 < y < 580]


def pick(page, before: str, after: str) -> None:
    """Choose `after` in the list that shows `before`."""
    page.locator(f'input[role=combobox][value="{before}"]').click()
    page.get_by_role("option", name=after, exact=True).click()


def pixels(page) -> np.ndarray:
    """The part of the browser's window without panel and notice."""
    png = page.screenshot()
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), np.float64)[200:, :550]


def test_the_browser_shows_the_scene_of_the_training(training: Training, browser) -> None:
    page = browser
    page.get_by_role("checkbox", name="Cameras").click(force=True)
    until(page, lambda: not training.page.with_cameras)
    pause(page, training)
    found = training.clients()[0]
    camera = found.camera(*canvas(found), training.near)
    expected = to_bytes(training.stage.scene().render(camera).image).numpy()[200:, :550]
    until(page, lambda: np.abs(pixels(page) - expected).mean() < 3)


def test_pause_stops_the_training_and_resume_continues_it(training: Training, browser) -> None:
    page = browser
    pause(page, training)
    resume = page.get_by_role("button", name="Resume")
    resume.wait_for()
    done, waits = training.stage.done, training.changed.waits
    page.get_by_text(f"{done:,} of 1,000,000").wait_for()
    assert page.get_by_text("50", exact=False).count()
    until(page, lambda: training.changed.waits > waits + POLLS)
    assert training.stage.done == done
    resume.click()
    wait_steps(page, training, 5)


def test_a_frame_for_a_browser_that_has_just_closed_is_dropped(
    training: Training, browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = training.page._server
    training.stop.requested = True  # no other frames: viser warns once per browser
    [(number, client)] = server.get_clients().items()
    browser.close()
    end = time.monotonic() + 60
    while server.get_clients():
        assert time.monotonic() < end
        time.sleep(0.05)
    monkeypatch.setattr(server, "get_clients", lambda: {number: client})
    training.page.send_frame(number, np.zeros((4, 4, 3), np.uint8))


def test_only_the_user_moves_the_camera(training: Training, browser) -> None:
    page = browser
    first = training.clients()[0]
    for before, after in pairwise(MODES):
        pick(page, before, after)
        until(page, lambda mode=after: training.page.mode == mode)
    pick(page, MODES[-1], MODES[0])
    wait_steps(page, training, 20)
    assert pose(training.clients()[0]) == pose(first)
    page.mouse.move(300, 450)
    page.mouse.down()
    page.mouse.move(380, 450, steps=4)
    page.mouse.up()
    until(page, lambda: training.clients()[0].position != first.position)
    moved = settle(page, training)  # after the damped movement
    wait_steps(page, training, 20)
    assert pose(training.clients()[0]) == pose(moved)


def test_the_camera_can_move_to_a_photo(training: Training, browser) -> None:
    page, positions = browser, training.page.cameras.positions.numpy()

    def is_at(index: int) -> Callable[[], bool]:
        return lambda: np.allclose(training.clients()[0].position, positions[index], atol=1e-3)

    for _ in range(2):  # the same photo twice
        pick(page, CHOOSE, training.names[3])
        until(page, is_at(3))
        page.get_by_role("button", name="Go back to the start").click()
        until(page, is_at(0))
    others = []
    for start, name in enumerate(training.names):  # until another camera is visible
        pick(page, CHOOSE, name)
        until(page, is_at(start))
        found = settle(page, training)  # the field of view may change after the position
        others = [o for o in visible_balls(found, training.page.cameras) if o[0] != start]
        if others:
            break
    [(index, x, y), *_] = others
    page.mouse.move(x, y)
    hovered = "[...document.querySelectorAll('canvas')].some(c => c.style.cursor === 'pointer')"
    until(page, lambda: page.evaluate(hovered))
    page.mouse.click(x, y)
    until(page, is_at(index), 20)
    page.get_by_role("button", name="Go to the nearest photo").click()
    settle(page, training)
    assert is_at(index)()


def test_photo_modes_show_the_nearest_photo(training: Training, browser) -> None:
    page = browser
    pause(page, training)
    pick(page, "render", "photo | render | error")
    page.locator("strong", has_text=training.names[0]).wait_for()
    view = load_view(training.dataset.train[0])
    image = training.stage.scene().render(view.camera).image
    width, height = canvas(training.clients()[0])
    row = side_by_side([view.image, image, error_map(image, view)], width / height)
    wide = Image.fromarray(to_bytes(letterbox(row, width, height)).numpy()).resize((width, height))
    expected = np.asarray(wide, np.float64)[200:, :550]
    until(page, lambda: np.abs(pixels(page) - expected).mean() < 6)
    page.get_by_text(f"{view_psnr(image, view):.2f} dB").first.wait_for()


def test_the_page_requests_nothing_from_the_internet(training: Training, browser) -> None:
    page = browser
    wait_steps(page, training, 20)
    page.wait_for_load_state("networkidle")
    own = (training.page.address, "data:", "blob:")
    assert not [url for url in page.requested if not url.startswith(own)]
    assert training.page.address.startswith("http://127.0.0.1:")
    assert page.get_by_text("Share").count() == 0
