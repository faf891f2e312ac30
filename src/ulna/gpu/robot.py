"""Computes a robot's batches on an NVIDIA GPU."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import MIN_RESOLUTION, RESOLUTION
from ulna.collision.report import EdgeReport
from ulna.collision.world import World
from ulna.description.arrays import as_count, as_floats, as_number, as_switch
from ulna.errors import InputError
from ulna.gpu import device
from ulna.gpu.collision import distance_scratch, distances_of, overlaps_of
from ulna.gpu.device_array import as_own, as_shaped
from ulna.gpu.edges import EdgeTables, edge_tables, edges_of, near_for
from ulna.gpu.forces import GpuForces
from ulna.gpu.forward import frames_of, jacobians_of, poses_of
from ulna.gpu.queue import Queue
from ulna.gpu.rows import as_float64
from ulna.gpu.scenes import DeviceScene, DeviceScenes
from ulna.gpu.search import DeviceResult, DeviceSearch, OnHost, Tables, Unsolved, refuse_targets, tables_of
from ulna.gpu.single import in_single
from ulna.gpu.solutions import Asked, DeviceSolutions, all_solutions
from ulna.ik.options import Options, Request
from ulna.ik.problem import Query, refuse_immovable
from ulna.ik.reason import Explanation
from ulna.ik.solutions import IKSolutions
from ulna.ik.task import Task, as_task
from ulna.kinematics.jacobian import as_frame
from ulna.kinematics.positions import as_positions, flat, refuse_out_of_range, rows_of_both
from ulna.planning.batch import plan_many
from ulna.planning.plan import Plan
from ulna.planning.planner import PlanOptions
from ulna.planning.straight import plan_straight

Array = NDArray[np.float64]
_STRAIGHT_OPTIONS = frozenset({"clearance", "seed", "max_checks", "shorten", "time_limit"})  # of plans of one edge


class GpuRobot(GpuForces):
    """A robot whose batches are computed on a GPU by the kernels of the CPU; ``robot.on_gpu()`` makes it.

    Each method takes NumPy arrays and returns NumPy arrays. It also takes arrays on the device from CuPy, PyTorch, JAX or Numba,
    with ``__cuda_array_interface__`` or DLPack's ``__dlpack__``. They must be float64 and C-contiguous. Then it returns Numba's
    arrays on the device, which support both protocols, so the other libraries accept them without a copy. A chain of calls need
    not leave the device. ``out``, if a method has it, receives the results, and is returned: an array of their shape and type, on
    the side of q.

    All arrays on the device must be on the card that Numba had selected when the robot was made; others raise a ``DeviceError``.

    Results differ from those of the CPU by rounding.

    With ``float32`` the poses, Jacobians and collisions of boxes are computed in float32, for cards with few float64 units.
    Arrays on the device are float32 too (``docs/gpu.md`` states the accuracy). All other methods compute in float64, from either
    type, and return float64.
    """

    robot: OnHost
    """The robot on the CPU."""
    float32: bool
    """Whether it computes in float32, for methods that support it."""

    def __init__(self, robot: OnHost, *, float32: bool = False) -> None:
        refuse_immovable(robot.tree)
        device.require_device()
        self.robot, self.float32, self._tables = robot, as_switch("float32", float32), {}
        self._searches: dict[Any, Tables] = {}
        self._edges: dict[bool, tuple[DeviceScene, EdgeTables]] = {}  # by whether the robot is checked against itself
        self._scenes = DeviceScenes(robot._checker)  # noqa: SLF001 - a part of it
        self._queue = Queue()
        self._number: Any = np.float32 if self.float32 else np.float64

    def forward_kinematics(self, q: Any, *, link: str | None = None, out: Any = None) -> Any:
        """T_base_link, shape (..., 4, 4), for joint positions q [rad or m], shape (..., n_dof).

        Raises:
            InputError: q has another shape or an entry out of range, or the robot has several tips and no link is named.
            UnknownNameError: There is no such link.
        """
        return self._over_q(poses_of(self.robot.tree.n_dof), self._chain(link), q, (4, 4), out=out)

    def link_poses(self, q: Any, *, out: Any = None) -> Any:
        """T_base_link of all links in the order of ``link_names``, shape (..., n_links, 4, 4), for q of shape (..., n_dof).

        Raises:
            InputError: q has another shape or an entry out of range.
        """
        tree = self.robot.tree
        tables = self._kept(("frames",), lambda: (self._there(tree.joints), self._there(tree.link_frames)))
        n_frames = len(tree.link_frames)
        return self._over_q(frames_of(tree.n_dof, len(tree.joints), n_frames), tables, q, (n_frames, 4, 4), out=out)

    def jacobian(self, q: Any, *, link: str | None = None, expressed_in: str = "base", out: Any = None) -> Any:
        """The geometric Jacobian, shape (..., 6, n_dof), linear rows first; see ``Robot.jacobian``.

        Raises:
            InputError: q has another shape or an entry out of range; ``expressed_in`` is not a frame; or the robot has several
                tips and no link is named.
            UnknownNameError: There is no such link.
        """
        n_dof, frame = self.robot.tree.n_dof, as_frame(expressed_in)
        tables = self._kept(("jacobian", self._link(link), frame), lambda: (self._chain(link)[0], frame))
        return self._over_q(jacobians_of(n_dof), tables, q, (6, n_dof), out=out)

    def in_collision(self, q: Any, world: World | None = None, *, self_collision: bool = True, out: Any = None) -> Any:
        """Whether the robot touches itself or the world, bools of shape (...,); see ``Robot.in_collision``.

        Raises:
            InputError: q has another shape or an entry out of range, or there is nothing to check.
            GeometryError: The robot has no collision shapes, or one of a kind that cannot be checked.
        """
        return self._any_touch(q, world, self_collision, self._number, out)

    def signed_distance(self, q: Any, world: World | None = None, *, self_collision: bool = True, out: Any = None) -> Any:
        """The minimum signed distance [m], shape (...,); see ``Robot.signed_distance``.

        Raises:
            InputError: As ``in_collision``.
            GeometryError: As ``in_collision``.
        """
        n = prod(np.shape(q)[:-1])
        scene = self._scenes.of(world, self_collision, np.float64, self._queue.stream)
        scratch, at_most = distance_scratch(scene, n, self._queue.stream)
        return self._over_q(
            distances_of(*scene.sizes), (*scene.tables, *scratch), q, (), number=np.float64, at_most=at_most, out=out
        )

    def edge_in_collision(
        self,
        q_a: Any,
        q_b: Any,
        world: World | None = None,
        *,
        self_collision: bool = True,
        resolution: float = RESOLUTION,
    ) -> EdgeReport:
        """Check straight lines from q_a to q_b, shape (..., n_dof) each, for collisions; see ``Robot.edge_in_collision``.

        Returns:
            An ``EdgeReport``. Its arrays are on the device if q_a and q_b are; a single edge has Python's own numbers.

        Raises:
            InputError: As ``Robot.edge_in_collision``; or q_a and q_b are not on the same side.
            GeometryError: As ``in_collision``.
        """
        resolution = as_number("resolution", resolution, MIN_RESOLUTION, f"a length of at least {MIN_RESOLUTION:g} m")
        return self._check_edges(q_a, q_b, world, self_collision, (resolution, 0.0))

    def _check_edges(
        self, q_a: Any, q_b: Any, world: World | None, self_collision: bool, lengths: tuple[float, float]
    ) -> EdgeReport:
        """``edge_in_collision``. lengths: the resolution, and the margin from objects of the world [m]."""
        queue, tree = self._queue, self.robot.tree
        a, b = as_own("q_a", q_a, queue.stream), as_own("q_b", q_b, queue.stream)
        stays = device.is_on_device(a)
        if stays != device.is_on_device(b) or (stays and tuple(a.shape) != tuple(b.shape)):
            raise InputError("q_b", "q_a and q_b have to be both on the host, or both on the device with the same shape")
        if stays:
            batch, *rows = tuple(a.shape[:-1]), self._wide_rows("q_a", a, tree.q_shape), self._wide_rows("q_b", b, tree.q_shape)
        else:
            starts, ends = as_positions(a, tree, "q_a"), as_positions(b, tree, "q_b")
            one = starts.ndim == ends.ndim == 1
            batch, *each = ((), starts[None], ends[None]) if one else rows_of_both(starts, ends, "q_a", "q_b")
            rows = [device.on_device(part, queue.stream) for part in each]
        scene, n = self._scenes.of(world, self_collision, np.float64, self._queue.stream), len(rows[0])
        known = self._edges.get(self_collision)
        if known is None or known[0] is not scene:
            known = self._edges[self_collision] = scene, edge_tables(scene, None if known is None else known[1])
        tables = known[1]
        near, marks = near_for(scene, n, queue.stream), queue.marks()
        kinds = ((n, tree.n_dof), np.float64), ((n,), np.bool_), ((n,), np.float64)
        q, hits, free = (device.empty(shape, kind, queue.stream) for shape, kind in kinds)
        launch = device.Launch(at_most=len(near), stream=queue.stream)
        given = *scene.tables, tuple(tables), near, lengths, rows[1]

        def refuse() -> None:
            refuse_out_of_range(device.on_host(rows[0]), "q_a")
            refuse_out_of_range(device.on_host(rows[1]), "q_b")

        device.run(edges_of(*scene.sizes, len(tables.first) - 1), given, rows[0], (q, hits, free), marks, launch)
        queue.launched(refuse, is_done=not stays)
        found = hits, free, q
        if not stays or not batch:
            found = [device.on_host(part, queue.stream) for part in found]
        if not batch:
            return EdgeReport(bool(found[0][0]), float(found[1][0]), found[2][0])
        return EdgeReport(*(as_shaped(part, (*batch, *part.shape[1:])) for part in found))

    def plan_many(
        self,
        q_starts: ArrayLike | str | Sequence[str],
        goals: ArrayLike | Mapping[str, ArrayLike] | str | Sequence[str],
        world: World | Iterable[World | None] | None = None,
        *,
        progress: Callable[[int, int], None] | bool | None = None,
        **options: Any,
    ) -> tuple[Plan, ...]:
        """Plan many problems; see ``Robot.plan_many``. The GPU certifies the straight edges, the CPU plans the rest.

        The GPU takes part if the world is one for all problems, and the goals are configurations. Of the options, only
        ``clearance``, ``seed``, ``max_checks``, ``shorten`` and ``time_limit`` may be given. Otherwise, and for robots with
        joints without limits, the CPU plans all problems. It also plans those with the same position of a joint at both ends.

        All arrays are NumPy's.

        Returns:
            A ``Plan`` for each problem, in order. It equals the CPU's, unless the verdicts about the straight edge differ.

        Raises:
            InputError, UnknownNameError, GeometryError: As ``Robot.plan_many``.
        """
        robot = self.robot
        if not (world is None or isinstance(world, World)) or not _STRAIGHT_OPTIONS.issuperset(options):
            return robot.plan_many(q_starts, goals, world, progress=progress, **options)
        asked = PlanOptions(**options).checked()

        def certify(q_a: Array, q_b: Array, seen: World | None) -> NDArray[np.bool_]:
            return ~self._check_edges(q_a, q_b, seen, True, (RESOLUTION, asked.clearance)).in_collision

        def plan_together(starts: list[Any], targets: list[Any]) -> list[Plan | None]:
            if any(np.shape(each) != robot.tree.q_shape for each in (*starts, *targets)):
                return [None] * len(targets)
            ends = np.array(starts).reshape(-1, robot.tree.n_dof), np.array(targets).reshape(-1, robot.tree.n_dof)
            return plan_straight(robot._checker, robot._dynamics, ends, world, asked, certify)  # noqa: SLF001 - parts of it

        plan = partial(robot.plan, **options)
        return plan_many(plan, q_starts, goals, world, progress=progress, plan_together=plan_together)

    def inverse_kinematics(
        self,
        T: Any,
        q_seed: ArrayLike | None = None,
        *,
        link: str | None = None,
        world: World | None = None,
        seed: int = 0,
        task: Task | str = "pose",
        position_tolerance: float = 1e-5,
        rotation_tolerance: float = 1e-5,
        max_iterations: int | None = None,
    ) -> DeviceResult:
        """Joint positions that bring a link to poses; see ``Robot.inverse_kinematics``.

        Targets are searched from the seed and from as many random starts as on the CPU, in float64. The call returns which
        targets are solved. Reasons for the others are computed by the CPU, at the first access. They are those of the targets and
        the world at the time of the call.

        Args:
            T: The poses to reach, T_base_link, shape (..., 4, 4).
            q_seed: The start [rad or m], shape (n_dof,), or (..., n_dof), a NumPy array; by default ``home``.
            link: The link's name; by default the tip.
            world: Configurations that collide with it, or with the robot itself, are rejected, and the search continues.
            seed: Chooses the random starts.
            task: The components of a pose that must be reached.
            position_tolerance: Maximum distance that counts as reached [m].
            rotation_tolerance: Maximum angle that counts as reached [rad].
            max_iterations: Maximum number of steps for a target, 20 per start; by default as many as on the CPU.

        Returns:
            An ``IKResult``. Its ``q`` is on the device if T is; everything else is NumPy's, and copied at the first access.

        Raises:
            InputError: T is not an array of poses, or another argument is invalid.
            UnknownNameError: There is no such link.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.
        """
        options = Options(
            seed=seed, task=as_task(task), position_tolerance=position_tolerance, rotation_tolerance=rotation_tolerance,
            max_iterations=max_iterations,
        )  # fmt: skip
        query = self._query(link, options)
        own = as_own("T", T, self._queue.stream)
        stays = device.is_on_device(own)
        own = own if stays else as_floats("T", own)
        if own.shape[-2:] != (4, 4):
            raise InputError("T", f"shape {own.shape}, but shape (..., 4, 4) is expected")
        batch = tuple(own.shape[:-2])
        targets = self._wide_rows("T", own, (4, 4)) if stays else np.ascontiguousarray(own).reshape(-1, 4, 4)
        seeds = None if q_seed is None else self._seeds(q_seed, batch)
        asked = Request(targets, seeds, world=world, link=query.link, options=query.options)
        q, info, unsolved = self._searched(query, asked, batch)
        if not stays:
            q, info = (device.on_host(part, self._queue.stream) for part in (q, info))
        return DeviceResult(as_shaped(q, (*batch, query.tree.n_dof)), info, batch, options.tolerances, unsolved)

    def _searched(self, query: Query, asked: Request, batch: tuple[int, ...]) -> tuple[Any, Any, Unsolved | Explanation]:
        """q (n, n_dof) and info (n,) on the device, and the request about unsolved targets."""
        queue, on_host = self._queue, self.robot._inverse_kinematics  # noqa: SLF001 - a part of it
        targets: Any = asked.T
        touches = None if asked.world is None else self._touching(asked.world)
        if query.unit != 1.0:  # the CPU searches arms of an unusual size in their own unit of length
            known = Unsolved(on_host, asked, query).by_cpu(np.arange(len(targets)), bool(batch))
            q, info = (device.on_device(part, queue.stream) for part in (known.q.reshape(len(known.info), -1), known.info))
            return q, info, known.explanation
        key = query.link, query.options
        if key not in self._searches:
            self._searches[key] = tables_of(query)
        tables = self._searches[key]
        if asked.q_seed is not None:
            tables = tables._replace(seeds=device.on_device(np.asarray(asked.q_seed), queue.stream))
        there = targets if device.is_on_device(targets) else device.on_device(targets, queue.stream)
        q, info, n_left = DeviceSearch(query, tables, queue, touches).of(there, queue.marks()[0])
        kept = there if n_left else there[:0]
        if n_left and there is targets:  # the caller may change them
            kept = device.copied(there, queue.stream)
        queue.launched(lambda: refuse_targets(targets, batch), is_done=True)
        seen = None if asked.world is None else asked.world.copy()  # a snapshot would lay out large clouds for the CPU
        return q, info, Unsolved(on_host, asked._replace(T=kept, world=seen), query)

    def all_solutions(
        self,
        T: Any,
        *,
        link: str | None = None,
        task: Task | str = "pose",
        redundancy: str | None = None,
        n_samples: int = 16,
        whole_turns: bool = False,
    ) -> IKSolutions | DeviceSolutions:
        """All joint positions that bring a link to poses, and the proof of their completeness; see ``Robot.all_solutions``.

        The GPU computes the closed form, one branch per thread. The CPU searches for arms without a closed form. For an arm of
        six joints and T on the device there is no search: if the proof is ``searched``, the solutions are the branches of the
        closed form alone.

        Returns:
            An ``IKSolutions``; for T on the device a ``DeviceSolutions``, whose q, valid and real are there too.

        Raises:
            InputError: T is not an array of poses; the robot has several tips and no link is named; ``redundancy`` is not a
                joint of an arm of seven; or another argument is invalid.
            UnknownNameError: There is no such link or joint.
        """
        query = self._query(link, Options(task=as_task(task)))
        asked = Asked(redundancy, as_count("n_samples", n_samples, 1), whole_turns)
        return all_solutions(query, as_own("T", T, self._queue.stream), self._wide_rows, asked, self._queue)

    def checked(self, stream: Any = None) -> AbstractContextManager[None]:
        """A block in which no call waits for the device; its end raises errors of invalid arguments.

        Calls put their work on a stream, one after the other, and return arrays on the device that it will write. Outside such a
        block a call checks at once for entries of q out of range, so it waits for its own end.

        These calls wait in a block too: those with NumPy's arrays, ``inverse_kinematics``, and ``all_solutions`` of an arm that
        has more than six joints or no exact closed form. The first call for a link or a world may wait while its tables are
        copied.

        Args:
            stream: The stream of the calls: Numba's, PyTorch's, CuPy's, or its number; by default Numba's default stream.

        Raises:
            InputError: At the end: the error of the first call with an invalid argument.

        With PyTorch::

            with on_gpu.checked(torch.cuda.current_stream()):
                T = on_gpu.forward_kinematics(q)
                hits = on_gpu.in_collision(q, world)
        """
        return self._queue.checked(stream)

    # ---- parts ---------------------------------------------------------------------------------------------------------

    def _over_q(
        self,
        driver: Any,
        tables: Iterable[Any],
        q: Any,
        shape: tuple[int, ...],
        *,
        number: Any = None,
        dtype: Any = None,
        at_most: int = device.LAUNCH.at_most,
        out: Any = None,
    ) -> Any:
        """The results of a driver for q, shape (..., *shape), on the side of q.

        number: the number type of the driver; ``dtype``: the type of its results, by default the same; ``at_most``: see
        ``device.Launch``; ``out``: the caller's array for the results, if given.
        """
        queue, number = self._queue, number or self._number
        q = as_own("q", q, queue.stream)
        rows, batch = self._rows(q, number), tuple(np.shape(q)[:-1])
        kind, width = np.dtype(dtype or number), prod(shape)
        results = self._results(out, rows, (*batch, *shape), kind)
        flat_results = as_shaped(results, (len(rows), width))
        driver = in_single(driver) if number is np.float32 else driver
        device.run(driver, tables, rows, (flat_results,), queue.marks(), device.Launch(at_most=at_most, stream=queue.stream))
        queue.launched(lambda: refuse_out_of_range(device.on_host(rows)), is_done=not device.is_on_device(rows))
        if out is not None:
            return out
        return results if batch or shape else flat_results[0, 0]

    def _results(self, out: Any, rows: Any, shape: tuple[int, ...], kind: np.dtype) -> Any:
        """The caller's array for results, checked for shape, type and side, or a new one."""
        if out is None:
            return device.results_for(rows, shape, kind, self._queue.stream)
        own = as_own("out", out, self._queue.stream)
        if device.is_on_device(own) != device.is_on_device(rows):
            raise InputError("out", "it and q have to be both on the host, or both on the device")
        is_c = own.is_c_contiguous() if device.is_on_device(own) else isinstance(own, np.ndarray) and own.flags.c_contiguous
        if not is_c or tuple(own.shape) != shape or own.dtype != kind:
            what = f"{own.dtype} of shape {tuple(own.shape)}" if hasattr(own, "dtype") else repr(out)
            raise InputError("out", f"{what}; {kind} of shape {shape}, C-contiguous, is expected")
        return own

    def _any_touch(self, q: Any, world: World | None, self_collision: bool, number: Any, out: Any = None) -> Any:
        """Whether anything touches; boxes are checked over ``number``."""
        scene = self._scenes.of(world, self_collision, number, self._queue.stream)
        return self._over_q(overlaps_of(*scene.sizes), scene.tables, q, (), number=scene.number, dtype=np.bool_, out=out)

    def _rows(self, q: Any, number: Any) -> Any:
        """Configurations (n, n_dof) on the side of q, as float32 or float64."""
        if not device.is_on_device(q):
            with np.errstate(over="ignore"):  # it becomes infinite, and is refused
                return np.ascontiguousarray(flat(as_positions(q, self.robot.tree)), dtype=number)
        if number is np.float32:
            return device.as_device_rows("q", q, self.robot.tree.q_shape, number)
        return self._wide_rows("q", q, self.robot.tree.q_shape)

    def _wide_rows(self, name: str, own: Any, shape: tuple[int, ...]) -> Any:
        """Rows of a shape on the device as float64; a robot with ``float32`` converts float32 rows there."""
        if not self.float32 or own.dtype != np.float32:
            return device.as_device_rows(name, own, shape)
        return as_float64(device.as_device_rows(name, own, shape, np.float32), self._queue.stream)

    def _query(self, link: str | None, options: Options) -> Query:
        robot = self.robot
        return Query(robot.tree, robot.home, robot._checker, self._link(link), options)  # noqa: SLF001 - a part of it

    def _link(self, link: str | None) -> str:
        return self.robot.tree.link_or_tip(link)

    def _chain(self, link: str | None) -> device.Tables:
        """The chain to a link."""
        name = self._link(link)
        return self._kept(("chain", name), lambda: (self._there(self.robot.tree.chain(name)),))

    def _there(self, table: Array) -> Any:
        return device.on_device(table.astype(self._number))

    def _kept(self, key: Any, make: Any) -> device.Tables:
        """Tables on the device, copied there once."""
        if key not in self._tables:
            self._queue.refuse_other_card()
            self._tables[key] = device.Tables(make())
        return self._tables[key]

    def _seeds(self, q_seed: ArrayLike, batch: tuple[int, ...]) -> Array:
        """Seeds for each target, or one for all, shape (n or 1, n_dof)."""
        seeds = np.array(as_positions(q_seed, self.robot.tree, "q_seed"))
        refuse_out_of_range(seeds, "q_seed")
        if seeds.ndim == 1:
            return seeds[None]
        if seeds.shape[:-1] != batch:
            raise InputError("q_seed", f"shape {seeds.shape} does not go with T of shape {(*batch, 4, 4)}")
        return flat(seeds)

    def _touching(self, world: World) -> Any:
        """A collision test for configurations (k, n_dof) on the device with a world: bools of shape (k, 1) there."""
        scene, queue = self._scenes.of(world, True, np.float64, self._queue.stream), self._queue

        def touching(q: Any) -> Any:
            hits = device.empty((len(q), 1), np.bool_, queue.stream)
            launch = device.Launch(stream=queue.stream)
            device.run(overlaps_of(*scene.sizes), scene.tables, q, (hits,), queue.spare, launch)
            return hits

        return touching
