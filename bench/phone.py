"""Measure frame rate and power of scenes in Chrome on an Android phone, through adb.

    python -m bench.phone A.mgs [B.mgs ...] [--seconds 60] [--size 1600x1063] [--serial SERIAL]
        [--output FILE.json] [--record FILE.txt]

The phone must not be charged: connect adb by Wi-Fi and unplug the cable (docs/guides/phone.md).
The script serves the scenes to the phone, opens each in Chrome with `?bench`, and reads the
battery's current and voltage once a second. It does the same with a blank page first, and subtracts
that power. It waits for the battery to cool between runs. The power table has the columns of the
paper's. Nothing measures a pass alone: net power is shared in proportion to the time of each pass.
Time of the CPU (sorting) and of the GPU count the same.
"""

import argparse
import hashlib
import itertools
import json
import re
import statistics
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import quote

from bench.phone_schema import FOLDER, measurement_problems
from mobilegs.atomic import atomic_write
from mobilegs.errors import InputError
from mobilegs.mgs.codec import read_mgs
from mobilegs.view.serve import Server

ATTRIBUTION = "net power, shared in proportion to the time of each pass"
# the paper's columns, and the passes of the viewer that belong to them; sorting is on the CPU
COLUMNS = {
    "preprocessing": ("project",),
    "sorting": ("order",),
    "mlp": ("network",),
    "rasterization": ("splat", "resolve"),
}
CHROME = "com.android.chrome"
ACTIVITY = f"{CHROME}/com.google.android.apps.chrome.Main"
BATTERY = "/sys/class/power_supply/battery"
SAMPLE = f"grep -s . {BATTERY}/current_now {BATTERY}/voltage_now; dumpsys battery"
PROPERTIES = (
    "ro.product.manufacturer",
    "ro.product.model",
    "ro.build.version.release",
    "ro.soc.model",
)
# a phone with its screen on draws 0.05 to 5 A: 50 to 5,000 mA, 50,000 to 5,000,000 uA
MILLIAMPERES_BELOW = 10_000
# of one or two cells: 3,000 to 9,000 mV, 3,000,000 to 9,000,000 uV
MILLIVOLTS_BELOW = 100_000
SCREEN = {"screen_off_timeout": "2147483647", "screen_brightness_mode": "0"}
PATIENCE = 30  # seconds for one command of adb, and for Chrome to start
LOADING = 300  # seconds for a scene to load, on top of the measurement
WARMER = 1.0  # degrees above the first reading at which the next run may start
COOLING = 600  # seconds
LISTEN = """
addEventListener("report", ({ detail }) => (window.benchReport = detail), true);
addEventListener("error", ({ detail }) => (window.benchError = detail?.sentence), true);
"""
STATE = """({
  report: window.benchReport ?? null,
  error: window.benchError ?? null,
  measured: Boolean(document.querySelector("mobile-gs")?.viewer?.measured),
})"""


class Adb:
    """Runs adb commands on one phone, and records them if `record` is given."""

    def __init__(self, record: Path | None = None) -> None:
        self.serial = ""
        self._record = record
        if record:
            record.write_text("")

    def execute(self, arguments: tuple[str, ...]) -> tuple[int, str]:
        """Run adb; return the exit code and what it printed."""
        try:
            done = subprocess.run(
                ["adb", *arguments],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                timeout=PATIENCE,
            )
        except FileNotFoundError:
            raise InputError(
                "adb is not installed: install Android's platform tools (apt-get install adb)"
            ) from None
        except subprocess.TimeoutExpired:
            raise InputError(
                f"adb {' '.join(arguments)} took more than {PATIENCE} s: reconnect the phone"
            ) from None
        return done.returncode, done.stdout

    def run(self, *arguments: str) -> str:
        """Run adb on the selected phone; return what it printed.

        Raises InputError if adb is missing, does not answer, or fails.
        """
        if self.serial:
            arguments = ("-s", self.serial, *arguments)
        code, text = self.execute(arguments)
        if self._record:
            with self._record.open("a") as file:
                end = f"[exit {code}]\n" if code else ""
                file.write(f"$ adb {' '.join(arguments)}\n{text.rstrip()}\n{end}")
        if code:
            said = text.strip().splitlines()[-1:] or [f"exit code {code}"]
            raise InputError(f"adb {' '.join(arguments)} failed: {said[0]}")
        return text

    def shell(self, command: str) -> str:
        """Run a command on the phone; return what it printed. Raises InputError as `run` does."""
        return self.run("shell", command)

    def select(self, serial: str | None) -> None:
        """Select the phone: the one with this serial number, else the only one.

        Raises InputError if there is none, if there are several, or if it refuses adb.
        """
        rows = re.findall(r"^([^\s*]\S*)\t(.+)$", self.run("devices"), re.MULTILINE)
        phones = {name: state.strip() for name, state in rows}
        if serial is not None and serial not in phones:
            known = ", ".join(phones) or "none"
            raise InputError(f"adb sees no phone {serial} (it sees {known}): connect it")
        if not phones:
            raise InputError(
                "adb sees no phone: connect it, and allow USB debugging in its developer options"
            )
        if serial is None and len(phones) > 1:
            raise InputError(f"adb sees several phones ({', '.join(phones)}): give --serial")
        name = serial if serial is not None else next(iter(phones))
        if phones[name] == "unauthorized":
            raise InputError(
                f"{name} does not trust this computer: unlock it and allow USB debugging there"
            )
        if phones[name] != "device":
            raise InputError(f"adb cannot use {name}: its state is {phones[name]!r}; reconnect it")
        self.serial = name


