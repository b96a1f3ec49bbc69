"""The one exception that every refusal of a user's input raises."""


class InputError(ValueError):
    """Something the user gave cannot be used: a file, a capture, an option.

    The message is one sentence: what is wrong, where, and what to do about it. The command
    line prints it and exits with code 2; nothing half-written is left behind.
    """
