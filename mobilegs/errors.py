"""The exception for input that cannot be used."""


class InputError(ValueError):
    """A file, a capture or an option that cannot be used.

    The message is one sentence: what is wrong, where, and what to do. The command line prints it
    and exits with code 2. No partly written file is left.
    """


def quoted(value: object, longest: int = 120) -> str:
    """Return a value from a file as text for a message: escaped, and cut off if it is long."""
    text = repr(value)
    return text if len(text) <= longest else f"{text[:longest]}..."
