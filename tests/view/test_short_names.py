"""Short names in bundles: what is local gets one, and what may be anything else does not."""

import json
import subprocess

import pytest

from mobilegs.view.bundle import TEXT
from mobilegs.view.short_names import short_names
from tests.web.test_decoder import node_program


def shortened(text: str) -> str:
    pieces = TEXT.split(text)
    pieces[::2] = short_names(pieces[::2], pieces[1::2])
    return "".join(pieces)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("const value = 1; value + other;", "const a = 1; a + other;"),
        ("let first = [], second = first;", "let a = [], second = a;"),
        ("const [first, , ...others] = list;", "const [a, , ...b] = list;"),
        ("for (const [key, item] of all) use(item);", "for (const [b, a] of all) use(a);"),
        ("function many(count, ...items) {}", "function a(b, ...c) {}"),
        ("sum((left, right) => left + right);", "sum((a, b) => a + b);"),
        ("sum(([left, [right]]) => left / right / 2);", "sum(([a, [b]]) => a / b / 2);"),
        ("try {} catch (error) { tell(error); }", "try {} catch (a) { tell(a); }"),
        # properties, and short forms of them
        ("const size = 1; of.size = size;", "const a = 1; of.size = a;"),
        ("const size = 1; f({ size });", "const size = 1; f({ size });"),
        ("const size = 1; f({ at, size, to });", "const size = 1; f({ at, size, to });"),
        ("const { size } = it; f(size);", "const { size } = it; f(size);"),
        ("const size = 1; f({ size: size + 1 });", "const size = 1; f({ size: size + 1 });"),
        ("const size = 1; f({ at: size });", "const a = 1; f({ at: a });"),
        ("const size = 1; f({ size() {} });", "const size = 1; f({ size() {} });"),
        # classes
        ("class It { size = 1; }; const size = 2;", "class It { size = 1; }; const size = 2;"),
        ("class It { size; } let size = 2;", "class It { size; } let size = 2;"),
        ("class It { f() {} size() {} } let size;", "class It { f() {} size() {} } let size;"),
        ("class It extends A { static size = 1; } let size;",) * 2,
        ("class It { get size() {} } let size;",) * 2,
        ("class It { #size; f(size) { this.#size = size; } }",
         "class It { #size; f(a) { this.#size = a; } }"),
        # what is local to one statement or member shares names with what is local to another
        ("function f(first) {} function g(second) {}", "function f(a) {} function g(a) {}"),
        ("const top = 1; function f(first) { return top + first; }",
         "const a = 1; function f(b) { return a + b; }"),
        ("class It { f(first) {} g(second) { h({ first }); } }",
         "class It { f(a) {} g(a) { h({ first }); } }"),
        ("const f = (first) => first; const g = (a) => first + a;",
         "const f = (a) => a; const g = (a) => first + a;"),
        ("function f() { const [one] = it; } const [one] = it; use({ one });",
         "function f() { const [one] = it; } const [one] = it; use({ one });"),
        ("for (const [one, two] of it) use(one, two); function f(three) {}",
         "for (const [a, b] of it) use(a, b); function f(a) {}"),
        # texts, and patterns that hold brackets
        ("const size = 1; f(`${size} of them`);",) * 2,
        ("function f(size) { g(`${size}`); } function g(size) { return size; }",
         "function f(size) { g(`${size}`); } function g(a) { return a; }"),
        ("const size = 1; function g(b) { return `${a}` + size + b; }",
         "const c = 1; function g(b) { return `${a}` + c + b; }"),
        ("const size = 1; f('size');", "const a = 1; f('size');"),
        ("const found = text.replace(/[({]/g, found);", "const a = text.replace(/[({]/g, a);"),
        # names that are taken, and names that are for others
        ("const size = a;", "const b = a;"),
        ("const size = 1; f(size)", "const a = 1; f(a)"),
        ("const self = 1; const window = 2;",) * 2,
    ],
)  # fmt: skip
def test_what_is_local_has_a_short_name(text: str, expected: str) -> None:
    assert shortened(text) == expected


def test_a_shortened_module_does_the_same() -> None:
    text = """
    const table = new Map();
    function remember(key, value = key * 2) { table.set(key, value); return { key, value }; }
    class Pair {
      #first; second = 1;
      constructor(first, [second, third]) { this.#first = first; this.second = second + third; }
      get sum() { const { second } = this; return this.#first + second; }
    }
    const results = [];
    for (const [index, entry] of ["x", "y"].entries()) results.push(`${index}${entry}`);
    const made = (...numbers) => numbers.map((number) => number / 2 / 2);
    remember(3); remember(4, 1);
    console.log(JSON.stringify([
      [...table], new Pair(1, [2, 3]).sum, results, made(4, 8), remember(1), /[)(]/.test("("),
    ]));
    """
    short = shortened(text)
    assert len(short) < len(text) - 80
    found = [
        subprocess.run([node_program(), "-e", it], capture_output=True, text=True, check=True)
        for it in (text, short)
    ]
    assert found[0].stdout == found[1].stdout and len(json.loads(found[0].stdout)) == 6
