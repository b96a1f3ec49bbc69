"""Short names for what is local to the functions of a JavaScript module."""

import re
from collections import Counter
from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
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
STATEMENTS = ("const", "let", "function", "class", "return")
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


@dataclass
class Unit:
    """A statement of the module, or a member of a class in it: what is declared inside is local."""

    declared: set[str] = field(default_factory=set)
    doubtful: set[str] = field(default_factory=set)
    used: Counter[str] = field(default_factory=Counter)


def short_names(code: list[str], texts: list[str]) -> list[str]:
    """Pieces of a module's code with shorter names for its constants, variables and parameters.

    Nothing is understood but brackets, so a name keeps its length as soon as one of its uses may be
    something else: a property, a field, a method, the short form of either, or a global one, or
    stands in one of the texts between the pieces.
    """
    units, of_word, of_module = _units(code, texts)
    every = Unit(of_module)
    for unit in units:
        every.doubtful |= unit.doubtful
        every.used += unit.used
    shared = _shorter(every, of_module - every.doubtful - KEPT, KEPT | set(every.used))
    found = []
    for unit in units:
        here = {name: new for name, new in shared.items() if name in unit.used}
        local = unit.declared - unit.doubtful - of_module - KEPT
        busy = KEPT | set(unit.used) | set(here.values())
        found.append(here | _shorter(unit, local, busy))
    numbers = iter(of_word)
    return [_replaced(piece, found, numbers) for piece in code]


def _units(code: list[str], texts: list[str]) -> tuple[list[Unit], list[int], set[str]]:
    """The units, the number of each word's, and what is declared for the whole module."""
    words = [match[0] for piece in code for match in TOKEN.finditer(piece)]
    told = _told(code, texts)
    ends = _ends(words)
    units, of_word, of_module = [Unit()], [], set()
    stack = [Bracket("")]
    for at, word in enumerate(words):
        before, after = _token(words, at - 1), _token(words, at + 1)
        inner = stack[-1]
        if (len(stack) == 1 and word in STATEMENTS) or (
            inner.is_class and before in ("{", "}", ";")
        ):
            units.append(Unit())
        unit = units[-1]
        of_word.append(len(units) - 1)
        unit.doubtful |= told.get(at, set())
        unit.used.update(told.get(at, ()))
        if word in OPEN:
            stack.append(_opened(words, at, ends, inner))
        elif word in CLOSE:
            stack.pop()
        elif WORD.fullmatch(word) and before not in (".", "#"):
            unit.used[word] += 1
            if before in ("const", "let", "function") or (
                inner.binds and before in (*OPEN[:2], ",", "...")
            ):
                unit.declared.add(word)
                if all(bracket.sign == "[" for bracket in stack[1:]):
                    of_module.add(word)
            called = after == "(" and before != "function"
            method = called and _token(words, ends[at + 1] + 1) == "{"
            member = inner.is_class and before in ("{", "}", ";")
            short = inner.sign == "{" and before in ("{", ",", "...") and after in ",}=:"
            if method or member or short or before in ("get", "set", "async", "static", "class"):
                unit.doubtful.add(word)
    return units, of_word, of_module


def _told(code: list[str], texts: list[str]) -> dict[int, set[str]]:
    """By the number of the word that a text follows, what stands in expressions in it."""
    found: dict[int, set[str]] = {}
    at = -1
    for piece, text in zip(code, texts, strict=False):
        at += sum(1 for _ in TOKEN.finditer(piece))
        if "${" in text:
            found.setdefault(at, set()).update(WORD.findall(text))
    return found


def _shorter(unit: Unit, names: set[str], taken: AbstractSet[str]) -> dict[str, str]:
    """Names that are not taken, for those of the unit's that get shorter by it."""
    chosen = [name for name, _ in unit.used.most_common() if name in names]
    fresh = (name for name in _names() if name not in taken)
    shorter = zip(chosen, fresh, strict=False)
    return {name: new for name, new in shorter if len(new) < len(name)}


def _replaced(piece: str, shorter: list[dict[str, str]], numbers: Iterator[int]) -> str:
    before = ""

    def new(match: re.Match[str]) -> str:
        nonlocal before
        word, last = match[0], before
        before, names = word, shorter[next(numbers)]
        return word if last in (".", "#") else names.get(word, word)

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
