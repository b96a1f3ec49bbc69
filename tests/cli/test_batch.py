"""The lines of a batch where there is no terminal."""

import pytest

from mobilegs.cli import batch


def test_a_summary_is_printed_after_a_row_and_after_30_quiet_seconds(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(batch.time, "monotonic", lambda: now[0])
    monkeypatch.setenv("FORCE_COLOR", "1")
    events = [
        (0, None, "0 of 2 done after 0:00"),
        (10, None, "0 of 2 done after 0:10"),
        (20, "garden: training", ""),
        (40, None, "0 of 2 done after 0:40"),
        (50, None, "0 of 2 done after 0:50"),
        (60, None, "1 of 2 done after 1:00"),
    ]
    with batch.lines() as (say, summarize):
        for now[0], line, summary in events:
            say(line) if line else summarize(summary)
    printed = capsys.readouterr().out
    assert [line.split(" ", 1)[1] for line in printed.splitlines()] == [
        "0 of 2 done after 0:00",
        "garden: training",
        "0 of 2 done after 0:50",
        "1 of 2 done after 1:00",
    ]
    assert "\x1b" not in printed
