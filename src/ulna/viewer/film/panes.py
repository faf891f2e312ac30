"""Makes panes of translucent boxes for ``kernels.render.translucent``: their visible sides. Used by ``painter``."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.description.shapes import Box
from ulna.viewer.film.skin import linear
from ulna.viewer.solid import Solid

# The sides of a cube of edge 2, each as four corners in order around it.
_SIDES = np.array(
    [
        np.roll([(sign, y * sign, z) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis, axis=1)
        for axis in range(3)
        for sign in (-1, 1)
    ],
    dtype=np.float64,
)
_SHADE = 0.25  # by which part a side that faces down is darker


@dataclass(frozen=True, eq=False)
class Panes:
    """Sides of boxes, from far to near.

    Attributes:
        points: Their corners in the base frame [m], four for each side in order around it, shape (4 n, 3).
        paints: Red, green, blue (linear light) and opacity, shape (n, 4).
    """

    points: NDArray[np.float64]
    paints: NDArray[np.float64]


def make_panes(solids: Sequence[tuple[Solid[Box], NDArray[np.float64]]], eye: NDArray[np.float64]) -> Panes:
    """The sides of boxes that face the eye, shape (3,); each box comes with its T_base_box, shape (4, 4)."""
    quads, paints = [np.empty((0, 4, 3))], [np.empty((0, 4))]
    for solid, T in solids:
        corners = (_SIDES * solid.shape.half_extents) @ T[:3, :3].T + T[:3, 3]
        outwards = corners.mean(axis=1) - T[:3, 3]
        seen = np.einsum("ij,ij->i", outwards, eye - corners.mean(axis=1)) > 0.0
        upwards = outwards[:, 2] / np.maximum(np.linalg.norm(outwards, axis=1), 1e-12)
        light = linear(solid.color) * (1.0 - _SHADE * (0.5 - 0.5 * upwards[:, None]))
        quads.append(corners[seen])
        paints.append(np.column_stack([light, np.full(6, solid.opacity)])[seen])
    sides, colors = np.concatenate(quads), np.concatenate(paints)
    order = np.argsort(-np.linalg.norm(sides.mean(axis=1) - eye, axis=1), kind="stable")
    return Panes(sides[order].reshape(-1, 3), colors[order])
