"""The exception for input that cannot be used, and texts from files in messages."""

import re

# control characters, ends of lines, marks that change the direction of the text that follows, and
# what stands for bytes that are no text
UNSEEN = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


class InputError(ValueError):
    """A file, a capture or an option that cannot be used.

    The message is one sentence: what is wrong, where, and what to do. Further arguments are further
    sentences. The command line prints them, a line each, and exits with code 2. No partly written
    file is left.
    """

    def __str__(self) -> str:
        return "\n".join(map(str, self.args))


def printable(text: str) -> str:
    """Return a text for a terminal: on one line, and control characters escaped, as in `\\x1b`."""
    return UNSEEN.sub(lambda found: ascii(found[0])[1:-1], text)


def quoted(value: object, longest: int = 120) -> str:
    """Return a value from a file as text for a message: escaped, and cut off if it is long."""
    text = repr(value)
    return text if len(text) <= longest else f"{text[:longest]}..."
