"""Opens a map and reads from it: scores of poses, slices, differences from another map."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.scene_file import world_from_json
from ulna.collision.world import World
from ulna.description.pose import as_pose
from ulna.errors import InputError, count_of, needs_extra
from ulna.ik.result import IKResult
from ulna.ik.task import Task
from ulna.reachability.grid import Grid, Region, nearest_orientation
from ulna.reachability.model import robot_from_json, robot_to_json
from ulna.reachability.placement import BasePlacement, base_placements, world_around_base
from ulna.reachability.specification import Specification
from ulna.reachability.store import (
    check_chunks,
    open_arrays,
    read_attributes,
    read_specification,
    read_verdicts,
    unreadable,
    zarr_package,
)
from ulna.reachability.verdicts import NOT_COMPUTED, NUMBERS, REACHED
from ulna.robot import Robot

Array = NDArray[np.float64]
_FLOATS = np.float32
_STEPS = 1600  # of the search for one target of a placement: four times as many as for the map


class Summary(NamedTuple):
    """Counts of a map's poses.

    Attributes:
        poses: All poses of the map.
        computed: Computed poses.
        reached: Reached poses.
        statuses: The number of poses with each status, by its name.
    """

    poses: int
    computed: int
    reached: int
    statuses: dict[str, int]


class MapDifference(NamedTuple):
    """The differences of two maps with the same grid.

    Attributes:
        both: Poses that both reach.
        only_first: Poses that only the first reaches.
        only_second: Poses that only the second reaches.
        neither: Poses that neither reaches.
        share: The share of reached orientations in the second minus that in the first, shape (z, y, x).
    """

    both: int
    only_first: int
    only_second: int
    neither: int
    share: Any


class ReachabilityMap:
    """A map on disk, from ``ulna.reachability_map`` or ``ReachabilityMap.open``. It may still be growing.

    Data are read at their first use, and cached. To see later chunks of a growing map, open it again.
    """

    path: Path
    """The folder of the Zarr group."""
    grid: Grid
    """The voxels and the number of orientations."""
    robot: Robot
    """The robot stored in the map."""
    link: str
    """The link brought to the poses."""
    task: Task
    """The components of a pose that had to be reached."""

    def __init__(self, path: Path, specification: Specification, robot: Robot) -> None:
        self.path, self.grid, self.robot = path, specification.grid, robot
        self.link, self.task, self._specification = specification.link, specification.task, specification
        self._reached: Any = open_arrays(path, specification, robot.n_dof)["reached"]

    @classmethod
    def open(cls, path: str | Path, *, robot: Robot | None = None) -> ReachabilityMap:
        """Open the map at a path.

        Args:
            path: The folder of the map.
            robot: The map's robot, to have its visuals; the robot stored in the map, which has none, unless given.

        Raises:
            FileError: There is no map, or it cannot be read.
            DescriptionError: It is not a map, or a map of another format.
            InputError: The map is of another robot.
            MissingExtraError: The extra ``reach`` is not installed.
        """
        zarr_package()
        where = Path(path)
        specification = read_specification(where)
        stored_robot = robot_from_json(specification.model)
        if robot is not None:
            is_checked = specification.scene is not None or specification.clearance
            if robot_to_json(robot, checked=is_checked, weighed=specification.payload) != specification.model:
                raise InputError(
                    "robot",
                    f"the map at {where} is of another robot ({specification.robot}), or of an earlier version of this one",
                )
        return cls(where, specification, robot or stored_robot)

    # ---- what is in it -------------------------------------------------------------------------------------------------

    @property
    def world(self) -> World | None:
        """The world of the map, in the robot's base frame; None if collisions were not checked."""
        scene = self._specification.scene
        return None if scene is None else world_from_json(scene, "the map's scene")

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the Zarr group."""
        return read_attributes(self.path)

    @cached_property
    def data(self) -> Any:
        """The whole map as an ``xarray.Dataset``, as from ``xarray.open_zarr``: its values are read when needed."""
        return _xarray().open_zarr(self.path, consolidated=False)

    @cached_property
    def summary(self) -> Summary:
        """The numbers of computed and reached poses, and the statuses of the others."""
        counts = np.zeros(256, dtype=np.int64)
        for _, reached in self._chunks():
            counts += np.bincount(reached.ravel().view(np.uint8), minlength=256)
        statuses = {str(status): int(counts[number]) for status, number in NUMBERS.items() if counts[number]}
        missing = int(counts[NOT_COMPUTED % 256])
        return Summary(self.grid.n_poses, self.grid.n_poses - missing, int(counts[REACHED]), statuses)

    @property
    def is_whole(self) -> bool:
        """Whether every pose is computed."""
        return self.summary.computed == self.summary.poses

    @cached_property
    def share(self) -> Any:
        """The share of reached orientations in each voxel, 0 to 1; NaN where some are not computed.

        An ``xarray.DataArray`` with the dimensions (z, y, x) and the centers of the voxels [m].
        """
        values = np.zeros(self.grid.shape, dtype=_FLOATS)
        for region, reached in self._chunks():
            part = (reached == REACHED).sum(axis=-1).astype(_FLOATS)
            part[(reached == NOT_COMPUTED).any(axis=-1)] = np.nan
            values[region[:3]] += part
        values /= self.grid.orientations
        axes = dict(zip("zyx", self.grid.axes, strict=True))
        return _xarray().DataArray(values, coords=axes, dims=("z", "y", "x"), name="share", attrs={"units": "1"})

    # ---- single poses --------------------------------------------------------------------------------------------------

    def score(self, T: ArrayLike) -> Any:
        """The share of reached orientations in the voxel of a pose, 0 to 1.

        Args:
            T: T_base_tip, shape (..., 4, 4).

        Returns:
            A number for one pose, else shape (...,): 0 outside the map, NaN where it is not computed yet.

        Raises:
            InputError: T is not a pose.
        """
        poses = as_pose(T)
        index, inside = self.grid.voxel_of(poses[..., :3, 3])
        found = np.where(inside, self.share.values[tuple(np.moveaxis(index, -1, 0))], 0.0)
        return float(found) if poses.ndim == 2 else found

    def reached(self, T: ArrayLike) -> Any:
        """Whether the map's nearest pose is reached: the center of the voxel, in the nearest of its orientations.

        ``robot.inverse_kinematics`` has the exact result for a pose. The map's pose is up to half a voxel's diagonal away.

        Args:
            T: T_base_tip, shape (..., 4, 4).

        Returns:
            A bool for one pose, else shape (...,): False outside the map, and where it is not computed yet.

        Raises:
            InputError: T is not a pose.
        """
        poses = as_pose(T)
        flat = poses.reshape(-1, 4, 4)
        index, inside = self.grid.voxel_of(flat[:, :3, 3])
        columns = (*np.moveaxis(index, -1, 0), nearest_orientation(flat, self.grid.wxyz))
        found = inside & (self._verdicts_at(columns) == REACHED) if len(flat) else inside
        return bool(found[0]) if poses.ndim == 2 else found.reshape(poses.shape[:-2])

    def solutions_at(self, point: ArrayLike) -> IKResult:
        """Inverse kinematics for every orientation of the voxel at a point [m], shape (3,).

        The results are those of the map's own search.

        Raises:
            InputError: The point is outside the map.
        """
        place = np.asarray(point, dtype=np.float64)
        index, inside = self.grid.voxel_of(place)
        if place.shape != (3,) or not inside:
            raise InputError("point", f"{point!r} is not within the map")
        z, y, x = (slice(int(k), int(k) + 1) for k in index)
        return self.solve(self.grid.targets((z, y, x, slice(None))), self.world)

    def solve(self, T: ArrayLike, world: World | None = None, *, max_iterations: int | None = None) -> IKResult:
        """Inverse kinematics with the map's link, task, tolerances and seed, for targets T_base_tip, shape (..., 4, 4).

        Raises:
            InputError: T is not a pose.
            GeometryError: A world is given, and the robot's collisions cannot be checked.
        """
        search = self._specification.search
        search["max_iterations"] = max_iterations or search["max_iterations"]
        return self.robot.inverse_kinematics(T, world=world, **search)

    # ---- all of it -----------------------------------------------------------------------------------------------------

    def slice(self, **where: float) -> Any:
        """The share of reached orientations on a plane of voxels: ``slice(z=0.4)`` has the dimensions (y, x).

        An ``xarray.DataArray``, like ``share``.

        Raises:
            InputError: Not exactly one of x, y and z is given [m], or the plane misses the map.
        """
        if len(where) != 1 or not set(where) <= {"x", "y", "z"}:
            raise InputError("slice", f"{where!r}; one of x=, y= and z= is expected, in meters")
        ((axis, value),) = where.items()
        centers = self.grid.axes["zyx".index(axis)]
        if not centers[0] - self.grid.voxel / 2 <= value <= centers[-1] + self.grid.voxel / 2:
            raise InputError(axis, f"{value!r}; the map is from {centers[0]:.4g} to {centers[-1]:.4g} m")
        return self.share.sel({axis: value}, method="nearest")

    def compare(self, other: ReachabilityMap) -> MapDifference:
        """The differences to another map with the same grid: of another robot or tool, or in another world.

        Only poses that both maps have computed count.

        Raises:
            InputError: The grids differ.
        """
        if self.grid != other.grid:
            raise InputError("other", f"its grid differs: {other.grid}, here {self.grid}")
        counts = np.zeros(4, dtype=np.int64)
        for (_, ours), (_, theirs) in zip(self._chunks(), other._chunks(), strict=True):
            both_known = (ours != NOT_COMPUTED) & (theirs != NOT_COMPUTED)
            counts += np.bincount(2 * (ours[both_known] == REACHED) + (theirs[both_known] == REACHED), minlength=4)
        neither, only_second, only_first, both = counts.tolist()
        return MapDifference(both, only_first, only_second, neither, other.share - self.share)

    def base_placements(
        self,
        targets: ArrayLike,
        *,
        free_dofs: Iterable[str] = ("x", "y", "yaw"),
        world: World | None = None,
        T_world_base: ArrayLike | None = None,
        bounds: ArrayLike | None = None,
        yaw_steps: int = 24,
        most: int = 10,
        tries: int = 500,
    ) -> tuple[BasePlacement, ...]:
        """Placements of the base from which all targets are reached, the best first.

        The map ranks candidates on a grid of one voxel: by the share of reached orientations around the worst target, then around
        all targets. The best ``tries`` candidates are checked exactly, by inverse kinematics for every target, and failures are
        dropped. So every returned placement reaches all targets; a placement between the candidates may be missed.

        Args:
            targets: T_world_tip, shape (n, 4, 4).
            free_dofs: The degrees of freedom of the base to choose, of ``"x"``, ``"y"``, ``"z"`` and ``"yaw"``.
            world: The obstacles in the frame of ``targets``. The objects of the map's own world move with the base.
            T_world_base: The base along its fixed degrees of freedom, shape (4, 4); the origin unless given.
            bounds: The lowest and the highest corner of the positions of the base [m], shape (2, 3).
            yaw_steps: The number of directions in a turn.
            most: The maximum number of placements to return.
            tries: The number of candidates to check exactly.

        Raises:
            InputError: The targets are not poses, there are none, or another argument is invalid.
            GeometryError: A world is given, and the robot's collisions cannot be checked.
        """

        def solve(T_base_tip: Array, T_base_world: Array) -> tuple[Array, Array] | None:
            result = self.solve(T_base_tip, world_around_base(self.world, world, T_base_world), max_iterations=_STEPS)
            return (result.q, self.robot.manipulability(result.q, link=self.link)) if np.all(result.success) else None

        free = tuple(free_dofs)
        return base_placements(self.grid, self.verdicts, solve, targets, free, T_world_base, bounds, yaw_steps, most, tries)

    @cached_property
    def verdicts(self) -> NDArray[np.bool_]:
        """Whether each pose is reached, in memory: shape (z, y, x, orientation), one byte a pose."""
        found = np.zeros((*self.grid.shape, self.grid.orientations), dtype=np.bool_)
        for region, reached in self._chunks():
            found[region] = reached == REACHED
        return found

    def _chunks(self) -> Iterator[tuple[Region, NDArray[np.int8]]]:
        for chunk in range(self.grid.n_chunks):
            yield self.grid.region(chunk), read_verdicts(self.path, self._reached, self.grid, chunk)

    def _verdicts_at(self, columns: tuple[NDArray[np.int64], ...]) -> NDArray[np.int8]:
        """The verdicts of poses, by their indices along z, y, x and the orientations."""
        places = {tuple(place) for place in (np.stack(columns, axis=-1) // self.grid.chunk_shape).tolist()}
        check_chunks(self.path, self.grid, places)
        try:
            return self._reached.vindex[columns]
        except Exception as error:  # noqa: BLE001 -- zarr and its codecs raise any exception
            raise unreadable(self.path, error) from None

    def __repr__(self) -> str:
        z, y, x = self.grid.shape
        size = f"{x} x {y} x {z} voxels of {self.grid.voxel:g} m, {count_of(self.grid.orientations, 'orientation')}"
        return f"<ReachabilityMap of {self._specification.robot!r}: {size}>"


def _xarray() -> Any:
    with needs_extra("a reachability map", "reach", "xarray"):
        import xarray  # noqa: PLC0415 -- needs the extra
    return xarray
