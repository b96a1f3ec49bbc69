"""The phone script: it replays a session of adb, and drives a Chromium of this machine."""

import json
import re
import subprocess
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import bench.phone as phone
from bench.phone import (
    COLUMNS,
    SAMPLE,
    Adb,
    Reading,
    measure,
    parse_reading,
    power_table,
    samples_of,
    units_of,
    watts_of,
)
from bench.phone_schema import FOLDER, measurement_problems
from bench.viewers.chromium import FLAGS, installed
from mobilegs.errors import InputError
from mobilegs.mgs.codec import encode_mgs
from mobilegs.representation.lobes import LobeShape
from tests.support.scene_cases import Case, make_scene

SESSION = Path(__file__).with_name("adb_session.txt")
BLANK_WATTS, DRAWING_WATTS = 0.21 * 4.0, 0.46 * 3.9


def session() -> dict[str, list[str]]:
    """Return the outputs of each command of the stored session, in order."""
    found: dict[str, list[str]] = {}
    for block in SESSION.read_text().split("$ adb ")[1:]:
        command, _, output = block.partition("\n")
        found.setdefault(command, []).append(output)
    return found


class Replay(Adb):
    """adb of the stored session.

    Attributes:
        chrome_port: where Chrome's DevTools answer.
        drawing: whether a scene is being measured.
        commands: those that were run.
    """

    def __init__(self, answers: dict[str, list[str]], chrome_port: int = 0) -> None:
        super().__init__()
        self.answers, self.chrome_port = answers, chrome_port
        self.drawing = False
        self.commands: list[str] = []

    def execute(self, arguments: tuple[str, ...]) -> tuple[int, str]:
        words = " ".join(arguments).replace(SAMPLE, "SAMPLE")
        self.commands.append(words)
        outputs = self.answers[re.sub(r"tcp:[1-9]\d*", "tcp:PORT", words)]
        text = outputs[-1 if self.drawing else 0]
        return 0, text.replace("PORT", str(self.chrome_port))


@pytest.fixture
def chrome_port(tmp_path: Path) -> Iterator[int]:
    """The DevTools port of a Chromium without a window, in the place of the phone's Chrome."""
    program = installed()
    if program is None:
        pytest.skip("needs Chromium (make drivers)")
    profile = tmp_path / "profile"
    words = [program, *FLAGS, "--remote-debugging-port=0", f"--user-data-dir={profile}"]
    browser = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    told = profile / "DevToolsActivePort"
    while not (told.exists() and told.read_text().strip()):
        assert browser.poll() is None, "Chromium ended"
        time.sleep(0.05)
    yield int(told.read_text().split()[0])
    browser.terminate()
    browser.wait(60)


