"""Computes a map of the poses that a robot reaches, or the missing part of one."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, Never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.scene_file import world_to_json
from ulna.collision.world import World
from ulna.description.arrays import as_count, as_switch
from ulna.errors import FileError, InputError, refuse_unknown
from ulna.ik.closed_form.closed_form import closed_form_of
from ulna.ik.problem import refuse_immovable
from ulna.ik.task import Task, as_task
from ulna.kinematics.reach import reach_of
from ulna.reachability.grid import Grid
from ulna.reachability.map import ReachabilityMap
from ulna.reachability.model import robot_to_json
from ulna.reachability.run import DaskWorkers, ThreadWorkers, locked, run
from ulna.reachability.specification import Specification
from ulna.reachability.store import create, read_specification, remove_partial_files, zarr_package
from ulna.robot import Robot


def reachability_map(
    robot: Robot,
    path: str | Path,
    *,
    voxel: float,
    orientations: int,
    bounds: ArrayLike | None = None,
    world: World | None = None,
    link: str | None = None,
    task: Task | str = "pose",
    keep_clearance: bool = False,
    keep_solutions: bool = False,
    keep_payload: bool = False,
    client: Any = None,
    resume: bool = False,
    seed: int = 0,
    position_tolerance: float = 1e-5,
    rotation_tolerance: float = 1e-5,
    max_iterations: int = 400,
    progress: Callable[[int, int], object] | None = None,
    **unknown: Never,
) -> ReachabilityMap:
    """Compute which poses a robot reaches, and how well: inverse kinematics in every voxel, in every orientation.

    The map is a Zarr group of Zarr format 3 on disk, which ``xarray.open_zarr`` opens too (docs/reachability.md lists its
    variables). It grows chunk by chunk. After any interruption, ``resume=True`` continues it, with the same bits in the end.

    Args:
        robot: The robot. Collision shapes that are meshes need ``with_convex_hulls()`` first, if a world is given.
        path: The folder of the map, on a disk that all workers see under this path.
        voxel: The edge of a voxel [m].
        orientations: The number of orientations to try in each voxel, spread evenly over SO(3).
        bounds: The lowest and the highest corner in the robot's base frame [m], shape (2, 3); everything within the arm's length
            unless given.
        world: Configurations in collision with it, or with the robot itself, do not count. Without a world, collisions are not
            checked. An empty ``World()`` checks the robot against itself.
        link: The link to bring to the poses; the robot's tip unless given.
        task: The components of a pose to reach; see ``Robot.inverse_kinematics``.
        keep_clearance: Store the distance of the solution from the nearest obstacle, or from self-collision [m].
        keep_solutions: Store the joint positions of the solution.
        keep_payload: Store the largest mass at the link's origin that the motors hold still [kg], over all known solutions.
        client: A ``dask.distributed.Client``, whose cluster computes the chunks. Threads of this process unless given.
        resume: Continue the map at ``path``. If there is no map yet, begin one; if it is complete, do nothing.
        seed: Seed of the searches' random starts.
        position_tolerance: Maximum distance that counts as reached [m].
        rotation_tolerance: Maximum angle that counts as reached [rad].
        max_iterations: Steps from all starts of one pose together. A pose not reached within them has the status ``budget
            spent``. From 16 000 on the reason is found, which takes some twenty times as long.
        progress: Function to call with the number of poses done and the number of all poses.
        **unknown: No other argument is allowed.

    Returns:
        The ``ReachabilityMap``.

    Raises:
        InputError: An argument is invalid, or ``resume`` finds a map of something else; the message lists the differences.
        UnknownNameError: There is no such link.
        GeometryError: Collisions are to be checked, and the robot has no collision shapes, or some that cannot be checked.
        InertiaError: The payload is to be stored, and a link that moves and has a shape has no inertia.
        FileError: There is a map already and ``resume`` is not given; the disk is full; the folder cannot be written to; another
            process is writing to the map.
        ClusterError: The cluster is lost. Finished chunks are kept.
        MissingExtraError: The extra ``reach`` is not installed.

    Example:
        >>> import tempfile, ulna
        >>> planar = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
        >>> with tempfile.TemporaryDirectory() as folder:  # with the extra reach
        ...     box = [(-2.5, -2.5, -0.5), (2.5, 2.5, 0.5)]
        ...     found = ulna.reachability_map(
        ...         planar, f"{folder}/planar.zarr", voxel=1.0, orientations=1, bounds=box, task="position"
        ...     )
        ...     print(found.summary.reached, "of", found.summary.poses)
        13 of 25
    """
    if unknown:
        refuse_unknown("reachability_map", unknown)
    zarr_package()
    where, is_resumed = _as_path(path), as_switch("resume", resume)
    search = task, seed, position_tolerance, rotation_tolerance, max_iterations
    specification = _specification(
        robot, link, (voxel, orientations, bounds), world, search, (keep_clearance, keep_solutions, keep_payload)
    )
    workers = ThreadWorkers() if client is None else DaskWorkers(client)
    try:
        with locked(where):
            _begin(where, specification, robot, resume=is_resumed)
            run(where, read_specification(where).grid, workers, progress)
    finally:
        workers.cancel()
    return ReachabilityMap.open(where, robot=robot)


def default_bounds(robot: Robot, link: str) -> NDArray[np.float64]:
    """The cube around all positions that a link can reach by the arm's length [m], shape (2, 3)."""
    reach = reach_of(robot.tree.chain(link), robot.lower, robot.upper)
    if reach is None or not np.isfinite(reach.max_origin_distance):
        raise InputError("bounds", "are needed: the length of this robot does not bound where its tip may be")
    return np.stack([reach.base_point - reach.max_origin_distance, reach.base_point + reach.max_origin_distance])


