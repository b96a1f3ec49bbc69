"""The viewer's readers in Node.js."""

import json
import struct
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fuzz.findings import Failure
from tests.support.node import node_program

READERS = Path(__file__).parent / "js" / "readers.js"
EVERY = 5  # one of this many scenes is decoded completely, or read in pieces
SECONDS = 2.0  # processor time allowed per input

# the outcome of a batch: numbers of the inputs that reached new code, blocks reached so far, and an
# error for each input, or None
Ran = tuple[list[int], int, Sequence[Failure | None]]
Run = Callable[[list[bytes]], Ran]


class Viewer:
    """A process of Node.js with the readers, to which files in `folder` pass the inputs.

    `options` are those of `js/readers.js`.
    """

    def __init__(self, folder: Path, *options: str, seconds: float = SECONDS) -> None:
        self.batch, self.seconds = folder / "-".join(["batch", *options]), seconds
        command = [node_program(), "--max-old-space-size=512", READERS, *options]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)

    def ask(self, kind: str, inputs: list[bytes], **more: object) -> Any:
        """Return `{verdicts, novel, blocks}`; RuntimeError if the process has ended."""
        stdin, stdout = self.process.stdin, self.process.stdout
        assert stdin is not None and stdout is not None
        self.batch.write_bytes(b"".join(struct.pack("<I", len(data)) + data for data in inputs))
        asked = {"kind": kind, "path": str(self.batch), "every": EVERY, "seconds": self.seconds}
        stdin.write(json.dumps({**asked, **more}) + "\n")
        stdin.flush()
        answer = stdout.readline()
        if not answer:
            raise RuntimeError(f"Node.js ended with code {self.process.wait()}")
        return json.loads(answer)

    def run(self, kind: str, batch: list[bytes]) -> Ran:
        """Run the reader of one kind of file on a batch."""
        answer = self.ask(kind, batch)
        errors = [found if isinstance(found, dict) else None for found in answer["verdicts"]]
        return answer["novel"], answer["blocks"], errors

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.communicate()
