"""The page of the live view: whom it answers, and what browsers may ask."""

import itertools
import json
import threading
import time
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.live.page import FORGET_SECONDS, MODES, VISITORS_MAX, Page
from tests.support.live import Client, Training, wishes
from tests.support.memory_meter import STATUS, MemoryMeter
from tests.support.tiny import cameras


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


FIELDS = ("visitor", "seen", "mode", "viewmat", "focal", "width", "height")
# a valid one for some fields, and for others what programs stumble over
VALUES: list[Any] = [
    *(None, True, False, 0, 1, -1, 0.5, -0.0, 1e-320, 1e308, float("inf"), float("nan"), BIG),
    *(
        1 << 53,
        (1 << 53) + 1,
        "",
        "1",
        "photo",
        "x" * 3000,
        "\u202e\0",
        [],
        [1],
        [[]],
        {},
        {"a": 1},
    ),
]


def chosen() -> list[bytes]:
    """More than 200 messages: each value in each field, and in three places of the matrix."""
    asked = wishes(cameras()[0])
    changes = [{field: value} for field in FIELDS for value in VALUES]
    for place, value in itertools.product((0, 3, 15), VALUES):
        matrix = [*asked["viewmat"][:place], value, *asked["viewmat"][place + 1 :]]
        changes.append({"viewmat": matrix})
    return [json.dumps(asked | change).encode() for change in changes]


@pytest.mark.thorough
def test_a_training_with_a_thousand_random_messages_has_the_same_result(
    dataset: Dataset, tmp_path: Path
) -> None:
    noise, statuses, drawn = np.random.default_rng(0), [], 0
    attacked = Training(dataset, tmp_path / "attacked")
    bodies = [json.dumps(message(noise)).encode() for _ in range(1000)]
    assert len(chosen()) > 200
    attacked.client.post("look", wishes(cameras()[0]))  # what the first frame loads stays
    time.sleep(1)
    before = resident()
    for number, body in enumerate([*bodies, *chosen()]):
        statuses.append(attacked.client.ask("POST", f"{attacked.page.path}look", body)[0])
        if number % 100 == 99:
            drawn += sum(visitor.frames for visitor in attacked.visitors())
    attacked.page.clock = lambda: time.monotonic() + FORGET_SECONDS + 1
    done = attacked.stage.done
    while attacked.stage.done < done + 3:  # the frames are dropped between two steps
        time.sleep(0.01)
    assert not attacked.visitors() and resident() - before < 50e6
    attacked.close()
    steps, scene = attacked.stage.done, attacked.stage.gaussians().tensors()
    assert {*statuses} == {200, 400} and statuses.count(200) > 300 and drawn > 100
    quiet = Training(dataset, tmp_path / "quiet", last=steps)
    quiet.join()
    alone = quiet.stage.gaussians().tensors()
    quiet.close()
    assert all(torch.equal(scene[name], alone[name]) for name in scene)


def resident() -> int:
    """Return the memory of this process in bytes."""
    if not STATUS.exists():
        pytest.skip("needs Linux")
    return MemoryMeter().read("VmRSS")


def test_many_browsers_share_what_one_may_ask(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mobilegs.live.page.LOOKS", 20)
    asked, end = [], time.monotonic() + 1.0

    def visit(visitor: int) -> None:
        while time.monotonic() < end:
            asked.append(Client(page).post("look", wishes(cameras()[0], visitor=visitor))[0])

    visitors = [threading.Thread(target=visit, args=(number,)) for number in range(VISITORS_MAX)]
    for one in visitors:
        one.start()
    for one in visitors:
        one.join()
    assert {*asked} == {200} and VISITORS_MAX <= len(asked) <= 20 + VISITORS_MAX + 1


def test_the_policy_of_the_page_lets_only_its_own_script_run(page: Page) -> None:
    answer = urllib.request.urlopen(f"http://127.0.0.1:{page.server_port}{page.path}")
    policy = answer.headers["Content-Security-Policy"].split("; ")
    assert {"default-src 'none'", "script-src 'self'", "frame-ancestors 'none'"} <= {*policy}


def test_the_page_shows_poses_that_were_refined(dataset: Dataset, page: Page) -> None:
    moved = [replace(frame, camera=moved_right(frame.camera)) for frame in dataset.train]
    page.show(replace(dataset, train=moved))
    photos = json.loads(Client(page).ask("GET", f"{page.path}photos")[1])["photos"]
    assert photos[2]["viewmat"] == moved[2].camera.viewmat.flatten().tolist()
    assert torch.allclose(page.cameras.positions[2].float(), moved[2].camera.position)


def moved_right(camera: Camera) -> Camera:
    viewmat = camera.viewmat.clone()
    viewmat[0, 3] -= 0.5
    return replace(camera, viewmat=viewmat)
