"""Checks names that a user gives. Used by ``world`` and ``attached``."""

from ulna.errors import InputError


def refuse_no_name(name: object) -> None:
    """Refuse what is not text, and text that no file and no page can be sent: half a surrogate pair.

    Raises:
        InputError: It is no name.
    """
    if not isinstance(name, str):
        raise InputError("name", f"{name!r} is not text")
    try:
        name.encode()
    except UnicodeEncodeError as error:
        raise InputError("name", f"{name!r} has a character that cannot be written, {name[error.start]!r}") from None
