"""Help and parsing of options."""

import re
from dataclasses import dataclass
from typing import Literal

import pytest

from mobilegs.cli.main import VERBS, main
from mobilegs.cli.options import call


@dataclass(frozen=True)
class Example:
    """An example.

    A second paragraph.
    """

    count: int
    """Number of things."""
    kind: Literal["small", "large"] | None = None
    """Kind of
    things. Default: chosen from the count."""
    seed: int = 0
    """Seed."""
    loud: bool = False
    """Print more."""


def help_of(verb: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as caught:
        main([verb, "--help"])
    assert caught.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("verb", list(VERBS))
def test_help_fits_the_terminal_and_gives_defaults_in_words(
    verb: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    text = help_of(verb, capsys)
    lines = [line for line in text.splitlines() if not line.startswith("usage:")]
    assert max(map(len, lines)) <= 80
    assert not re.search(r"None|False|default: ''", text)


@pytest.mark.parametrize("verb", ["train", "compress"])
def test_long_help_separates_common_and_expert_options(
    verb: str, capsys: pytest.CaptureFixture[str]
) -> None:
    _, common, expert = re.split("common options|expert options", help_of(verb, capsys))
    assert "--preset" in common and "--resume" in common
    assert "--set" in expert and "--live-at" in expert


def test_options_become_the_arguments(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--count", "3", "--kind", "large", "--loud"]
    for common in ((), ("count",)):
        assert call(Example, words, verb="example", common=common) == Example(3, "large", 0, True)
    assert call(Example, ["--count", "3"], verb="example") == Example(3)


def test_help_is_the_docstring(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    with pytest.raises(SystemExit):
        call(Example, ["--help"], verb="example")
    text = capsys.readouterr().out
    assert text.startswith("An example.\n\nA second paragraph.\n\nusage: mobilegs example")
    assert "--kind {small,large}" in text
    assert "Kind of things. (default: chosen from the count)" in text
    assert "Seed. (default: 0)" in text
    assert "Number of things. (required)" in text


@pytest.mark.parametrize("words", [[], ["--count", "many"], ["--count", "1", "--kind", "other"]])
def test_malformed_options_exit_with_2(words: list[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        call(Example, words, verb="example")
    assert caught.value.code == 2
