"""The live view of a training: frames in a browser, and no influence on the result."""

import io
import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

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
from mobilegs.live.page import FORGET_SECONDS, MODES, Page, Visitor
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
from mobilegs.progress_display import printed_log
from mobilegs.train.monitor import Monitor
from mobilegs.train.recipes import with_settings
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.browser import Chromium
from tests.support.live import Training, browser_at, wishes
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


# --- several browsers, and photos


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


def test_a_pause_that_nobody_watches_is_said_once(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    training = Training(dataset, tmp_path)
    said: list[str] = []
    monkeypatch.setattr(training.monitor, "note", said.append)
    try:
        end = time.monotonic() + 60
        training.page.look(wishes(cameras()[0]))
        training.page.pause(True)
        while not training.changed.waits and time.monotonic() < end:
            time.sleep(0.01)
        assert not said
        training.page.clock = lambda: time.monotonic() + FORGET_SECONDS + 1
        while not said and time.monotonic() < end:
            time.sleep(0.01)
        waits = training.changed.waits
        while training.changed.waits < waits + 3:
            time.sleep(0.01)
        assert len(said) == 1 and training.page.address in said[0]
    finally:
        training.close()


def test_large_photos_are_reduced(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mobilegs.live.session.PIXELS_MAX", 200)  # of 24 x 24
    training = Training(dataset, tmp_path)
    try:
        for mode, shape in (("photo", (12, 12, 3)), ("photo | render | error", (12, 48, 3))):
            image, said = training.live._photo_image(training.stage.scene(), mode, 0, 9.0)
            assert image.shape == shape and "reduced" in said[training.names[0]]
    finally:
        training.close()


@pytest.mark.thorough
def test_photos_are_seen_from_their_refined_poses(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Dataset] = []
    monkeypatch.setattr(Page, "show", lambda page, dataset: shown.append(dataset))
    recipe = with_settings(RECIPE, ["teacher.pose.learned=true"])
    run = TrainRun(capture, tmp_path / "run", live=True, live_at=FREE_PORT)
    train_capture(run, recipe=recipe)
    poses = json.loads((run.output / "poses.json").read_text("utf-8"))["train"]
    before, after = shown
    for first, frame in zip(before.train, after.train, strict=True):
        assert frame.camera.viewmat.tolist() == poses[frame.name]
        assert not torch.equal(first.camera.viewmat, frame.camera.viewmat)


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
        until(browser, lambda: is_at(training, places[3]))
        browser.get_by_role("button", name="Go back to the start").click()
        until(browser, lambda: is_at(training, places[0]))
    browser.mouse.move(300, 450)
    browser.mouse.wheel(0, 300)
    until(browser, lambda: not is_at(training, places[0]))
    browser.wait_for_timeout(1000)  # until the page knows what is nearest
    browser.get_by_role("button", name="Go to the nearest photo").click()
    nearest = training.page.cameras.nearest(training.visitors()[0].camera)
    until(browser, lambda: is_at(training, places[nearest]))


def test_the_lists_work_by_keyboard(training: Training, browser: Any) -> None:
    modes, photos = browser.get_by_label("Show"), browser.get_by_label("Go to photo")
    modes.focus()
    for mode in MODES[1:3]:
        browser.keyboard.press("ArrowDown")
        until(browser, lambda mode=mode: training.visitors()[0].mode == mode)
    photos.focus()
    places = training.page.cameras.positions
    for index in range(4):
        browser.keyboard.press("ArrowDown")
        until(browser, lambda index=index: is_at(training, places[index]))
    assert photos.evaluate("(list) => list.selectedIndex") == 4
    browser.get_by_label("the scene in training").focus()
    browser.keyboard.press("ArrowLeft")  # the camera leaves the photo
    until(browser, lambda: not is_at(training, places[3]))
    assert photos.evaluate("(list) => list.selectedIndex") == 0


def is_at(training: Training, place: torch.Tensor) -> bool:
    """Return True if the browser's camera is at a place."""
    return bool(torch.allclose(training.visitors()[0].camera.position, place, atol=1e-3))


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
    name = "<img src=x onerror=window.attacked=1>\u202e.png"
    shown = name.replace("\u202e", r"\u202e")
    named = replace(dataset, name=name, train=[replace(f, name=name) for f in dataset.train])
    training, page, requested = Training(named, tmp_path), chromium.foreign(), []
    try:
        page.on("request", lambda request: requested.append(request.url))
        page.goto(training.page.address)
        page.get_by_label("Show").select_option("photo")
        page.locator("dt", has_text=shown).wait_for()
        page.wait_for_timeout(300)
        assert page.evaluate("window.attacked") is None and shown in page.title()
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
