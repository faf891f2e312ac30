"""Names that a user gives."""

from collections.abc import Iterable

from ulna.errors import InputError

OF_OBJECTS = "; which links may touch an object of a world, the world says: world.add(..., touch_links=[...])"


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


def as_link_names(names: Iterable[str]) -> frozenset[str]:
    """The names of ``touch_links``.

    Raises:
        InputError: They are not a list of names.
    """
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise InputError("touch_links", f"{names!r}; a list of names is expected")
    given = tuple(names)
    for name in given:
        refuse_no_name(name)
    return frozenset(given)