@dataclass(frozen=True)
class Reading:
    """The battery at one moment, in the phone's own units.

    Attributes:
        second: seconds since the run began.
        current: `current_now`; its unit and sign differ between phones.
        voltage: `voltage_now`, microvolts or millivolts; None where adb may not read it.
        dumped: voltage as Android's battery service prints it, updated less often.
        celsius: temperature of the battery.
    """

    second: float
    current: int
    voltage: int | None
    dumped: int
    celsius: float


def parse_reading(text: str, second: float) -> Reading:
    """Return the reading that `SAMPLE` printed.

    Raises InputError if the phone is charged or pretends not to be, or hides its current.
    """
    files = dict(re.findall(rf"^{BATTERY}/(\w+):(-?\d+)\s*$", text, re.MULTILINE))
    fields = dict(re.findall(r"^\s+([\w ]+): (\S+)\s*$", text, re.MULTILINE))
    if "UPDATES STOPPED" in text:
        raise InputError(
            "the battery's state on the phone is a made-up one: run "
            "`adb shell dumpsys battery reset`"
        )
    sources = [name for name, value in fields.items() if name.endswith(" powered")]
    charging = [name.removesuffix(" powered") for name in sources if fields[name] == "true"]
    if charging:
        raise InputError(
            f"the phone is powered by {charging[0]}, so its battery does not deliver what it "
            "draws: connect adb by Wi-Fi (adb tcpip 5555, adb connect ADDRESS:5555) and unplug it"
        )
    if not sources or "voltage" not in fields or "temperature" not in fields:
        raise InputError("`dumpsys battery` on the phone prints no power source or no voltage")
    if "current_now" not in files:
        raise InputError(
            f"adb may not read {BATTERY}/current_now on this phone: its power cannot be measured"
        )
    voltage = int(files["voltage_now"]) if "voltage_now" in files else None
    celsius = int(fields["temperature"]) / 10
    return Reading(second, int(files["current_now"]), voltage, int(fields["voltage"]), celsius)


@dataclass(frozen=True)
class Units:
    """Units of a phone's readings, decided by their magnitude.

    Attributes:
        current: `microampere`, as the kernel's interface says, or `milliampere`.
        sign: of a discharging current; phones differ.
        voltage: `voltage_now`, or `dumpsys` where adb may not read the former.
    """

    current: str
    sign: int
    voltage: str


def units_of(readings: list[Reading]) -> Units:
    """Return the units of all readings of a measurement.

    Raises InputError if the current is 0 or changes its sign: the phone was not only discharging.
    """
    currents = [reading.current for reading in readings]
    median = statistics.median(map(abs, currents))
    if not median:
        raise InputError("the phone says that its battery's current is 0: it cannot be measured")
    if min(currents) < 0 < max(currents):
        raise InputError(
            "the battery's current changed its sign, so the phone was charged meanwhile: unplug it"
        )
    current = "milliampere" if median < MILLIAMPERES_BELOW else "microampere"
    voltage = "dumpsys" if any(one.voltage is None for one in readings) else "voltage_now"
    return Units(current, -1 if min(currents) < 0 else 1, voltage)


