"""Loads plugins: commands and films that packages add by entry points, as the demo does.

A package adds commands in the group ``ulna.commands``: a ``typer.Typer`` whose commands become commands of ``ulna``. In the group
``ulna.films`` it adds a film, which ``ulna record`` makes if ``--robot`` is not given.
"""

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any, Protocol

COMMANDS, FILMS = "ulna.commands", "ulna.films"


class Film(Protocol):
    """Interface of a film in the group ``ulna.films``: it records into the file of a ``viewer.film.recording.Form``."""

    def __call__(self, form: Any, at: float | None, *, boxes: bool, tell: Callable[[int], object]) -> None:
        """Record. ``at``: the time [s] of a single picture; ``tell`` is called with the number of pictures done."""


def load_plugins(group: str) -> list[Any]:
    """Load the objects of a group's entry points; those of a deleted package are skipped."""
    found = []
    for entry in entry_points(group=group):
        try:
            found.append(entry.load())
        except ModuleNotFoundError as error:
            if not f"{entry.module}.".startswith(f"{error.name}."):  # another module is missing: one that the plugin needs
                raise
    return found
