"""Write the manifest of the scenes that phones are compared with: `bench/phones/scenes.json`.

    python -m bench.phone_scenes RUN_NETWORK RUN_LOBES RUN_SORTED

The arguments are folders of `mobilegs train`, one of each kind, of the same capture: `network`
(the paper's network, evaluated per Gaussian and frame), `lobes` (opacity and phi as spherical
harmonics, decoded once), `sorted` (blended back to front). The scenes themselves are not in the
repository: the manifest has their bytes and SHA-256, and the options that they were trained with.
"""

import argparse
import hashlib
import json
from pathlib import Path
from typing import Any

from mobilegs.errors import InputError
from mobilegs.mgs.codec import read_mgs

FOLDER = Path(__file__).parent / "phones"
MANIFEST = FOLDER / "scenes.json"
KINDS = ("network", "lobes", "sorted")
OPTIONS = ("preset", "downscale", "steps", "seed", "max_splats", "settings")


def file_entry(scene: Path) -> dict[str, Any]:
    """Return kind, bytes, SHA-256 and number of Gaussians of a `.mgs`.

    The kind is one of `KINDS`, or `plain`: sort-free, without view dependence.
    """
    quantized = read_mgs(scene)
    if quantized.blend == "sorted":
        kind = "sorted"
    elif quantized.network is not None:
        kind = "network"
    else:
        kind = "lobes" if quantized.lobe_shape else "plain"
    content = scene.read_bytes()
    return {
        "kind": kind,
        "bytes": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
        "gaussians": len(quantized),
    }


def manifest(runs: list[Path]) -> list[dict[str, Any]]:
    """Return the manifest of run folders.

    Raises InputError unless there is one scene of each kind, all of the same photos.
    """
    entries, photos = [], []
    for run in runs:
        try:
            config = json.loads((run / "config.json").read_text())
        except (OSError, ValueError) as error:
            raise InputError(f"{run} is not a folder of `mobilegs train`: {error}") from None
        options = config["options"]
        trained = {name: options[name] for name in OPTIONS if options.get(name) is not None}
        capture = Path(options["capture"]).name
        entries.append({**file_entry(run / "scene.mgs"), "capture": capture, "trained": trained})
        photos.append(config["photos"])
    kinds = [entry["kind"] for entry in entries]
    if sorted(kinds) != sorted(KINDS):
        raise InputError(f"the scenes are {', '.join(kinds)}: give one of each of {KINDS}")
    if any(one != photos[0] for one in photos):
        raise InputError("the runs have different photos: scenes of one capture can be compared")
    return sorted(entries, key=lambda entry: KINDS.index(entry["kind"]))


def main() -> None:
    """Write the manifest of three runs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=Path, nargs=len(KINDS), metavar="RUN")
    try:
        entries = manifest(parser.parse_args().runs)
    except InputError as error:
        parser.error(str(error))
    MANIFEST.write_text(json.dumps(entries, indent=1) + "\n")
    print(f"{MANIFEST}: {', '.join(entry['kind'] for entry in entries)}")


if __name__ == "__main__":
    main()