def samples_of(readings: list[Reading], units: Units) -> list[dict[str, float]]:
    """Return readings in amperes, volts and degrees Celsius.

    Raises InputError for a voltage that no phone's battery has.
    """
    samples = []
    for one in readings:
        voltage = one.voltage if units.voltage == "voltage_now" else one.dumped
        assert voltage is not None
        volts = voltage / (1e3 if voltage < MILLIVOLTS_BELOW else 1e6)
        if not 2 < volts < 10:
            raise InputError(f"the phone says that its battery has {volts} V: no phone has that")
        amperes = abs(one.current) / (1e3 if units.current == "milliampere" else 1e6)
        sample = {"second": one.second, "amperes": amperes, "volts": volts, "celsius": one.celsius}
        samples.append({name: round(value, 6) for name, value in sample.items()})
    return samples


def watts_of(samples: list[dict[str, float]]) -> float:
    """Return the mean power of samples."""
    return statistics.fmean(sample["amperes"] * sample["volts"] for sample in samples)


def power_table(scene: dict[str, Any], net: float) -> dict[str, Any] | None:
    """Return milliseconds and watts of each column for a scene of the report.

    `other` has the passes that belong to no column. None if the phone has no timer for passes.
    """
    rate = scene["whole"]
    if rate["passes"] is None:
        return None
    times = {**rate["passes"], "order": rate["order"]}
    times = {name: took for name, took in times.items() if took is not None}
    total = sum(times.values())
    own = set(itertools.chain(*COLUMNS.values()))
    columns = {**COLUMNS, "other": tuple(name for name in times if name not in own)}
    table = {}
    for column, passes in columns.items():
        found = [times[name] for name in passes if name in times]
        watts = round(net * sum(found) / total, 4) if found and total else None
        table[column] = {"milliseconds": round(sum(found), 3) if found else None, "watts": watts}
    return table


class ChromeTab:
    """A new tab of Chrome, driven by the DevTools protocol at a port of this machine.

    It speaks to the tab alone: Chrome on Android lacks the commands for the browser as a whole that
    Playwright needs.
    """

    def __init__(self, port: int) -> None:
        from websockets.exceptions import WebSocketException
        from websockets.sync.client import connect

        self._failures = (OSError, WebSocketException)
        self._base = f"http://127.0.0.1:{port}/json"
        request = urllib.request.Request(f"{self._base}/new?about:blank", method="PUT")
        end = time.monotonic() + PATIENCE
        while True:
            try:
                with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
                    self._id = json.load(answer)["id"]
                break
            except (OSError, ValueError, KeyError):
                if time.monotonic() > end:
                    raise InputError(
                        "Chrome on the phone does not answer: unlock the phone and open Chrome"
                    ) from None
                time.sleep(0.5)
        address = f"ws://127.0.0.1:{port}/devtools/page/{self._id}"
        try:
            self._socket = connect(address, max_size=None)
        except self._failures as error:
            raise InputError(f"Chrome on the phone refuses DevTools: {error}") from None
        self._numbers = itertools.count(1)
        self.send("Page.enable")
        self.send("Page.addScriptToEvaluateOnNewDocument", source=LISTEN)

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result.

        Raises InputError if Chrome refuses it or the connection breaks.
        """
        number = next(self._numbers)
        try:
            message = {"id": number, "method": method, "params": parameters}
            self._socket.send(json.dumps(message))
            while (answer := json.loads(self._socket.recv(PATIENCE))).get("id") != number:
                pass  # events
        except self._failures as error:
            raise InputError(f"the connection to Chrome on the phone broke: {error}") from None
        if "error" in answer:
            raise InputError(f"Chrome refuses {method}: {answer['error']['message']}")
        return answer["result"]

    def open(self, address: str) -> None:
        """Go to an address; raises InputError if it cannot be reached."""
        failed = self.send("Page.navigate", url=address).get("errorText")
        if failed:
            raise InputError(f"Chrome on the phone cannot open {address}: {failed}")

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression."""
        found = self.send("Runtime.evaluate", expression=expression, returnByValue=True)
        return found["result"].get("value")

    def close(self) -> None:
        """Close the tab."""
        self._socket.close()
        with urllib.request.urlopen(f"{self._base}/close/{self._id}", timeout=PATIENCE):
            pass


