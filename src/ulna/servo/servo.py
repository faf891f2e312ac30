"""Steers an arm tick by tick: each command, and a full stop after it, is certified free (``drivers.servo``)."""

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.objects import Moving, Objects, rows_of
from ulna.collision.world import World
from ulna.description.arrays import as_floats, as_number, positive
from ulna.description.pose import as_one_pose
from ulna.drivers import servo as driver
from ulna.errors import InputError
from ulna.ik.problem import refuse_immovable
from ulna.kernels.collision.scene import Scene
from ulna.kernels.layout import IN_BASE, OBJECT
from ulna.kernels.servo import servo_layout as layout
from ulna.kinematics.jacobian import as_frame
from ulna.kinematics.positions import as_configuration, is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree, entry_names
from ulna.planning.motion_limits import LARGEST, as_limits
from ulna.servo.command import STATUS_OF, Command, Limiting

Array = NDArray[np.float64]
WITHIN = 1 - 1e-6  # of the limits of velocity and acceleration, so that differences of commands keep them too
_ROOM = 0.25  # of the way of one tick of acceleration: beside a motion, certified too, so that there is a way out of every rest
_FASTEST = 1e5  # [1/s]: of more ticks a second the differences of commands are rounding
_DAMPING = 0.01
_ROUNDING = 1e-12  # [m, rad]: no object moved too fast by less, of which ``MOVED`` allows many; nor is the arm off its command
_PULL = 1.0  # [1/s]: towards a posture


