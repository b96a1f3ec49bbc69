"""The exception for input that cannot be used."""


class InputError(ValueError):
    """A file, a capture or an option that cannot be used.

    The message is one sentence: what is wrong, where, and what to do. The command line prints it
    and exits with code 2. No partly written file is left.
    """
