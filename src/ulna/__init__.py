"""Robot-arm kinematics and collision checking in pure Python, at SIMD speed."""

from ulna.collision.report import Pair, Report
from ulna.collision.scene_file import load_world, save_world
from ulna.collision.world import World
from ulna.comparison.compare import compare
from ulna.comparison.result import Comparison
from ulna.description.clouds import HeightMap, PointCloud
from ulna.description.convex_mesh import ConvexMesh
from ulna.description.pose import pose
from ulna.description.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from ulna.dh.table import DHTable
from ulna.errors import (
    ClusterError,
    DescriptionError,
    DescriptionWarning,
    DeviceError,
    FileError,
    GeometryError,
    InputError,
    MissingExtraError,
    SingularityError,
    UlnaError,
    UnknownNameError,
)
from ulna.ik.closed_form.result import IKSolutions
from ulna.ik.following.result import Ending, FollowedPath, PathStatus
from ulna.ik.result import IKResult, Status
from ulna.ik.task import Task
from ulna.inspection.inspect import inspect
from ulna.inspection.result import Finding, Inspection, Severity
from ulna.planning.plan import Plan
from ulna.planning.plan_status import PlanStatus
from ulna.planning.trajectory import Trajectory
from ulna.reachability.map import ReachabilityMap
from ulna.reachability.reachability_map import reachability_map
from ulna.robot import Robot, load
from ulna.viewer.open_page import view

__version__ = "0.1.0"
__all__ = [
    "Box",
    "Capsule",
    "ClusterError",
    "Comparison",
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
    "HeightMap",
    "IKResult",
    "IKSolutions",
    "InputError",
    "Inspection",
    "Mesh",
    "MissingExtraError",
    "Pair",
    "PathStatus",
    "Plan",
    "PlanStatus",
    "PointCloud",
    "ReachabilityMap",
    "Report",
    "Robot",
    "Severity",
    "SingularityError",
    "Sphere",
    "Status",
    "Task",
    "Trajectory",
    "UlnaError",
    "UnknownNameError",
    "World",
    "compare",
    "inspect",
    "load",
    "load_world",
    "pose",
    "reachability_map",
    "save_world",
    "view",
]
