"""The valid files (`seeds/`) and the kept inputs (`corpus/`) of the targets."""

import json
from pathlib import Path

HERE = Path(__file__).parent
CORPUS = HERE / "corpus"
CONFORMANCE = HERE.parent / "tests" / "mgs" / "conformance"
KINDS = ("mgs", "ply", "compressed", "spz", "splat", "sog", "glb")  # files of scenes
VIEWER_KINDS = ("mgs", "ply", "spz")  # what the viewer reads
LONGEST = 6_000  # bytes of a seed that is mutated: longer ones are slow

# by the names of files in `corpus/expected`: a part of the refusal's message, None for a scene
EXPECTED: dict[str, str | None] = json.loads((CORPUS / "expected.json").read_text())


def seeds(kind: str) -> dict[str, bytes]:
    """Return the valid files of a kind by name; among the `.mgs` are those of conformance."""
    paths = sorted((HERE / "seeds" / kind).iterdir())
    if kind == "mgs":
        paths += [p for p in sorted(CONFORMANCE.glob("*.mgs")) if p.stat().st_size <= LONGEST]
    return {path.name: path.read_bytes() for path in paths}


def short_seeds(kind: str) -> list[bytes]:
    """Return the seeds that are mutated."""
    return [data for data in seeds(kind).values() if len(data) <= LONGEST]


def kind_of(target: str) -> str:
    """Return the kind of a target's files."""
    return target.partition("-")[2] or "mgs"


def corpus(target: str) -> list[bytes]:
    """Return the kept inputs of a target, and the files with expected verdicts of its kind.

    `agreement` has those of all targets of `.mgs`.
    """
    names = ["python-mgs", "javascript-mgs"] if target == "agreement" else []
    paths = [path for name in [*names, target] for path in files_in(CORPUS / name)]
    if not target.startswith("cpp"):
        paths += sorted((CORPUS / "expected").glob(f"*.{kind_of(target)}"))
    return [path.read_bytes() for path in paths]


def write(inputs: list[bytes], folder: Path) -> None:
    """Write inputs into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(inputs):
        (folder / f"{number:04d}").write_bytes(data)


def files_in(folder: Path) -> list[Path]:
    """Return the files of a folder, none if there is no such folder."""
    return sorted(folder.iterdir()) if folder.is_dir() else []
