"""Holds a mesh file rewritten in the plainest form of its format, and how many triangles it has. Used by each format's reader."""

from typing import NamedTuple

CHECKED = (".stl", ".obj", ".dae")
"""The kinds of files that are read whole, with nothing left out: only these are checked for collision."""
MOST_TRIANGLES = 4_000_000  # placed; a binary STL of the most bytes has half of this


class Plain(NamedTuple):
    """What a mesh library reads in place of the file.

    Attributes:
        data: The file, rewritten in its own format.
        n_triangles: How many triangles a reader must find in it, instances counted as often as they are placed.
    """

    data: bytes
    n_triangles: int
