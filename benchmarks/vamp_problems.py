"""Reads the planning problems of VAMP's source distribution: ``resources/panda`` of ``vamp-planner``.

The 700 problems are those of MotionBenchMaker (Chamzas et al., IEEE RA-L 2022). VAMP replaces cylinders by capsules, and in the
problems called "box" by boxes; these worlds do too, unless ``exact`` is set.
"""

import re
import tarfile
import warnings
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

import ulna

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlanningProblem:
    """A start, a goal and the objects: name, kind, sizes and pose of each."""

    name: str
    index: int
    start: Array
    goal: Array
    objects: tuple

    def world(self, *, exact: bool = False) -> ulna.World:
        """The objects in VAMP's form, or the exact ones."""
        world = ulna.World()
        for k, (name, kind, sizes, T) in enumerate(self.objects):
            world.add(f"{k} {name}", _shape(kind, sizes, self.name, exact=exact), T)
        return world


def read_problems(folder: Path, joints: tuple[str, ...]) -> list[PlanningProblem]:
    """The problems of a robot, in the order of their names and numbers."""
    parts: dict[tuple[str, int], dict] = defaultdict(dict)
    with tarfile.open(folder / "problems.tar.bz2", "r:bz2") as archive:
        for member in archive.getmembers():
            file = archive.extractfile(member) if member.isfile() else None
            if file is not None:
                _, problem, name = member.name.split("/")
                key = problem.removesuffix(f"_{folder.name}"), int(re.findall(r"\d+", name)[0])
                parts[key]["scene" if "scene" in name else "request"] = yaml.load(file.read(), yaml.CSafeLoader)
    return [_problem(*key, parts[key], joints) for key in sorted(parts)]


def spheres(folder: Path) -> ulna.Robot:
    """The robot in VAMP's own spheres."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ulna.load(folder / f"{folder.name}_spherized.urdf", srdf=folder / f"{folder.name}.srdf")


def _problem(name: str, index: int, part: dict, joints: tuple[str, ...]) -> PlanningProblem:
    state = part["request"]["start_state"]["joint_state"]
    start = dict(zip(state["name"], state["position"], strict=False))
    goal = {one["joint_name"]: one["position"] for one in part["request"]["goal_constraints"][0]["joint_constraints"]}
    objects = []
    for one in part["scene"]["world"]["collision_objects"]:
        primitive = one["primitives"][0]
        T = (_pose(one["pose"]) if "pose" in one else np.eye(4)) @ _pose(one["primitive_poses"][0])
        objects.append((one["id"], primitive["type"], primitive["dimensions"], T))
    q = (np.array([values[joint] for joint in joints]) for values in (start, goal))
    return PlanningProblem(name, index, *q, tuple(objects))


def _pose(given: dict) -> Array:
    x, y, z, w = np.array(given["orientation"]) / np.linalg.norm(given["orientation"])
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = given["position"]
    return T


def _shape(kind: str, sizes: list[float], problem: str, *, exact: bool):
    if kind == "sphere":
        return ulna.Sphere(sizes[0])
    if kind == "box":
        return ulna.Box(tuple(sizes))
    length, radius = sizes
    if exact:
        return ulna.Cylinder(radius=radius, length=length)
    if problem == "box":
        return ulna.Box((2 * radius, 2 * radius, length))
    return ulna.Capsule(radius=radius, length=length)
