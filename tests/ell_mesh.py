"""Writes an L-shaped mesh, and makes a robot of it."""

import numpy as np
import pytest

import ulna

CORNERS = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in ((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3))])
BOTTOM = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]  # of an L of 3 x 3 x 1, its arms 1 wide
SIDES = [(k, (k + 1) % 6, 6 + (k + 1) % 6) for k in range(6)] + [(k, 6 + (k + 1) % 6, 6 + k) for k in range(6)]
FACES = np.array([(a, c, b) for a, b, c in BOTTOM] + [(6 + a, 6 + b, 6 + c) for a, b, c in BOTTOM] + SIDES)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The folder of what is kept."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "ulna" / "pieces"


def robot_of_the_ell(folder, urdf):
    """The robot of a document that names ell.obj; both are written to the folder."""
    rows = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
    (folder / "ell.obj").write_text("\n".join(rows))
    (folder / "ell.urdf").write_text(urdf)
    return ulna.load(folder / "ell.urdf")