class Meter:
    """Reads the battery once a second.

    Attributes:
        readings: of all runs.
    """

    def __init__(self, adb: Adb) -> None:
        self._adb = adb
        self.readings: list[Reading] = []

    def read(self, began: float) -> Reading:
        """Return a reading; `began` is the run's start by `time.monotonic`."""
        text = self._adb.shell(SAMPLE)
        return parse_reading(text, round(time.monotonic() - began, 2))

    def watch(self, state: Callable[[float], bool | None]) -> list[Reading]:
        """Return readings while `state` is True, once a second; end when it is None.

        `state` takes the seconds since the call. A reading counts if it is True before and after.
        """
        found: list[Reading] = []
        began = time.monotonic()
        now = state(0)
        for turn in itertools.count(1):
            if now is None:
                break
            before, reading = now, self.read(began)
            now = state(time.monotonic() - began)
            if before and now:
                found.append(reading)
            time.sleep(max(0, began + turn - time.monotonic()))
        self.readings += found
        return found

    def cool(self, celsius: float) -> None:
        """Wait until the battery is at most `WARMER` above a temperature, at most `COOLING` s."""
        began = time.monotonic()
        while (now := self.read(began).celsius) > celsius + WARMER:
            if time.monotonic() - began > COOLING:
                print(f"the battery is still at {now} C: the measurement goes on")
                return
            time.sleep(5)


def file_entry(scene: Path) -> dict[str, Any]:
    """Return kind, bytes, SHA-256 and number of Gaussians of a `.mgs`.

    The kind is `network` (evaluated per Gaussian and frame), `lobes` (opacity and phi as spherical
    harmonics), `sorted`, or `plain`: sort-free, without view dependence.
    """
    quantized = read_mgs(scene)
    if quantized.blend == "sorted":
        kind = "sorted"
    elif quantized.network is not None:
        kind = "network"
    else:
        kind = "lobes" if quantized.lobe_shape else "plain"
    content = scene.read_bytes()
    return {
        "kind": kind,
        "bytes": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
        "gaussians": len(quantized),
    }


def describe(adb: Adb) -> dict[str, Any]:
    """Return manufacturer, model, Android version and processor."""
    lines = adb.shell("; ".join(f"getprop {name}" for name in PROPERTIES)).splitlines()
    values = [line.strip() for line in lines] + [""] * len(PROPERTIES)
    names = ("manufacturer", "model", "android", "soc")
    found = dict(zip(names, values, strict=False))
    return {**found, "soc": found["soc"] or None}


@contextmanager
def screen_kept_on(adb: Adb) -> Iterator[None]:
    """Keep the screen on, at its brightness; restore the phone's settings at the end."""
    before = {name: adb.shell(f"settings get system {name}").strip() for name in SCREEN}
    try:
        for name, value in SCREEN.items():
            adb.shell(f"settings put system {name} {value}")
        yield
    finally:
        for name, value in before.items():
            restore = f"put system {name} {value}"
            adb.shell(f"settings {f'delete system {name}' if value == 'null' else restore}")


@contextmanager
def served(adb: Adb, scenes: list[Path]) -> Iterator[list[str]]:
    """Serve scenes to the phone, at its own localhost; yields their pages, without options."""
    with Server(scenes[0]) as server:
        server.scenes = {f"/scene/{i}/{scene.name}": scene for i, scene in enumerate(scenes)}
        threading.Thread(target=server.serve_forever, daemon=True).start()
        port = f"tcp:{server.server_port}"
        adb.run("reverse", port, port)
        try:
            base = f"http://127.0.0.1:{server.server_port}/?url="
            yield [base + quote(path) for path in server.scenes]
        finally:
            adb.run("reverse", "--remove", port)
            server.shutdown()


@contextmanager
def chrome(adb: Adb) -> Iterator[ChromeTab]:
    """Open a tab in Chrome on the phone; raises InputError if there is no Chrome."""
    if f"package:{CHROME}" not in adb.shell(f"pm list packages {CHROME}").split():
        raise InputError("the phone has no Chrome: install it")
    adb.shell(f"am start -n {ACTIVITY} -a android.intent.action.VIEW -d about:blank")
    port = adb.run("forward", "tcp:0", "localabstract:chrome_devtools_remote").strip()
    try:
        tab = ChromeTab(int(port))
        try:
            yield tab
        finally:
            tab.close()
    finally:
        adb.run("forward", "--remove", f"tcp:{port}")


def bench(tab: ChromeTab, meter: Meter, page: str, plan: str, seconds: int) -> Any:
    """Run `?bench` on one page; return its report and the readings.

    Raises InputError if the page shows an error, is hidden, or does not finish.
    """
    tab.open(f"{page}&bench={plan}")
    state: dict[str, Any] = {}

    def now(elapsed: float) -> bool | None:
        state.update(tab.evaluate(STATE) or {})
        if state["error"]:
            raise InputError(f"the viewer on the phone says: {state['error']}")
        if elapsed > seconds + LOADING:
            raise InputError(
                "the viewer on the phone did not finish: unlock the phone and watch it"
            )
        return None if state["report"] else state["measured"]

    readings = meter.watch(now)
    report = state["report"]
    if report["scenes"][0]["interrupted"]:
        raise InputError("the page was hidden while it was measured: keep Chrome in front")
    if not readings:
        raise InputError(f"the battery was not read during {seconds} s: give more --seconds")
    return report, readings


