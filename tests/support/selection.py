"""The choice and order of tests, and the last lines, which name the others.

`make test` leaves tests marked `thorough` to `make test-all`, which passes `--thorough`; the mark
`quick` keeps a test of a thorough file. A test that is named by itself (`tests/x.py::test_y`)
always runs. With `--rest` those that passed in the last run without it do not run again.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

# the files that take longest, the longest first: processes take files in this order
LONGEST = Path(__file__).with_name("longest_first.txt").read_text().split()
NEEDS = re.compile(r"(?:Skipped: )?needs (.*)", re.DOTALL)


def few(cases: Iterable[Any], *kept: Any, where: Callable[[Any], bool] | None = None) -> list[Any]:
    """Return cases for `parametrize`, of which `make test` runs only some.

    Those are the `kept` ones, and those for which `where` is true.
    """
    chosen = where or (lambda case: case in kept)
    return [
        case
        if chosen(case)
        else pytest.param(
            *(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.thorough
        )
        for case in cases
    ]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--thorough", action="store_true", help="run the tests marked thorough, too")
    parser.addoption("--rest", action="store_true", help="only what did not pass in the last run")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[LEFT] = Counter()


LEFT = pytest.StashKey[Counter[str]]()  # tests that were left out, by reason
PASSED = "mobilegs/passed"  # in pytest's cache


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave thorough tests out, and put the files that take longest first."""
    named = any("::" in argument for argument in config.args)
    if not config.getoption("--thorough") and not named:
        _leave_out(items, _is_thorough, "are thorough (make test-all)", config)
    if config.getoption("--rest"):
        passed = set(config.cache.get(PASSED, []))  # pyright: ignore[reportOptionalMemberAccess]
        _leave_out(items, lambda item: item.nodeid in passed, "passed before", config)
    root = config.rootpath / "tests"
    places = {root / name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path, len(places)))


def _leave_out(
    items: list[pytest.Item],
    which: Callable[[pytest.Item], bool],
    reason: str,
    config: pytest.Config,
) -> None:
    left = [item for item in items if which(item)]
    items[:] = [item for item in items if not which(item)]
    config.hook.pytest_deselected(items=left)
    config.stash[LEFT][reason] = len(left)


def _is_thorough(item: pytest.Item) -> bool:
    return bool(item.get_closest_marker("thorough") and not item.get_closest_marker("quick"))


def pytest_sessionfinish(session: pytest.Session) -> None:
    if (output := getattr(session.config, "workeroutput", None)) is not None:
        output["left"] = dict(session.config.stash[LEFT])


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Take the count from a process of pytest-xdist; all collect the same tests."""
    if left := getattr(node, "workeroutput", {}).get("left"):
        node.config.stash[LEFT] = Counter(left)


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say how many tests did not run, by what they need."""
    reasons: Counter[str] = Counter()
    for report in terminalreporter.stats.get("skipped", []):
        text = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        found = NEEDS.fullmatch(text.strip())
        reasons[f"need {found[1]}" if found else text.removeprefix("Skipped: ")] += 1
    reasons += config.stash[LEFT]
    cache = getattr(config, "cache", None)  # -p no:cacheprovider
    if cache and not config.getoption("--rest"):
        passed = terminalreporter.stats.get("passed", [])
        cache.set(PASSED, [report.nodeid for report in passed])
    if reasons:
        told = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
        terminalreporter.write_line(f"not run: {told}")