def _specification(
    robot: Robot, link: str | None, grid: tuple, world: World | None, search: tuple, stored: tuple
) -> Specification:
    """The specification of the requested map; ``grid``, ``search`` and ``stored`` are arguments, validated here."""
    if not isinstance(robot, Robot):
        raise InputError("robot", f"{type(robot).__name__}; an ulna.Robot is expected")
    refuse_immovable(robot.tree)
    if link is None and robot.tip is None:
        raise InputError(
            "link", f"{robot.name!r} has several tips; name one of {', '.join(robot.tree.leaves)}, or any other link"
        )
    link, (voxel, orientations, bounds) = robot.tree.link_or_tip(link), grid
    task, seed, position_tolerance, rotation_tolerance, max_iterations = search
    clearance, solutions, payload = map(as_switch, ("keep_clearance", "keep_solutions", "keep_payload"), stored)
    poses = Grid.within(default_bounds(robot, link) if bounds is None else bounds, voxel, orientations)
    is_checked = world is not None or clearance
    if is_checked:
        robot.signed_distance(robot.home, world)  # or raise the error now
    if payload:
        robot.payload(robot.home, link=link)  # or raise the error now
    text = robot.description.text
    return Specification(
        robot=robot.name,
        model=robot_to_json(robot, checked=is_checked, weighed=payload),
        urdf=hashlib.sha256(text.encode()).hexdigest() if text else "",
        source=robot.description.source,
        link=link,
        grid=poses,
        task=as_task(task),
        scene=None if world is None else world_to_json(world),
        seed=as_count("seed", seed),
        position_tolerance=position_tolerance,
        rotation_tolerance=rotation_tolerance,
        max_iterations=as_count("max_iterations", max_iterations),
        clearance=clearance,
        solutions=solutions,
        branches=_counts_branches(robot, link, as_task(task)),
        version=version("ulna"),
        payload=payload,
    )


def _counts_branches(robot: Robot, link: str, task: Task) -> bool:
    """Whether a closed form proves, for nearly every pose, that its finitely many solutions are all of them."""
    form = closed_form_of(robot.tree, link, task=task)
    return form is not None and form.is_exact and form.held is None


def _begin(path: Path, requested: Specification, robot: Robot, *, resume: bool) -> None:
    if not os.path.lexists(path):
        create(path, requested, robot.joint_names)
        return
    if not resume:
        raise FileError(str(path), "there is a file or folder of this name already; resume=True (--resume) continues a map")
    differing = read_specification(path).differences(requested)
    if differing:
        raise InputError("resume", f"the map at {path} differs from this call: {'; '.join(differing)} (there and here)")
    remove_partial_files(path)


def _as_path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InputError("path", f"{path!r} is no path")
    where = Path(path).absolute()  # type: ignore[arg-type]
    if not where.parent.is_dir():
        raise FileError(str(path), f"there is no folder {where.parent}")
    return where