def measure(adb: Adb, scenes: list[Path], seconds: int, size: str | None) -> dict[str, Any]:
    """Measure scenes on the selected phone; return the measurement.

    Raises InputError if the phone is charged, hides its battery's current, or Chrome fails.
    """
    plan = f"{seconds},{size}" if size else str(seconds)
    files = [{"name": scene.name, **file_entry(scene)} for scene in scenes]
    meter = Meter(adb)
    first = meter.read(time.monotonic()).celsius  # also refuses phones that are charged
    phone = describe(adb)
    reports, runs = [], []
    with screen_kept_on(adb), served(adb, scenes) as pages, chrome(adb) as tab:
        print(f"{phone['manufacturer']} {phone['model']}: a blank page, {seconds} s")
        blank = meter.watch(lambda elapsed: True if elapsed < seconds + 1 else None)
        for scene, page in zip(scenes, pages, strict=True):
            meter.cool(first)
            print(f"{scene}: {seconds} s", flush=True)
            report, readings = bench(tab, meter, page, plan, seconds)
            tab.open("about:blank")
            reports.append(report)
            runs.append(readings)
    units = units_of(meter.readings)
    base = samples_of(blank, units)
    measured = {**reports[0], "scenes": [report["scenes"][0] for report in reports]}
    power: dict[str, Any] = {
        "current_unit": units.current,
        "discharging_sign": units.sign,
        "voltage_from": units.voltage,
        "attribution": ATTRIBUTION,
        "blank": {"watts": round(watts_of(base), 4), "samples": base},
        "scenes": [],
    }
    for scene, readings in zip(measured["scenes"], runs, strict=True):
        samples = samples_of(readings, units)
        watts = watts_of(samples)
        net = watts - watts_of(base)
        power["scenes"].append(
            {
                "watts": round(watts, 4),
                "net_watts": round(net, 4),
                "millijoules_per_frame": round(1000 * net / scene["whole"]["fps"], 4),
                "table": power_table(scene, net),
                "samples": samples,
            }
        )
    found = {"format": 1, "phone": phone, "files": files, "report": measured, "power": power}
    return found


def require_packages() -> None:
    """Raise InputError if a package that is needed at the end is missing."""
    missing = [name for name in ("jsonschema", "websockets") if find_spec(name) is None]
    if missing:
        raise InputError(f"{', '.join(missing)} is not installed: pip install 'mobilegs[bench]'")


def main() -> None:
    """Measure scenes on a phone and write the measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", type=Path, nargs="+", metavar="SCENE.mgs")
    parser.add_argument("--seconds", type=int, default=60, help="of each run, 2 or more")
    parser.add_argument("--size", default=None, help="pixels, such as 1600x1063; else the screen's")
    parser.add_argument("--serial", default=None, help="of the phone, if there are several")
    parser.add_argument(
        "--output", type=Path, default=None, help="default: MEASUREMENTS/MODEL.json"
    )
    parser.add_argument(
        "--record", type=Path, default=None, help="write adb's answers to this file"
    )
    options = parser.parse_args()
    if options.seconds < 2 or not re.fullmatch(r"\d+x\d+", options.size or "1x1"):
        parser.error("--seconds must be 2 or more, and --size like 1600x1063")
    try:
        require_packages()
        adb = Adb(options.record)
        adb.select(options.serial)
        found = measure(adb, options.scenes, options.seconds, options.size)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    model = re.sub(r"\W+", "-", found["phone"]["model"].lower()).strip("-")
    name = f"{model}-{date.today().isoformat()}.json"
    output = options.output or FOLDER / "measurements" / name
    atomic_write(output, json.dumps(found, indent=1) + "\n")
    for file, one in zip(found["files"], found["power"]["scenes"], strict=True):
        print(f"{file['name']}: {one['net_watts']:.2f} W above a blank page")
    print(f"written to {output}")
    wrong = measurement_problems(found)
    if wrong:
        print(f"error: {output} does not fit its schema: {wrong[0]}", file=sys.stderr)
        raise SystemExit(1)


if __name__ == "__main__":
    main()
