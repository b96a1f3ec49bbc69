"""Watching a training: what is seen in a browser, and that it changes nothing."""

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
from mobilegs.live import ADDRESS, place, refuse
from mobilegs.live.frame_budget import Pace
from mobilegs.live.frames import (
    Eye,
    Viewpoints,
    decibels,
    error_map,
    fitted,
    side_by_side,
)
from mobilegs.pipeline.train import TrainRun, train_run
from mobilegs.train.progress import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.live.test_frames import eye_of
from tests.pipeline.test_train import RECIPE, finished
from tests.support.browser import Chromium
from tests.support.tiny import CPU, cameras

__all__ = ["finished"]  # a fixture
pytest.importorskip("viser", reason="viser is not installed: pip install 'mobilegs[live]'")

from mobilegs.live.page import BALL, CHOOSE, SHOWN, Page
from mobilegs.live.session import Show

ANYWHERE = "127.0.0.1:0"  # any port that is free


# --- what it does to a training


@pytest.fixture
def pictures(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """What was shown to somebody who sees every step, each in another way."""
    shown: list[np.ndarray] = []
    eye = eye_of(cameras()[1], width=40, height=30)

    def show(page: Page, number: int, picture: np.ndarray) -> None:
        shown.append(picture)
        page.shown = SHOWN[len(shown) % len(SHOWN)]

    monkeypatch.setattr(Page, "show", show)
    monkeypatch.setattr(Page, "eyes", lambda page: {1: eye})
    monkeypatch.setattr(Pace, "allows", lambda pace, *, urgent: True)
    return shown


def test_a_run_that_is_watched_ends_in_the_same_bytes(
    capture: Path, finished: Path, tmp_path: Path, pictures: list[np.ndarray], capfd
) -> None:
    run = TrainRun(capture, tmp_path / "run", live=True, live_at=ANYWHERE)
    train_run(run, recipe=RECIPE)
    assert len(pictures) == RECIPE.teacher.steps + RECIPE.student.steps
    assert all(picture.std() > 1 for picture in pictures)
    for name in ("teacher.ply", "scene.mgs"):
        assert (run.output / name).read_bytes() == (finished / name).read_bytes()
    printed = capfd.readouterr()
    assert "to watch: http://127.0.0.1:" in printed.err
    assert printed.out == ""  # nothing of viser's


def test_a_paused_run_waits_without_work_and_can_be_stopped(
    capture: Path, finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    used: list[float] = []

    def stop() -> None:
        used[0] = time.process_time() - used[0]
        os.kill(os.getpid(), signal.SIGINT)

    def tell(page: Page, rows: dict[str, str]) -> None:
        if not used and rows["student"].startswith("5 "):
            page.pause(True)
            used.append(time.process_time())
            threading.Timer(2.0, stop).start()

    monkeypatch.setattr("mobilegs.live.session.TOLD", 0.0)
    monkeypatch.setattr(Page, "tell", lambda page, rows: "student" in rows and tell(page, rows))
    run = TrainRun(capture, tmp_path / "run", live=True, live_at=ANYWHERE)
    with pytest.raises(KeyboardInterrupt):
        train_run(run, recipe=RECIPE)
    assert used[0] < 0.5
    assert (run.output / "checkpoint.safetensors").exists()
    monkeypatch.undo()
    resumed = replace(run, resume=True, live=False, live_at=ADDRESS)
    metrics = train_run(resumed)
    assert (run.output / "scene.mgs").read_bytes() == (finished / "scene.mgs").read_bytes()
    assert metrics["seconds"]["student"] < 30


def test_time_that_stood_still_does_not_count(dataset: Dataset, tmp_path: Path) -> None:
    stage = Teacher(TeacherConfig(steps=10), dataset, seed=0, device=CPU)
    monitor = Monitor(tmp_path / "journal", [], {}, silent=True)
    monitor.begin(stage)
    monitor.leave_out(50.0)
    assert monitor.elapsed() < 0


# --- what is refused


def test_without_viser_a_sentence_says_what_to_install(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    for verb in (["train", str(capture)], ["demo"], ["compress", str(tmp_path / "scene.ply")]):
        assert main([*verb, "--output", str(tmp_path / "run"), "--live"]) == 2
        said = capsys.readouterr().err
        assert "pip install 'mobilegs[live]'" in said and said.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("live", "address", "said"),
    [
        (False, "0.0.0.0:9000", "give both"),
        (True, "9000", "no HOST:PORT"),
        (True, "127.0.0.1:x", "no HOST:PORT"),
        (True, "127.0.0.1:70000", "no HOST:PORT"),
        (True, "203.0.113.5:9000", "an address of this machine"),
    ],
)
def test_addresses_that_cannot_be_are_refused(live: bool, address: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        refuse(live, address)


def test_several_processes_are_not_watched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WORLD_SIZE", "2")
    with pytest.raises(InputError, match="one process"):
        refuse(True, ADDRESS)


def test_nobody_else_can_watch_unless_asked() -> None:
    assert place(ADDRESS)[0] == "127.0.0.1"


def test_training_that_nobody_watches_does_not_load_viser() -> None:
    code = "import sys, mobilegs.pipeline.train as _; print('viser' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


# --- in the browser


class Watched:
    """A teacher that trains, slowly, in a thread of its own until it is stopped."""

    def __init__(self, dataset: Dataset, folder: Path) -> None:
        fixed = TeacherConfig(steps=1_000_000, densify=DensifyConfig(strategy="fixed"))
        self.stage = Teacher(fixed, dataset, seed=0, device=CPU)
        self.page = Page("127.0.0.1", 0, dataset)
        self.monitor = Monitor(folder / "journal", [], {}, silent=True)
        self.monitor.begin(self.stage)
        self.show = Show(self.page, dataset, self.monitor)
        self.stop = StopRequest()
        self.dataset, self.near = dataset, dataset.near
        self.names = [frame.name for frame in dataset.train]
        self._thread = threading.Thread(target=self._train)
        self._thread.start()

    def close(self) -> None:
        self.stop.asked = True
        self._thread.join()
        self.page.close()

    def _train(self) -> None:
        frames = self.dataset.train
        while not self.stop:
            [index] = view_order(len(frames), self.stage.done, 1, 0)
            self.monitor.after_step(
                self.stage, self.stage.advance([(index, load_view(frames[index]))])
            )
            self.show.between_steps(self.stage, self.stop)
            time.sleep(0.01)


@pytest.fixture
def watched(dataset: Dataset, tmp_path: Path) -> Iterator[Watched]:
    """A training to be watched."""
    made = Watched(dataset, tmp_path)
    yield made
    made.close()


@pytest.fixture
def browser(chromium: Chromium, watched: Watched) -> Iterator[object]:
    """A page that watches, once its camera is where it begins."""
    page = chromium.foreign()
    page.asked = []
    page.on("request", lambda request: page.asked.append(request.url))
    page.goto(watched.page.address)
    start = watched.page.views.positions[0].numpy()
    until(page, lambda: any(np.allclose(eye.position, start, atol=1e-4) for eye in eyes(watched)))
    yield page
    page.close()


def eyes(watched: Watched) -> list[Eye]:
    return list(watched.page.eyes().values())


def until(page, true: Callable[[], bool], seconds: float = 60.0) -> None:
    """Wait until something is true."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it never came to be"
        page.wait_for_timeout(100)


def pose(eye: Eye) -> tuple:
    """Where it is and looks."""
    return eye.position, eye.rotation, eye.fov


def canvas(eye: Eye) -> tuple[int, int]:
    """Its size on the page; viser gives it fewer pixels than that where drawing is slow."""
    return round(600 * eye.width / eye.height), 600


def on_screen(eye: Eye, point: np.ndarray) -> tuple[float, float]:
    """Where a point in the world is on the page, in pixels."""
    width, height = canvas(eye)
    camera = eye.camera(width, height, 0.1)
    x, y, z = camera.viewmat[:3, :3].numpy() @ point + camera.viewmat[:3, 3].numpy()
    focal, _, middle = camera.K[0].tolist()
    return (focal * x / z + middle, focal * y / z + height / 2) if z > 0 else (-1, -1)


def in_sight(eye: Eye, views: Viewpoints) -> list[tuple[int, float, float]]:
    """The cameras whose balls are on the page where nothing lies over them, and where."""
    points = (views.positions - 2 * BALL * views.extent * views.forwards).numpy()
    places = [(index, *on_screen(eye, point)) for index, point in enumerate(points)]
    return [
        (index, x, y) for index, x, y in places if 20 < x < canvas(eye)[0] - 20 and 200 < y < 580
    ]


def pick(page, before: str, after: str) -> None:
    """Choose something else in the list that shows `before`."""
    page.locator(f'input[role=combobox][value="{before}"]').click()
    page.get_by_role("option", name=after, exact=True).click()


def pixels(page) -> np.ndarray:
    """What the browser shows, where neither panel nor notice is."""
    png = page.screenshot()
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), np.float64)[200:, :550]


def test_the_browser_shows_what_training_draws(watched: Watched, browser) -> None:
    page = browser
    page.get_by_role("checkbox", name="Cameras").click(force=True)
    until(page, lambda: not watched.page.with_cameras)
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: watched.page.paused)
    eye = eyes(watched)[0]
    page.wait_for_timeout(500)  # the step in which it was asked for is over
    camera = eye.camera(*canvas(eye), watched.near)
    drawn = to_bytes(watched.stage.scene().render(camera).image).numpy()[200:, :550]
    until(page, lambda: np.abs(pixels(page) - drawn).mean() < 3)


def test_pause_stops_training_and_resume_lets_it_go_on(watched: Watched, browser) -> None:
    page = browser
    page.get_by_role("button", name="Pause").click()
    resume = page.get_by_role("button", name="Resume")
    resume.wait_for()
    page.wait_for_timeout(300)
    done = watched.stage.done
    page.get_by_text(f"{done:,} of 1,000,000").wait_for()  # the figures are those of the step
    assert page.get_by_text("50", exact=False).count()
    page.wait_for_timeout(1000)
    assert watched.stage.done == done
    resume.click()
    until(page, lambda: watched.stage.done > done + 5)


def test_a_picture_for_a_browser_that_has_just_closed_is_dropped(
    watched: Watched, browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = watched.page._server
    watched.stop.asked = True  # nothing else draws, and viser warns once a browser
    [(number, client)] = server.get_clients().items()
    browser.close()
    end = time.monotonic() + 60
    while server.get_clients():
        assert time.monotonic() < end
        time.sleep(0.05)
    monkeypatch.setattr(server, "get_clients", lambda: {number: client})
    watched.page.show(number, np.zeros((4, 4, 3), np.uint8))


def test_the_camera_moves_when_the_user_moves_it_and_never_else(watched: Watched, browser) -> None:
    page = browser
    first = eyes(watched)[0]
    for before, after in pairwise(SHOWN):
        pick(page, before, after)
        until(page, lambda shown=after: watched.page.shown == shown)
    pick(page, SHOWN[-1], SHOWN[0])
    done = watched.stage.done
    until(page, lambda: watched.stage.done > done + 20)
    assert pose(eyes(watched)[0]) == pose(first)
    page.mouse.move(300, 450)
    page.mouse.down()
    page.mouse.move(380, 450, steps=4)
    page.mouse.up()
    until(page, lambda: eyes(watched)[0].position != first.position)
    page.wait_for_timeout(1500)  # it swings out
    moved, done = eyes(watched)[0], watched.stage.done
    until(page, lambda: watched.stage.done > done + 20)
    assert pose(eyes(watched)[0]) == pose(moved)


def test_a_photo_is_where_one_can_go(watched: Watched, browser) -> None:
    page, positions = browser, watched.page.views.positions.numpy()

    def stands_at(index: int) -> Callable[[], bool]:
        return lambda: np.allclose(eyes(watched)[0].position, positions[index], atol=1e-3)

    for _ in range(2):  # the same one again, too
        pick(page, CHOOSE, watched.names[3])
        until(page, stands_at(3))
        page.get_by_role("button", name="Go back to the start").click()
        until(page, stands_at(0))
    others = []
    for start, name in enumerate(watched.names):  # until there is another camera in sight
        pick(page, CHOOSE, name)
        until(page, stands_at(start))
        page.wait_for_timeout(500)  # the angle may come after the place
        others = [o for o in in_sight(eyes(watched)[0], watched.page.views) if o[0] != start]
        if others:
            break
    [(index, x, y), *_] = others
    page.mouse.move(x, y)
    page.wait_for_timeout(500)
    page.mouse.click(x, y)
    until(page, stands_at(index), 20)
    page.get_by_role("button", name="Go to the nearest photo").click()
    page.wait_for_timeout(500)
    assert stands_at(index)()


def test_photo_picture_and_error_are_those_of_the_nearest_photo(watched: Watched, browser) -> None:
    page = browser
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: watched.page.paused)
    pick(page, "picture", "photo | picture | error")
    page.locator("strong", has_text=watched.names[0]).wait_for()
    view = load_view(watched.dataset.train[0])
    image = watched.stage.scene().render(view.camera).image
    width, height = canvas(eyes(watched)[0])
    row = side_by_side([view.image, image, error_map(image, view)], width / height)
    wide = Image.fromarray(to_bytes(fitted(row, width, height)).numpy()).resize((width, height))
    drawn = np.asarray(wide, np.float64)[200:, :550]
    until(page, lambda: np.abs(pixels(page) - drawn).mean() < 6)
    page.get_by_text(f"{decibels(image, view):.2f} dB").first.wait_for()


def test_nothing_is_asked_of_the_internet(watched: Watched, browser) -> None:
    page = browser
    page.wait_for_timeout(1000)
    others = [url for url in page.asked if not url.startswith((watched.page.address, "data:"))]
    assert not [url for url in others if not url.startswith("blob:")]
    assert watched.page.address.startswith("http://127.0.0.1:")
    assert page.get_by_text("Share").count() == 0