@pytest.mark.thorough
def test_a_measurement_has_frames_and_power_of_each_scene(
    chrome_port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lobes = make_scene(Case(300, LobeShape(1, 2)))
    plain = replace(make_scene(Case(300, None)), blend="sorted")
    scenes = [tmp_path / "lobes.mgs", tmp_path / "sorted.mgs"]
    for scene, content in zip(scenes, (lobes, plain), strict=True):
        scene.write_bytes(encode_mgs(content))
    adb = Replay(session(), chrome_port)
    adb.select(None)
    bench = phone.bench

    def drawing(*given: Any) -> Any:
        adb.drawing = True
        try:
            return bench(*given)
        finally:
            adb.drawing = False

    monkeypatch.setattr(phone, "bench", drawing)
    found = measure(adb, scenes, 2, "64x48")
    assert measurement_problems(found) == []
    assert found["phone"] == {
        "manufacturer": "Example",
        "model": "Phone 1 (test)",
        "android": "15",
        "soc": "SM0000",
    }
    assert [file["kind"] for file in found["files"]] == ["lobes", "sorted"]
    assert [scene["sorted"] for scene in found["report"]["scenes"]] == [False, True]
    power = found["power"]
    assert (power["current_unit"], power["discharging_sign"]) == ("microampere", -1)
    assert power["blank"]["watts"] == pytest.approx(BLANK_WATTS)
    for measured, scene in zip(power["scenes"], found["report"]["scenes"], strict=True):
        assert measured["net_watts"] == pytest.approx(DRAWING_WATTS - BLANK_WATTS)
        per_frame = 1000 * measured["net_watts"] / scene["whole"]["fps"]
        assert measured["millijoules_per_frame"] == pytest.approx(per_frame, rel=0.01)
    # settings, ports and the brightness mode that had no value are as before
    unused = set(adb.answers) - {re.sub(r"tcp:[1-9]\d*", "tcp:PORT", word) for word in adb.commands}
    assert not unused


def test_power_is_shared_by_the_time_of_the_passes() -> None:
    passes = {"network": 2.0, "project": 1.0, "splat": 4.0, "resolve": 1.0}
    table = power_table({"whole": {"passes": passes, "order": None}}, net=0.8)
    assert table is not None and set(table) == {*COLUMNS, "other"}
    assert table["mlp"] == {"milliseconds": 2.0, "watts": 0.2}
    assert table["preprocessing"] == {"milliseconds": 1.0, "watts": 0.1}
    assert table["rasterization"] == {"milliseconds": 5.0, "watts": 0.5}
    assert table["sorting"] == {"milliseconds": None, "watts": None}
    sorted_table = power_table({"whole": {"passes": {"splat": 3.0}, "order": 1.0}}, net=0.8)
    assert sorted_table is not None and sorted_table["sorting"]["watts"] == 0.2
    assert power_table({"whole": {"passes": None, "order": 1.0}}, net=0.8) is None


def reading(current: int, voltage: int | None = 4_000_000, dumped: int = 4000) -> Reading:
    return Reading(0.0, current, voltage, dumped, 28.0)


@pytest.mark.parametrize(
    ("current", "voltage", "unit", "sign", "watts"),
    [
        (-210_000, 4_000_000, "microampere", -1, 0.84),
        (210_000, 4000, "microampere", 1, 0.84),
        (-210, 4_000_000, "milliampere", -1, 0.84),
        (5_000, None, "milliampere", 1, 20.0),
    ],
)
def test_units_are_decided_by_magnitude(
    current: int, voltage: int | None, unit: str, sign: int, watts: float
) -> None:
    readings = [reading(current, voltage), reading(current, voltage)]
    units = units_of(readings)
    assert (units.current, units.sign) == (unit, sign)
    assert units.voltage == ("dumpsys" if voltage is None else "voltage_now")
    assert watts_of(samples_of(readings, units)) == pytest.approx(watts)


def test_readings_of_a_charged_phone_are_refused() -> None:
    text = session()["-s 192.168.1.30:5555 shell SAMPLE"][0]
    found = parse_reading(text, 1.5)
    assert found == Reading(1.5, -210_000, 4_000_000, 3998, 28.1)
    for old, new, sentence in (
        ("USB powered: false", "USB powered: true", "powered by USB"),
        (
            "Current Battery",
            "(UPDATES STOPPED -- use 'reset' to restart)\nCurrent Battery",
            "reset",
        ),
        (f"{phone.BATTERY}/current_now:-210000\n", "", "may not read"),
        ("  voltage: 3998\n", "", "no voltage"),
    ):
        assert old in text
        with pytest.raises(InputError, match=sentence):
            parse_reading(text.replace(old, new), 0.0)
    for currents, sentence in (((0, 0), "is 0"), ((-9, 9), "sign")):
        with pytest.raises(InputError, match=sentence):
            units_of([reading(current) for current in currents])
    with pytest.raises(InputError, match="no phone has"):
        samples_of([reading(-210_000, 100)], units_of([reading(-210_000)]))


@pytest.mark.parametrize(
    ("rows", "serial", "sentence"),
    [
        ("", None, "sees no phone"),
        ("a\tdevice\nb\tdevice\n", None, "several phones .a, b."),
        ("a\tdevice\n", "c", "no phone c"),
        ("a\tunauthorized\n", None, "does not trust this computer"),
        ("a\toffline\n", None, "'offline'"),
    ],
)
def test_a_phone_that_cannot_be_selected_is_named(
    rows: str, serial: str | None, sentence: str
) -> None:
    adb = Replay({"devices": [f"List of devices attached\n{rows}\n"]})
    with pytest.raises(InputError, match=sentence):
        adb.select(serial)


def test_without_adb_the_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sys.argv", ["phone", str(tmp_path / "scene.mgs")])
    with pytest.raises(SystemExit) as end:
        phone.main()
    said = capsys.readouterr().err
    assert end.value.code == 2 and "platform tools" in said and said.count("\n") == 1


def test_a_phone_without_chrome_is_refused() -> None:
    answers = session()
    answers["-s 192.168.1.30:5555 shell pm list packages com.android.chrome"] = [""]
    adb = Replay(answers)
    adb.select(None)
    with pytest.raises(InputError, match="no Chrome"), phone.chrome(adb):
        pass


def test_every_stored_measurement_is_valid() -> None:
    files = sorted((FOLDER / "measurements").iterdir())
    assert {path.suffix for path in files} <= {".json", ".md"} and files
    for path in files:
        if path.suffix == ".md":
            continue
        assert measurement_problems(json.loads(path.read_text())) == [], path


def test_missing_packages_are_named_before_anything_is_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(phone, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="jsonschema, websockets is not installed: pip install"):
        phone.require_packages()
