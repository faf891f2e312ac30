"""Lays out six axes of a family as the table of the kernels."""

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.closed_form.axes import Axes
from ulna.ik.closed_form.families import EXACT, Family
from ulna.kernels.chain import closed_form_layout as layout

Array = NDArray[np.float64]
_NEAR_ERROR = 1e-9  # more than is allowed, so that every branch of a near form takes a step
_PARALLEL = (layout.THREE_PARALLEL, layout.OFFSET_HAND)
_NOTHING = 1e-28  # of a bend, which the rounding of right angles leaves


def table_of(axes: Axes, family: Family, n_free: int) -> Array:
    """The table (``closed_form_layout``), shape (N_ROWS, 3), read-only; the last ``n_free`` joints are free."""
    table = np.zeros((layout.N_ROWS, 3))
    h, reach = family.directions, axes.unit
    c, back = family.points / reach, inverse(axes.end)
    table[layout.AXES : layout.AXES + 6] = h
    table[layout.POINTS], table[layout.POINTS + 1 : layout.POINTS + 6], table[layout.LAST] = c[0], np.diff(c, axis=0), c[5]
    table[layout.FRAME : layout.FRAME + 3], table[layout.FRAME + 3] = back[:3, :3].T, back[:3, 3] / reach
    frames = {row: _frame(h[j]) for row, j in ((layout.OF_2, 1), (layout.OF_4, 3), (layout.OF_6, 5))}
    for row, frame in frames.items():
        table[layout.NORMALS + row : layout.NORMALS + row + 2] = frame[:, :2].T
    before = layout.OF_2 if family.number in _PARALLEL else layout.OF_4
    table[layout.FIFTH : layout.FIFTH + 9] = _turns(frames[before], h[4], frames[layout.OF_6])
    table[layout.BENDS, :2] = _bends(h[1] if family.number == layout.THREE_PARALLEL else h[3], h[4], h[5])
    table[layout.BENDS, layout.FREE_WRIST] = n_free == 3 and not family.from_end
    table[layout.FORM] = family.number, family.from_end, 1.0 / reach
    order, slides = (axes.entries[::-1], axes.slides[::-1]) if family.from_end else (axes.entries, axes.slides)
    table[layout.COLUMNS : layout.COLUMNS + 2] = order.reshape(2, 3)
    table[layout.SIGNS : layout.SIGNS + 2] = np.where(slides, family.signs * reach, family.signs).reshape(2, 3)
    table[layout.POLISH] = (0.0, 1e-3, 4) if family.miss <= EXACT else (_NEAR_ERROR, 0.3, 8)
    table.setflags(write=False)
    return table


def _frame(h: Array) -> Array:
    """The frame of an axis: its columns are a normal n, h x n and h."""
    n = np.asarray(np.cross(h, np.eye(3)[np.argmin(np.abs(h))]), dtype=np.float64)
    n = n / float(np.linalg.norm(n))
    return np.column_stack([n, np.cross(h, n), h])


def _turns(before: Array, h: Array, behind: Array) -> Array:
    """K, C and S of K + C cos + S sin = before' rot(h, angle) behind, by Rodrigues' formula: nine rows."""
    still = np.outer(h, h)
    across: Array = np.cross(h, behind, axisb=0, axisc=0).astype(np.float64)
    return np.vstack([before.T @ still @ behind, before.T @ (np.eye(3) - still) @ behind, before.T @ across])


def _bends(h: Array, k: Array, p: Array) -> tuple[float, float]:
    """1 - cos(a - b) and 1 + cos(a + b), a and b the angles of k with h and with p, with no digits lost near 0."""
    a, b = (float(np.arctan2(np.linalg.norm(np.cross(k, v)), k @ v)) for v in (h, p))
    less, more = 2.0 * np.sin((a - b) / 2.0) ** 2, 2.0 * np.cos((a + b) / 2.0) ** 2
    return 0.0 if less < _NOTHING else float(less), 0.0 if more < _NOTHING else float(more)
