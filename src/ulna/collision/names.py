"""Checks the names of ``touch_links``."""

from collections.abc import Iterable

from ulna.description.given_names import refuse_no_name
from ulna.errors import InputError

OF_OBJECTS = "; for the links that may touch an object of a world: world.add(..., touch_links=[...])"


def as_link_names(names: Iterable[str]) -> frozenset[str]:
    """The names as a set.

    Raises:
        InputError: They are not a list of names.
    """
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise InputError("touch_links", f"{names!r}; a list of names is expected")
    given = tuple(names)
    for name in given:
        refuse_no_name(name, "touch_links")
    return frozenset(given)