class Servo:
    """Steers an arm tick by tick; made by ``Robot.servo``. One thread at a time may use it.

    The state is the last command. ``start`` sets it; each ``step`` moves it by one tick.
    """

    def __init__(
        self,
        tree: Tree,
        checker: Checker,
        world: World | None,
        rate: float,
        link: str | None,
        velocity: ArrayLike | None,
        acceleration: ArrayLike,
        clearance: float,
        tracking_error: ArrayLike,
        posture: ArrayLike | None,
    ) -> None:
        """See ``Robot.servo``."""
        refuse_immovable(tree)
        n = tree.n_dof
        if positive("rate", rate) > _FASTEST:
            raise InputError("rate", f"{rate!r}; at most {_FASTEST:g} ticks a second are expected")
        clearance = as_number("clearance", clearance, 0.0, "a distance [m] of at least 0")
        aside = as_floats("tracking_error", tracking_error)
        if aside.shape not in {(), (n,)} or not ((aside >= 0) & (aside < np.inf)).all():
            raise InputError("tracking_error", f"{tracking_error!r}; a number of at least 0, or {n} of them, is expected")
        if not tree.velocity_limits.all():
            still = ", ".join(name for name, most in zip(entry_names(tree), tree.velocity_limits, strict=True) if not most)
            raise InputError("robot", f"its description allows {still} a velocity of 0, so a servo would never move")
        speeds = as_limits("velocity", tree.velocity_limits if velocity is None else velocity, n, may_be_infinite=True)
        accelerations = WITHIN * as_limits("acceleration", acceleration, n)
        tick = 1.0 / float(rate)
        self._tree, self._checker, self._world = tree, checker, world
        self._link = tree.link_or_tip(link)
        tree.chain(self._link)  # refused where there is no such link
        self._limits = np.zeros((layout.N_LIMITS, n))
        self._limits[layout.LOWER], self._limits[layout.UPPER] = tree.least, tree.most
        self._limits[layout.SPEED] = np.minimum(WITHIN * speeds, np.minimum(LARGEST, WITHIN * tree.velocity_limits))
        self._limits[layout.ACCELERATION], self._limits[layout.ASIDE] = accelerations, aside
        self._limits[layout.ROOM] = _ROOM * accelerations * tick * tick
        self._settings = np.array([tick, clearance, _DAMPING**2, 0.0])
        if posture is not None:
            self._limits[layout.POSTURE] = as_configuration(posture, tree, "posture")
            self._settings[layout.PULL] = _PULL
        self._state, self._report = np.zeros((layout.N_STATE, n)), np.zeros(layout.N_REPORT)
        self._counters = np.zeros(layout.N_COUNTERS, dtype=np.int64)
        self._goals = np.zeros(n), np.zeros(6), np.zeros(12), np.zeros(2 * n)
        self._names, self._started = entry_names(tree), False
        self._scene: Scene | None = None
        self._object_names: list[str] = []  # of the scene
        self._stated: tuple[Moving, ...] = ()  # the objects of ``_moving``, as they were stated last
        self._n_changes = 0  # of other objects
        self._wider, self._moving = np.zeros(2), np.empty((0, layout.MOVING_WIDTH))
        self._too_fast: str | None = None
        self._ticks, self._worst = 0, 0.0

    @property
    def q(self) -> Array:
        """The joint positions of the last command [rad or m], shape (n_dof,)."""
        return self._state[layout.Q].copy()

    @property
    def qd(self) -> Array:
        """The joint velocities of the last command [rad/s or m/s], shape (n_dof,)."""
        return self._state[layout.QD].copy()

    @property
    def ticks(self) -> int:
        """How many ticks there were since the last ``start``."""
        return self._ticks

    @property
    def worst(self) -> float:
        """How long the longest of them took to compute [s]; 0 before the first."""
        return self._worst

    def start(self, q: ArrayLike, qd: ArrayLike | None = None) -> Command:
        """Set the state.

        Args:
            q: Joint positions [rad or m], shape (n_dof,).
            qd: Joint velocities [rad/s or m/s], shape (n_dof,); at rest unless given.

        Returns:
            The state as a command.

        Raises:
            InputError: The arm is beyond its limits, cannot stop within them, or is not certainly free until it rests.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        n, goal = self._tree.n_dof, self._goals[3]
        goal[:n] = as_configuration(q, self._tree, "q")
        goal[n:] = 0.0 if qd is None else as_configuration(qd, self._tree, "qd")
        if not is_within(goal[:n], self._tree):
            raise InputError("q", "beyond the joint limits")
        if (np.abs(goal[n:]) > self._limits[layout.SPEED]).any():
            raise InputError("qd", "faster than the limits of velocity")
        before, counters = self._state.copy(), self._counters.copy()
        self._run(layout.START, IN_BASE, goal)
        status = int(self._report[layout.STATUS])
        if status in {layout.LIMITED_BY_POSITION, layout.REFUSED}:
            self._state[:], self._counters[:] = before, counters
            self._counters[layout.CERTIFIED] = 0  # perhaps it was in another world
            if status == layout.LIMITED_BY_POSITION:
                raise InputError("qd", "the arm cannot stop within its joint limits")
            raise InputError(
                "q", "not certainly free, with the clearance, until the arm rests; robot.check_collision says what is near"
            )
        self._started, self._ticks, self._worst = True, 0, 0.0
        return self._command()

    def step(
        self,
        *,
        q: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        twist: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        expressed_in: str = "base",
        measured: ArrayLike | None = None,
    ) -> Command:
        """The next command. At most one goal is given; without one the arm comes to rest by its certified stop.

        So it does if it was measured farther off the last command than ``tracking_error``, with the status ``off the command``:
        where it is nothing is certified. It goes on once it is measured near enough, or by ``start`` from where it is.

        Args:
            q: Where to go [rad or m], shape (n_dof,).
            velocity: Joint velocities [rad/s or m/s], shape (n_dof,).
            twist: v [m/s] and w [rad/s] of the link, shape (6,).
            pose: Where the link is to go, T_base_link, shape (4, 4).
            expressed_in: The frame of the twist; see ``Robot.jacobian``.
            measured: Where the arm is now [rad or m], shape (n_dof,); not looked at unless given.

        Raises:
            InputError: Nothing was started, there are several goals, or one has another shape or an entry out of range. The state
                is as it was: ``step()`` brings the arm to rest.
        """
        if not self._started:
            raise InputError("step", "start(q) comes first")
        began = perf_counter()
        given = [(q, self._to_q), (velocity, self._to_velocity), (twist, self._to_twist), (pose, self._to_pose)]
        goals = [(goal, fill) for goal, fill in given if goal is not None]
        if len(goals) > 1:
            raise InputError("step", "takes one of q, velocity, twist and pose")
        frame, off = as_frame(expressed_in), -1 if measured is None else self._entry_off(measured)
        mode, goal = goals[0][1](goals[0][0]) if goals else (layout.REST, self._goals[0])
        self._run(mode if off < 0 else layout.REST, frame, goal)
        if off >= 0:
            self._report[layout.STATUS], self._report[layout.ENTRY] = layout.OFF_COMMAND, off
        self._moving[:, layout.AGO] += self._settings[layout.TICK]
        command = self._command()
        self._ticks, self._worst = self._ticks + 1, max(self._worst, perf_counter() - began)
        return command

    def _entry_off(self, measured: ArrayLike) -> int:
        """The entry of q that was measured farthest off the last command, beyond what is certified; -1 if none was."""
        apart = np.abs(as_configuration(measured, self._tree, "measured") - self._state[layout.Q]) - self._limits[layout.ASIDE]
        farthest = int(apart.argmax())
        return farthest if apart[farthest] > _ROUNDING else -1

    def __getstate__(self) -> dict[str, Any]:
        """The state without the tables of robot and world, which ``__setstate__`` makes again: unpickled arrays are writable."""
        of = self._checker
        parts = of.description, of.tree, of.attached, of.given, of.found
        return {**self.__dict__, "_scene": None, "_checker": parts}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({**state, "_checker": Checker(*state["_checker"])})

    def warm_up(self) -> None:
        """Compile what a tick needs, or load it, so that no tick does: for a world of the kinds of shapes that it has now."""
        kept = self._state.copy(), self._counters.copy(), self._report.copy()
        self._run(layout.REST, IN_BASE, self._goals[0])
        self._state[:], self._counters[:], self._report[:] = kept
        self._counters[layout.CERTIFIED] = 0  # perhaps it was in another world

    def _to_q(self, q: ArrayLike) -> tuple[int, Array]:
        self._goals[0][:] = as_configuration(q, self._tree, "q")
        return layout.POSITION, self._goals[0]

    def _to_velocity(self, velocity: ArrayLike) -> tuple[int, Array]:
        self._goals[0][:] = as_configuration(velocity, self._tree, "velocity")
        return layout.VELOCITY, self._goals[0]

    def _to_twist(self, twist: ArrayLike) -> tuple[int, Array]:
        given = as_floats("twist", twist)
        if given.shape != (6,):
            raise InputError("twist", f"shape {given.shape}, but shape (6,) is expected: v [m/s], w [rad/s]")
        refuse_out_of_range(given, "twist")
        self._goals[1][:] = given
        return layout.TWIST, self._goals[1]

    def _to_pose(self, pose: ArrayLike) -> tuple[int, Array]:
        self._goals[2][:] = as_one_pose(pose, "pose")[:3].ravel()
        return layout.POSE, self._goals[2]

    def _run(self, mode: int, frame: int, goal: Array) -> None:
        """Run a tick in the world as it is now."""
        scene, objects = self._checker.scene_and_objects(self._world)
        self._too_fast = None
        if scene is not self._scene:
            self._change_to(objects)
            self._scene = scene
        chain, kept = self._tree.chain(self._link), (self._state, self._counters, self._report, self._wider, self._moving)
        driver.servo_tick(*scene, chain, frame, mode, self._limits, self._settings, goal, *kept)

    def _change_to(self, objects: Objects) -> None:
        """Take over another world. What was certified still counts if all that has changed was reckoned with in it.

        So it is while the arm moves, and if objects with a stated speed moved no faster. Else the stop is certified anew.
        """
        before = {one.name: (one, row[layout.AGO]) for one, row in zip(self._stated, self._moving, strict=True)}
        self._moving = np.zeros((len(objects.moving), layout.MOVING_WIDTH))
        for one, row in zip(objects.moving, self._moving, strict=True):
            row[:] = one.number, one.speed, 0.0, one.in_tree
            known, ago = before.get(one.name, (one, 0.0))
            if known.stated == one.stated:
                row[layout.AGO] = ago
            elif ago > 0.0 and one.way_from(known.pose) > one.speed * ago + _ROUNDING:
                self._too_fast = one.name
        counters = self._counters
        is_moving = self._scene is not None and counters[layout.DONE] < counters[layout.TICKS]
        if not is_moving or self._too_fast is not None or objects.n_changes != self._n_changes:
            counters[layout.CERTIFIED] = 0
        self._stated, self._n_changes, self._object_names = objects.moving, objects.n_changes, objects.names
        self._wider = np.zeros(len(objects.names) + 2)

    def _command(self) -> Command:
        q, qd, qdd = self._state[:3].copy()
        share, entry, body, other, distance = self._report[layout.SHARE :].tolist()
        joint = self._names[int(entry)] if entry >= 0 else None
        pair = None if body < 0 else (self._name(int(body)), self._name(int(other)))
        limiting = Limiting(joint, pair, None if pair is None else distance, share, self._too_fast)
        return Command(q, qd, qdd, STATUS_OF[int(self._report[layout.STATUS])], limiting)

    def _name(self, i: int) -> str:
        bodies, scene = self._checker.bodies, self._scene
        if i < len(bodies.names) or scene is None:
            return bodies.names[i]
        row = rows_of(scene.nodes, np.array([i - len(bodies.names)]))[0]
        return self._object_names[int(scene.objects[row, OBJECT])]
