"""Notes of a `.mgs` file that viewers use, checked and written as docs/reference/format.md says.

Notes are one-line texts of at most 4096 characters. `annotations` and `path` continue in
`annotations.2`, `annotations.3`, ... and `path.2`, ...; each part is complete by itself.
"""

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from mobilegs.edit.regions import Triple
from mobilegs.errors import InputError
from mobilegs.mgs.container import short_text
from mobilegs.mgs.limits import META_MAX, TEXT_MAX
from mobilegs.viewpoints.framing import Start, written

TITLE_MAX = 200  # characters of a title or credit
ANNOTATION_MAX = 1000  # characters of an annotation's text
ANNOTATIONS_MAX = 200
POSES_MAX = 1000  # key poses of a camera path
CONTINUED = ("annotations", "path")
LIMITS_GONE = {"limits": "", "limits_portrait": ""}
SHORTEST = 1e-9  # length of a direction
Key = tuple[Triple, Triple]


@dataclass(frozen=True)
class Annotation:
    """A numbered dot in the scene.

    Attributes:
        at: the dot's place, world units.
        text: of the label that the viewer shows; may have line breaks.
        eye: from where the viewer looks at it; None to keep its direction.
    """

    at: Triple
    text: str
    eye: Triple | None = None


def line_of_text(text: str, what: str) -> str:
    """Return a title or credit, stripped. Raises InputError if it is not one line."""
    text = text.strip()
    if not short_text(text, TITLE_MAX):
        raise InputError(f"the {what} must be one line of at most {TITLE_MAX} characters")
    return text


def start_text(start: Start) -> str:
    """Return the note of a first view. Raises InputError if no viewer can show it."""
    numbers = [float(word) for word in start.text.split()]
    if numbers[:3] == numbers[3:6]:
        raise InputError("a start view cannot look at its own position")
    if not all(0 < tangent < 1e3 for tangent in numbers[6:]):
        raise InputError("the last two numbers of a start view are tangents above 0")
    return start.text


def plane_text(normal: Triple, offset: float | int) -> str:
    """Return the note `floor`: the plane normal . x = offset, with the normal pointing up.

    Raises InputError if the normal is too short, or the plane too far away.
    """
    size = math.hypot(*normal)
    plane = [value / size for value in (*normal, offset)] if size > SHORTEST else []
    if not plane or not all(map(_is_number, plane)):
        raise InputError("the floor has no normal, or is out of reach")
    return written(plane)


def parsed_annotations(annotations: Any) -> list[Annotation]:
    """Return annotations from a JSON list of `{"at": [x, y, z], "text": ..., "eye": [x, y, z]}`.

    Raises InputError for anything else.
    """
    if not isinstance(annotations, list) or len(annotations) > ANNOTATIONS_MAX:
        raise InputError(f"annotations must be a list of at most {ANNOTATIONS_MAX}")
    made = []
    for number, item in enumerate(annotations, 1):
        fields = item if isinstance(item, dict) else {}
        at, text, eye = fields.get("at"), fields.get("text"), fields.get("eye")
        if not _is_point(at) or not isinstance(text, str) or not (eye is None or _is_point(eye)):
            raise InputError(
                f'annotation {number} is not {{"at": [x, y, z], "text": "...", "eye": [x, y, z]}} '
                "(eye may be missing)"
            )
        text = text.strip().replace("\r\n", "\n")
        if not text or not short_text(text.replace("\n", ""), ANNOTATION_MAX):
            raise InputError(
                f"the text of annotation {number} must have 1 to {ANNOTATION_MAX} characters, and "
                "no control characters but line breaks"
            )
        made.append(Annotation(tuple(at), text, None if eye is None else tuple(eye)))  # pyright: ignore[reportArgumentType]
    return made


