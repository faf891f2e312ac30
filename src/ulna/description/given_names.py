"""Checks names that a user gives: of links, joints, tools, objects. Used by ``structure``, ``subtree`` and ``collision``."""

from ulna.errors import InputError


def name_fault(name: object) -> str:
    """What is wrong with a name; empty if it is valid.

    A lone surrogate cannot be written to a file or sent to a page.

    Example:
        >>> name_fault("hand"), name_fault(5)
        ('', '5 is not text')
    """
    if not isinstance(name, str):
        return f"{name!r} is not text"
    try:
        name.encode()
    except UnicodeEncodeError as error:
        return f"{name!r} has a character that cannot be written, {name[error.start]!r}"
    return ""


def refuse_no_name(name: object, argument: str = "name") -> None:
    """Refuse an invalid name.

    Raises:
        InputError: See ``name_fault``.
    """
    if fault := name_fault(name):
        raise InputError(argument, fault)
