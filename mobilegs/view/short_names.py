"""Short names for what is local to the functions of a JavaScript module."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, product
from string import ascii_letters

# a pattern between slashes stands where a value may begin
TOKEN = re.compile(
    r"(?<=[(,=:\[!&|?{};] )/(?:\\.|\[(?:\\.|[^\]\\])*\]|[^/\\\n\[])+/\w*"
    r"|(?<=[(,=:\[!&|?{};])/(?:\\.|\[(?:\\.|[^\]\\])*\]|[^/\\\n\[])+/\w*"
    r"|[A-Za-z_$][\w$]*|[\d.]*\d\w*|\.\.\.|=>|[^\s]"
)
WORD = re.compile(r"[A-Za-z_$][\w$]*")
OPEN, CLOSE = "([{", ")]}"
TESTS = ("if", "while", "for", "switch")
KEPT = frozenset(
    "do if in of as is let new try var for get set case else enum eval null this true void with "
    "await break catch class const false super throw while yield async static delete export "
    "import return switch typeof default extends finally continue debugger function arguments "
    "interface undefined instanceof self window document navigator location performance name "
    "history module modules made whole entry".split()
)


@dataclass
class Bracket:
    sign: str
    is_class: bool = False
    binds: bool = False
    """Whether names in it are declared there."""


def short_names(code: list[str], kept: set[str]) -> list[str]:
    """Pieces of a module's code with shorter names for its constants, variables and parameters.

    Nothing is understood but brackets, so a name keeps its length as soon as one of its uses may be
    something else: a property, a field, a method, the short form of either, or a global one. `kept`
    has those that others know, or that texts use.
    """
    words = [match[0] for piece in code for match in TOKEN.finditer(piece)]
    ends = _ends(words)
    declared: set[str] = set()
    doubtful = set(KEPT | kept)
    used: Counter[str] = Counter()
    stack = [Bracket("")]
    for at, word in enumerate(words):
        before, after = _token(words, at - 1), _token(words, at + 1)
        inner = stack[-1]
        if word in OPEN:
            stack.append(_opened(words, at, ends, inner))
        elif word in CLOSE:
            stack.pop()
        elif WORD.fullmatch(word) and before not in (".", "#"):
            used[word] += 1
            if before in ("const", "let", "function") or (
                inner.binds and before in (*OPEN[:2], ",", "...")
            ):
                declared.add(word)
            called = after == "(" and before != "function"
            method = called and _token(words, ends[at + 1] + 1) == "{"
            member = inner.is_class and before in ("{", "}", ";")
            short = inner.sign == "{" and before in ("{", ",", "...") and after in ",}=:"
            if method or member or short or before in ("get", "set", "async", "static", "class"):
                doubtful.add(word)
    chosen = [name for name, _ in used.most_common() if name in declared - doubtful]
    fresh = (name for name in _names() if name not in used and name not in doubtful)
    shorter = {name: new for name, new in zip(chosen, fresh, strict=False) if len(new) < len(name)}
    return [_replaced(piece, shorter) for piece in code]


def _replaced(piece: str, shorter: dict[str, str]) -> str:
    before = ""

    def new(match: re.Match[str]) -> str:
        nonlocal before
        word, last = match[0], before
        before = word
        return word if last in (".", "#") else shorter.get(word, word)

    return TOKEN.sub(new, piece)


def _ends(words: list[str]) -> dict[int, int]:
    """For every opening bracket, where it is closed."""
    ends: dict[int, int] = {}
    opened: list[int] = []
    for at, word in enumerate(words):
        if word in OPEN:
            opened.append(at)
        elif word in CLOSE:
            start = opened.pop()
            assert OPEN.index(words[start]) == CLOSE.index(word), " ".join(words[start : at + 1])
            ends[start] = at
    assert not opened
    return ends


def _token(words: list[str], at: int) -> str:
    return words[at] if 0 <= at < len(words) else ""


def _opened(words: list[str], at: int, ends: dict[int, int], outer: Bracket) -> Bracket:
    sign, before = words[at], _token(words, at - 1)
    found = Bracket(sign)
    if sign == "{":
        head = words[max(0, at - 4) : at]
        found.is_class = "class" in head[-2:] or ("class" in head and "extends" in head)
    elif sign == "[":
        found.binds = before in ("const", "let") or (outer.binds and before in (*OPEN[:2], ","))
    else:
        behind = _token(words, ends[at] + 1)
        found.binds = behind == "=>" or (behind == "{" and before not in TESTS)
    return found


def _names() -> Iterator[str]:
    for length in count(1):
        yield from map("".join, product(ascii_letters, repeat=length))
