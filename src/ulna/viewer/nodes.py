"""Adds shapes to the scene of a page, as nodes whose colour and opacity can be changed."""

from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.clouds import Obstacle
from ulna.description.pose import quaternion_from_matrix
from ulna.description.shapes import Box, Cylinder, HalfSpace, Sphere
from ulna.viewer.palette import Color
from ulna.viewer.visuals import triangles

_GROUND = (4.0, 4.0, 0.004)  # the box that is drawn for a half-space [m]


def add_shape(
    scene: viser.SceneApi,
    name: str,
    shape: Obstacle,
    color: Color,
    opacity: float,
    T: NDArray[np.float64] | None = None,
    **look: Any,
) -> Any:
    """Add a shape at T_parent_shape, shape (4, 4); ``look`` are further options of viser."""
    T = np.eye(4) if T is None else T
    look |= {"opacity": opacity, "position": T[:3, 3], "wxyz": quaternion_from_matrix(T)}
    match shape:
        case Box(extents):
            return scene.add_box(name, color, extents, **look)
        case Sphere(radius):
            return scene.add_icosphere(name, radius, color, **look)
        case Cylinder(radius, length):
            return scene.add_cylinder(name, radius, length, color, **look)
        case HalfSpace():
            look["position"] = T[:3, 3] - T[:3, 2] * _GROUND[2] / 2
            return scene.add_box(name, color, _GROUND, **look)
        case _:
            return add_triangles(scene, name, triangles(shape), color, **look)


def add_triangles(scene: viser.SceneApi, name: str, mesh: Any, color: Color, **look: Any) -> viser.MeshHandle:
    """Add a mesh of trimesh in one colour."""
    return scene.add_mesh_simple(name, np.asarray(mesh.vertices), np.asarray(mesh.faces), color=color, flat_shading=True, **look)