def parsed_path(poses: Any) -> list[Key]:
    """Return key poses (eye, target) from a JSON list of lists of six numbers.

    Raises InputError for anything else, and for fewer than two poses.
    """
    if not isinstance(poses, list) or not 2 <= len(poses) <= POSES_MAX:
        raise InputError(f"a camera path is a list of 2 to {POSES_MAX} poses")
    keys = []
    for number, pose in enumerate(poses, 1):
        if not isinstance(pose, list) or len(pose) != 6 or not all(map(_is_number, pose)):
            raise InputError(f"pose {number} of the camera path is not six numbers: eye, target")
        eye, target = tuple(pose[:3]), tuple(pose[3:])
        if written(eye) == written(target):
            raise InputError(f"pose {number} of the camera path looks at its own position")
        keys.append((eye, target))
    return keys


def annotation_notes(annotations: Iterable[Annotation]) -> dict[str, str]:
    """Return the notes `annotations`, `annotations.2`, ... of a file."""
    items = [
        json.dumps(
            {
                "at": _rounded(one.at),
                "text": one.text,
                **({} if one.eye is None else {"eye": _rounded(one.eye)}),
            },
            ensure_ascii=False,
            separators=(",", ":"),
        )
        for one in annotations
    ]
    return _continued("annotations", [f"[{','.join(part)}]" for part in _grouped(items, 2)])


def path_notes(keys: Iterable[Key]) -> dict[str, str]:
    """Return the notes `path`, `path.2`, ... of a file."""
    items = [written([*eye, *target]) for eye, target in keys]
    return _continued("path", [";".join(part) for part in _grouped(items, 0)])


def merged_notes(notes: Mapping[str, Any], changes: Mapping[str, str]) -> dict[str, Any]:
    """Return notes with `changes`, of which an empty text removes a note.

    A new `annotations` or `path` also removes the notes that continued the old one, and another
    `up` the limits, whose azimuths turn around it. Raises InputError if there are too many.
    """
    if "up" in changes and changes["up"] != notes.get("up", ""):
        changes = {**LIMITS_GONE, **changes}
    stale = {name for name in CONTINUED if name in changes}
    kept = {
        name: value
        for name, value in notes.items()
        if not (re.fullmatch(r"\w+\.\d+", name) and name.split(".")[0] in stale)
    }
    merged = {**kept, **changes}
    merged = {name: value for name, value in merged.items() if value != "" or name not in changes}
    if len(merged) > META_MAX:
        raise InputError(
            f"a file holds {META_MAX} notes, these are {len(merged)}: shorten the annotations or "
            "the camera path"
        )
    return merged


def continued_note(notes: Mapping[str, Any], name: str) -> list[str]:
    """Return the texts of a note and its continuations, in order."""
    texts = []
    for number in range(1, META_MAX + 1):
        text = notes.get(name if number == 1 else f"{name}.{number}")
        if not isinstance(text, str):
            break
        texts.append(text)
    return texts


def page_notes(notes: Mapping[str, str]) -> dict[str, str]:
    """Return notes for the attributes of a page's element, which hold each of them whole."""
    whole = {name: text for name, text in notes.items() if text and "." not in name}
    if "annotations" in whole:
        lists = [json.loads(text) for text in continued_note(notes, "annotations")]
        one = [item for part in lists for item in part]
        whole["annotations"] = json.dumps(one, ensure_ascii=False, separators=(",", ":"))
    if "path" in whole:
        whole["path"] = ";".join(continued_note(notes, "path"))
    return whole


def _grouped(items: list[str], around: int) -> list[list[str]]:
    """Return items in groups that fit a note with one separator each and `around` more."""
    groups: list[list[str]] = [[]]
    size = around
    for item in items:
        if groups[-1] and size + len(item) + 1 > TEXT_MAX:
            groups.append([])
            size = around
        groups[-1].append(item)
        size += len(item) + 1
    return groups if items else []


def _continued(name: str, texts: list[str]) -> dict[str, str]:
    """Return texts as a note and its continuations; an empty note, which removes one, without."""
    if not texts:
        return {name: ""}
    return {name if i == 1 else f"{name}.{i}": text for i, text in enumerate(texts, 1)}


def _rounded(point: Triple) -> list[float]:
    return [float(f"{value:.6g}") for value in point]


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value) and abs(value) < 1e12


def _is_point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))
