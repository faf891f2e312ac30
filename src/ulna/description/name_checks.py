"""Checks names that a user gives to links, joints, tools and objects."""

import re
from collections.abc import Iterable

from ulna.errors import InputError, cited

_REORDERING = re.compile("[\u202a-\u202e\u2066-\u2069]")  # controls of UAX 9, with which a text can look like another


def name_fault(name: object) -> str:
    """The fault of a name; empty if it is valid.

    A lone surrogate cannot be written to a file or sent to a page. Controls that reorder letters can make a name look like
    another.

    Example:
        >>> name_fault("hand"), name_fault(5)
        ('', '5 is not text')
    """
    if not isinstance(name, str):
        return f"{cited(name)} is not text"
    try:
        name.encode()
    except UnicodeEncodeError as error:
        return f"{cited(name)} has a character that cannot be written, {name[error.start]!r}"
    found = _REORDERING.search(name)
    return f"{cited(name)} has a character that changes the order of letters, {found[0]!r}" if found else ""


def refuse_no_name(name: object, argument: str = "name") -> None:
    """Refuse an invalid name."""
    if fault := name_fault(name):
        raise InputError(argument, fault)


def as_link_names(names: Iterable[str]) -> frozenset[str]:
    """The names of ``touch_links`` as a set."""
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise InputError("touch_links", f"{cited(names)}; a list of names is expected")
    given = tuple(names)
    for name in given:
        refuse_no_name(name, "touch_links")
    return frozenset(given)
