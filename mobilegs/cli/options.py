"""Options of the verbs: parsed by tyro, described by docstrings.

tyro takes names, types and defaults from the parameters of a function or a dataclass. This module
gives it the descriptions: "Default: ..." at the end of a docstring replaces a default that says
nothing (None, False, an empty text), and long lists of options are grouped under two headings. A
parameter that is a dataclass stands for its fields, which are options of several verbs.
"""

import shutil
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import field, is_dataclass, make_dataclass
from inspect import Parameter, signature
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import docstring_parser
import tyro
from tyro.conf import FlagCreatePairsOff, OmitArgPrefixes, arg

WIDTH_MAX = 100  # of a description
T = TypeVar("T")


def call(
    target: Callable[..., T], words: Sequence[str], *, verb: str, common: Sequence[str] = ()
) -> T:
    """Call `target`, a function or a dataclass, with the options in `words`.

    `--help` lists options in `common` as common options and others as expert options; without
    `common` there is one list. Raises SystemExit with code 0 after `--help`, and with code 2 after
    a message about unknown, missing or malformed options.
    """
    if {"-h", "--help"} & set(words):
        docs = docstring_parser.parse_from_object(target)
        print(f"{wrapped(docs.description or '')}\n")
    groups: dict[str, list[tuple[str, Any, Any]]] = {"common": [], "expert": []}
    shared: dict[str, type] = {}
    for name, described in options_of(target).items():
        hint = get_type_hints(target, include_extras=True)[name]
        if is_dataclass(hint):
            assert isinstance(hint, type)
            shared[name] = hint
            groups["expert" if common else "common"] += options_of(hint).values()
        else:
            groups["common" if name in common or not common else "expert"].append(described)
    if common:
        kinds = {name: make_dataclass(name, part, kw_only=True) for name, part in groups.items()}
        whole = make_dataclass("Options", [(name, OmitArgPrefixes[kinds[name]]) for name in kinds])
    else:
        whole = make_dataclass("Options", groups["common"], kw_only=True)
    parsed = tyro.cli(
        whole, prog=f"mobilegs {verb}", description="", args=words, config=(FlagCreatePairsOff,)
    )
    parts = vars(parsed).values() if common else [parsed]
    values = {name: value for part in parts for name, value in vars(part).items()}
    for name, kind in shared.items():
        values[name] = kind(**{field: values.pop(field) for field in options_of(kind)})
    return target(**values)


def options_of(target: Callable[..., Any]) -> dict[str, tuple[str, Any, Any]]:
    """Return the parameters of a function or a dataclass, described, for `make_dataclass`."""
    described = [part for part in getattr(target, "__mro__", ()) if is_dataclass(part)] or [target]
    params = [p for part in described for p in docstring_parser.parse_from_object(part).params]
    texts = {param.arg_name: param.description or "" for param in params}
    hints = get_type_hints(target, include_extras=True)
    return {
        name: option(parameter, hints[name], texts.get(name, ""))
        for name, parameter in signature(target).parameters.items()
    }


def option(parameter: Parameter, hint: Any, text: str) -> tuple[str, Any, Any]:
    """Return name, type and default of an option, as a field for `make_dataclass`."""
    text, _, words = " ".join(text.split()).partition("Default: ")
    default = parameter.default
    shown: dict[str, Any] = {"help": text.strip()}
    if words:
        shown["help_behavior_hint"] = f"(default: {words.rstrip('.')})"
    elif default is False or default in (None, "", ()):
        shown["help_behavior_hint"] = ""
    kind = Annotated[hint, arg(**shown)]
    if names := optional_choices(hint):
        kind = Annotated[kind, arg(metavar=f"{{{','.join(names)}}}")]
    if default is Parameter.empty:
        return parameter.name, kind, field()
    return parameter.name, kind, field(default=default)


def optional_choices(hint: Any) -> list[str]:
    """Return the texts of `Literal[...] | None`, or nothing for other types."""
    if get_origin(hint) not in (Union, UnionType) or NoneType not in get_args(hint):
        return []
    return [
        name for part in get_args(hint) if get_origin(part) is Literal for name in get_args(part)
    ]


def wrapped(text: str) -> str:
    """Return paragraphs in lines that fit the terminal."""
    width = min(WIDTH_MAX, shutil.get_terminal_size().columns)
    return "\n\n".join(
        textwrap.fill(part, width, break_on_hyphens=False) for part in text.split("\n\n")
    )
