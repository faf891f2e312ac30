"""Loads plugins: commands and films that packages add by entry points, as the demo does. Used by ``app``, ``ulna record``.

A package adds commands in the group ``ulna.commands``: a ``typer.Typer`` whose commands become commands of ``ulna``. In the group
``ulna.films`` it adds a film, which ``ulna record`` makes if ``--robot`` is not given; ``record.Film`` is its interface.
"""

from importlib.metadata import entry_points
from typing import Any

COMMANDS, FILMS = "ulna.commands", "ulna.films"


def load_plugins(group: str) -> list[Any]:
    """The objects of the entry points of a group. Those of a package that has been deleted are skipped.

    Raises:
        ImportError: The module of an entry point exists, but cannot be imported.
    """
    found = []
    for entry in entry_points(group=group):
        try:
            found.append(entry.load())
        except ModuleNotFoundError as error:
            if not f"{entry.module}.".startswith(f"{error.name}."):  # another module is missing: one that the plugin needs
                raise
    return found
