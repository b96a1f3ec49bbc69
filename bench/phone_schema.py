"""Check measurements of phones against `bench/phones/schema.json`.

    python -m bench.phone_schema FILE.json ...

Needs jsonschema (`pip install 'mobilegs[bench]'`).
"""

import argparse
import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "phones"
SCHEMA = FOLDER / "schema.json"


def measurement_problems(value: Any) -> list[str]:
    """Return the violations of a measurement; empty if it is valid."""
    from jsonschema import Draft202012Validator

    validator = Draft202012Validator(json.loads(SCHEMA.read_text()))
    found = [f"{error.json_path}: {error.message}" for error in validator.iter_errors(value)]
    if found:
        return found
    scenes = len(value["report"]["scenes"])
    if len(value["files"]) != scenes:
        found.append(f"$.files has {len(value['files'])} items for {scenes} scenes")
    if value["power"] and len(value["power"]["scenes"]) != scenes:
        found.append(
            f"$.power.scenes has {len(value['power']['scenes'])} items for {scenes} scenes"
        )
    for i, (file, scene) in enumerate(zip(value["files"], value["report"]["scenes"], strict=False)):
        if file["bytes"] != scene["file_bytes"]:
            found.append(f"$.files[{i}].bytes is not $.report.scenes[{i}].file_bytes")
    return found


def main() -> None:
    """Print the problems of files; exit code 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE")
    bad = False
    for file in parser.parse_args().files:
        try:
            found = measurement_problems(json.loads(file.read_text()))
        except (OSError, ValueError) as error:
            found = [str(error)]
        bad |= bool(found)
        print(f"{file}: {'; '.join(found) or 'valid'}")
    raise SystemExit(bad)


if __name__ == "__main__":
    main()
