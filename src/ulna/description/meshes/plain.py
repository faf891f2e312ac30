"""A mesh file rewritten in the simplest form of its format, and its number of triangles."""

from typing import NamedTuple

CHECKED = (".stl", ".obj", ".dae")
"""The formats that are read completely: only these are used for collision checking."""
MOST_TRIANGLES = 4_000_000  # of all instances; a binary STL of MOST_BYTES has half of this


class Plain(NamedTuple):
    """The data that a mesh library reads in place of the file.

    Attributes:
        data: The file, rewritten in its own format.
        n_triangles: The number of triangles that a reader must find in it, over all instances.
    """

    data: bytes
    n_triangles: int
