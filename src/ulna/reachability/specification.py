"""Specifies a map: everything that its bits depend on, stored as its attributes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ulna.description.file_bytes import json_value
from ulna.errors import DescriptionError
from ulna.ik.options import Options
from ulna.ik.task import Task
from ulna.reachability.grid import Grid
from ulna.reachability.model import fingerprint

_SEARCH = "seed", "position_tolerance", "rotation_tolerance", "max_iterations"  # fields, and attributes of the same names
_PAYLOAD = "payload_kept"  # missing in older maps
FORMAT = 2  # of the attributes; another number is an error
_KINDS = {
    str: ("robot", "robot_model", "urdf_sha256", "robot_source", "tool", "task", "scene", "ulna_version"),
    bool: ("clearance_kept", "solutions_kept", "branches_counted", _PAYLOAD),
    list: ("low", "voxels_zyx"),
}  # numbers are validated at their use


@dataclass(frozen=True)
class Specification:
    """Everything that the bits of a map depend on.

    Attributes:
        robot: The robot's name.
        model: The robot as text (``reachability.model``).
        urdf: The SHA-256 of the description's text, for the record; empty for a robot made without one.
        source: The source of the robot, for the record.
        link: The link brought to the poses.
        grid: The poses.
        task: The components of a pose to reach.
        scene: The text of the world's scene file; None if collisions are not checked.
        seed: Seed of the random starts.
        position_tolerance: [m].
        rotation_tolerance: [rad].
        max_iterations: Steps from all starts of one pose together.
        clearance: Whether the distance to the nearest obstacle is stored.
        solutions: Whether the joint positions are stored.
        branches: Whether the arm has a closed form, which counts the solutions of each pose.
        version: Ulna's.
        payload: Whether the largest payload is stored.
    """

    robot: str
    model: str
    urdf: str
    source: str
    link: str
    grid: Grid
    task: Task
    scene: str | None
    seed: int
    position_tolerance: float
    rotation_tolerance: float
    max_iterations: int
    clearance: bool
    solutions: bool
    branches: bool
    version: str
    payload: bool = False

    def __post_init__(self) -> None:
        Options(task=self.task, **self._numbers).checked()

    @property
    def search(self) -> dict[str, Any]:
        """The keyword arguments of ``Robot.inverse_kinematics``."""
        return {"link": self.link, "task": self.task, **self._numbers}

    @property
    def _numbers(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _SEARCH}

    def attributes(self) -> dict[str, Any]:
        """The attributes of a Zarr group: numbers, texts, lists."""
        grid = self.grid
        return {
            "ulna_reachability_map": FORMAT,
            "robot": self.robot,
            "robot_sha256": fingerprint(self.model),
            "urdf_sha256": self.urdf,
            "robot_source": self.source,
            "tool": self.link,
            "voxel": grid.voxel,
            "low": list(grid.low),
            "voxels_zyx": list(grid.shape),
            "orientations": grid.orientations,
            "chunk_poses": grid.chunk_poses,
            "task": json.dumps({"slack": self.task.slack, "axis": self.task.axis}),
            "scene_sha256": "" if self.scene is None else fingerprint(self.scene),
            **self._numbers,
            "clearance_kept": self.clearance,
            "solutions_kept": self.solutions,
            "branches_counted": self.branches,
            _PAYLOAD: self.payload,
            "ulna_version": self.version,
            "robot_model": self.model,
            "scene": "" if self.scene is None else self.scene,
        }

    @classmethod
    def of_attributes(cls, attributes: Mapping[str, Any], where: str) -> Specification:
        """The specification in a map's attributes; ``where`` names the map in messages."""
        if attributes.get("ulna_reachability_map") != FORMAT:
            raise DescriptionError("is not a reachability map that this version of Ulna reads", where)
        attributes = {_PAYLOAD: False, **attributes}
        try:
            _check_kinds(attributes)
            task = json_value(attributes["task"])
            grid = Grid(
                tuple(attributes["low"]),  # type: ignore[arg-type]
                attributes["voxel"],
                tuple(attributes["voxels_zyx"]),  # type: ignore[arg-type]
                attributes["orientations"],
                attributes["chunk_poses"],
            )
            texts = [attributes[name] for name in ("robot", "robot_model", "urdf_sha256", "robot_source", "tool")]
            names = *_SEARCH, "clearance_kept", "solutions_kept", "branches_counted", "ulna_version", _PAYLOAD
            search = [attributes[name] for name in names]
            made = Task(tuple(task["slack"]), tuple(task["axis"]))
            found = cls(*texts, grid, made, attributes["scene"] or None, *search)  # pyright: ignore[reportCallIssue]
        except (KeyError, TypeError, ValueError) as error:
            raise DescriptionError(f"an attribute of the map is missing or wrong: {error!s:.300}", where) from error
        if fingerprint(found.model) != attributes.get("robot_sha256"):
            raise DescriptionError("the map's robot is not the one that its hash names: the attributes were changed", where)
        return found

    def differences(self, other: Specification) -> list[str]:
        """The differences that affect the bits, in words: "robot", "voxel: 0.05 and 0.1" ..."""
        differences = []
        if self.model != other.model:
            differences.append(
                f"robot: {self.robot} and {other.robot}" if self.robot != other.robot else "robot: its description"
            )
        if self.scene != other.scene:
            differences.append("world")
        ours, theirs = self._compared(), other._compared()
        return differences + [f"{name}: {value} and {theirs[name]}" for name, value in ours.items() if value != theirs[name]]

    def _compared(self) -> dict[str, Any]:
        grid = self.grid
        return {
            "link": self.link,
            "voxel": grid.voxel,
            "bounds": (grid.low, grid.shape),
            "orientations": grid.orientations,
            "task": self.task,
            **self._numbers,
            "clearance": self.clearance,
            "solutions": self.solutions,
            "payload": self.payload,
            "version of Ulna": self.version,
        }


def _check_kinds(attributes: Mapping[str, Any]) -> None:
    for kind, names in _KINDS.items():
        for name in names:
            if not isinstance(attributes[name], kind):
                raise TypeError(f"{name}: {attributes[name]!r:.40} is not a {kind.__name__}")
