"""Robot-arm kinematics and collision checking in pure Python, at SIMD speed.

Each public name is imported at its first use: a program that only computes poses does not import the viewer.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ulna.collision.clouds import PointCloud
    from ulna.collision.grids import HeightMap, VoxelGrid
    from ulna.collision.report import Pair, Report
    from ulna.collision.scene_file import load_world, save_world
    from ulna.collision.world import World
    from ulna.description.controllers import pose_as, pose_from
    from ulna.description.pose import pose
    from ulna.description.robot_description import Inertia
    from ulna.description.shapes import Box, Capsule, ConvexMesh, Cylinder, HalfSpace, Mesh, Sphere
    from ulna.dh.table import DHTable
    from ulna.engine.threads import threads
    from ulna.errors import (
        ArmConnectionError,
        ArmError,
        ClusterError,
        CompilerWarning,
        DescriptionError,
        DescriptionWarning,
        DeviceError,
        FileError,
        GeometryError,
        InertiaError,
        InputError,
        MissingExtraError,
        MissingROSError,
        SingularityError,
        TruthError,
        UlnaError,
        UnitWarning,
        UnknownArgumentError,
        UnknownNameError,
    )
    from ulna.ik.followed_path import Ending, FollowedPath, PathStatus
    from ulna.ik.reason import Reason
    from ulna.ik.result import IKResult, Status
    from ulna.ik.solutions import IKSolutions
    from ulna.ik.task import Task
    from ulna.inspection.compare import compare
    from ulna.inspection.inspect import inspect
    from ulna.inspection.result import Comparison, Finding, Inspection, Severity
    from ulna.planning.hand import HandLimits
    from ulna.planning.keep import Keep
    from ulna.planning.plan import Plan, PlanStatus
    from ulna.planning.trajectory import Trajectory
    from ulna.reachability.map import ReachabilityMap
    from ulna.reachability.reachability_map import reachability_map
    from ulna.robot import Robot, load
    from ulna.servo.command import Command, CommandStatus
    from ulna.servo.servo import Servo
    from ulna.viewer.open_page import view

__version__ = "0.1.0"
__all__ = [
    "ArmConnectionError",
    "ArmError",
    "Box",
    "Capsule",
    "ClusterError",
    "Command",
    "CommandStatus",
    "Comparison",
    "CompilerWarning",
    "ConvexMesh",
    "Cylinder",
    "DHTable",
    "DescriptionError",
    "DescriptionWarning",
    "DeviceError",
    "Ending",
    "FileError",
    "Finding",
    "FollowedPath",
    "GeometryError",
    "HalfSpace",
    "HandLimits",
    "HeightMap",
    "IKResult",
    "IKSolutions",
    "Inertia",
    "InertiaError",
    "InputError",
    "Inspection",
    "Keep",
    "Mesh",
    "MissingExtraError",
    "MissingROSError",
    "Pair",
    "PathStatus",
    "Plan",
    "PlanStatus",
    "PointCloud",
    "ReachabilityMap",
    "Reason",
    "Report",
    "Robot",
    "Servo",
    "Severity",
    "SingularityError",
    "Sphere",
    "Status",
    "Task",
    "Trajectory",
    "TruthError",
    "UlnaError",
    "UnitWarning",
    "UnknownArgumentError",
    "UnknownNameError",
    "VoxelGrid",
    "World",
    "compare",
    "inspect",
    "load",
    "load_world",
    "pose",
    "pose_as",
    "pose_from",
    "reachability_map",
    "save_world",
    "threads",
    "view",
]

# The public names of each module.
_HOMES = {
    "ulna.collision.report": ("Pair", "Report"),
    "ulna.collision.scene_file": ("load_world", "save_world"),
    "ulna.collision.world": ("World",),
    "ulna.collision.clouds": ("PointCloud",),
    "ulna.collision.grids": ("HeightMap", "VoxelGrid"),
    "ulna.description.controllers": ("pose_as", "pose_from"),
    "ulna.description.pose": ("pose",),
    "ulna.description.shapes": ("Box", "Capsule", "ConvexMesh", "Cylinder", "HalfSpace", "Mesh", "Sphere"),
    "ulna.dh.table": ("DHTable",),
    "ulna.engine.threads": ("threads",),
    "ulna.description.robot_description": ("Inertia",),
    "ulna.errors": (
        "ArmConnectionError",
        "ArmError",
        "ClusterError",
        "CompilerWarning",
        "DescriptionError",
        "DescriptionWarning",
        "DeviceError",
        "FileError",
        "GeometryError",
        "InertiaError",
        "InputError",
        "MissingExtraError",
        "MissingROSError",
        "SingularityError",
        "TruthError",
        "UlnaError",
        "UnitWarning",
        "UnknownArgumentError",
        "UnknownNameError",
    ),
    "ulna.ik.solutions": ("IKSolutions",),
    "ulna.ik.followed_path": ("Ending", "FollowedPath", "PathStatus"),
    "ulna.ik.reason": ("Reason",),
    "ulna.ik.result": ("IKResult", "Status"),
    "ulna.ik.task": ("Task",),
    "ulna.inspection.compare": ("compare",),
    "ulna.inspection.inspect": ("inspect",),
    "ulna.inspection.result": ("Comparison", "Finding", "Inspection", "Severity"),
    "ulna.planning.hand": ("HandLimits",),
    "ulna.planning.keep": ("Keep",),
    "ulna.planning.plan": ("Plan", "PlanStatus"),
    "ulna.planning.trajectory": ("Trajectory",),
    "ulna.reachability.map": ("ReachabilityMap",),
    "ulna.reachability.reachability_map": ("reachability_map",),
    "ulna.robot": ("Robot", "load"),
    "ulna.servo.command": ("Command", "CommandStatus"),
    "ulna.servo.servo": ("Servo",),
    "ulna.viewer.open_page": ("view",),
}

_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import a public name from its module, or a subpackage."""
    try:
        found = getattr(import_module(_HOME[name]), name) if name in _HOME else import_module(f"ulna.{name}")
    except ModuleNotFoundError as error:
        if error.name != f"ulna.{name}":
            raise
        raise AttributeError(f"module 'ulna' has no attribute {name!r}") from None
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__})
