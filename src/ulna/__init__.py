"""Robot-arm kinematics and collision checking in pure Python, at SIMD speed."""

from ulna.collision.report import Pair, Report
from ulna.collision.world import World
from ulna.errors import (
    DescriptionError,
    FileError,
    GeometryError,
    InputError,
    SingularityError,
    UlnaError,
    UnknownNameError,
)
from ulna.ik.result import IKResult
from ulna.model.convex_mesh import ConvexMesh
from ulna.model.pose import pose
from ulna.model.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from ulna.robot import Robot, load

__version__ = "0.1.0"

__all__ = [
    "Box",
    "Capsule",
    "ConvexMesh",
    "Cylinder",
    "DescriptionError",
    "FileError",
    "GeometryError",
    "HalfSpace",
    "IKResult",
    "InputError",
    "Mesh",
    "Pair",
    "Report",
    "Robot",
    "SingularityError",
    "Sphere",
    "UlnaError",
    "UnknownNameError",
    "World",
    "load",
    "pose",
]
