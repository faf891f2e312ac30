"""Limits the torques of motors along a path, and finds their peaks in a motion.

Along a path q(s) the torques are tau = a u + b x + c, with x = (ds/dt)^2 and u = d2s/dt2. Here a = M q', b = M q'' + C(q, q') q',
and c is the gravity torque. Each motor gives the constraint -most - c <= a u + b x <= most - c. It applies at both ends of each
interval of a path (``kernels.planning.time_optimal``). Between the ends torques are smooth. There, and in a moving average of a
motion, torques are checked at samples, with a margin of each limit.

Source: Bobrow, Dubowsky and Gibson, Time-optimal control of robotic manipulators along specified paths (IJRR 1985).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.dynamics.dynamics import Dynamics
from ulna.dynamics.effort import as_effort_limits, as_torque_rates
from ulna.errors import InputError
from ulna.kinematics.tree import Tree, entry_names
from ulna.planning.hand import HandLimits, as_hands
from ulna.planning.path_limits import NO_LIMIT, PathBounds, PathLimit, Side, Timed, rows_of

if TYPE_CHECKING:
    from ulna.planning.blend import Grid

Array = NDArray[np.float64]
MARGIN = 0.005  # share of a limit kept as a margin for torques between samples
_ALONG = 0.5 * MARGIN  # further margin along a path
_SAMPLES = 4  # minimum samples between two grid points of a motion
_APART = 0.002  # [s]: maximum time between two samples
_MAX_SAMPLES = 300_000  # maximum samples of a motion


@dataclass(frozen=True)
class TorquePeak:
    """The torque of a motion with the largest share of its limit. ``bool(peak)``: whether it is within.

    Attributes:
        joint: The joint.
        value: The magnitude of the torque [Nm or N].
        time: The time of the peak [s].
        limit: The limit [Nm or N].
        factor: The factor by which to slow the motion down to be within the limits.
    """

    joint: str
    value: float
    time: float
    limit: float
    factor: float

    def __bool__(self) -> bool:
        return self.value <= (1.0 - MARGIN) * self.limit

    @property
    def share(self) -> float:
        """The torque as a share of its limit."""
        return self.value / self.limit

    def __str__(self) -> str:
        spare = "" if self or self.share > 1.0 else f"; {100.0 * MARGIN:g} % of it is a margin for torques between samples"
        return (
            f"the torque of {self.joint} peaks at {self.value:.4g} at {self.time:.3f} s, "
            f"{100.0 * self.share:.4g} % of its limit of {self.limit:.4g}{spare}"
        )


class Motors(NamedTuple):
    """The torque limits of a robot's joints."""

    dynamics: Dynamics
    names: tuple[str, ...]
    """The names of the entries of q."""
    most: Array
    """The maximum torques [Nm or N], shape (n_dof,); infinite for a joint without a limit."""
    most_rate: Array
    """The maximum rates of change of torques, for a servo [Nm/s or N/s], shape (n_dof,); infinite without a limit."""
    dynamic: float = 1.0
    """The share of the torque range left by the gravity torques that a motion may use."""

    @property
    def limits_rates(self) -> bool:
        """Whether the rate of a torque is limited."""
        return bool((self.most_rate < np.inf).any())

    def equals(self, other: object) -> bool:
        """Whether another limit has equal torques and inertias: the same robot with the same attached objects."""
        return (
            isinstance(other, Motors)
            and np.array_equal(self.most, other.most)
            and np.array_equal(self.dynamics.mechanism.bodies, other.dynamics.mechanism.bodies)
            and np.array_equal(self.dynamics.gravity, other.dynamics.gravity)
        )

    def with_dynamics(self, dynamics: Dynamics | None) -> Motors:
        """A copy for the same robot with other attached objects."""
        return self if dynamics is None else self._replace(dynamics=dynamics)

    def torques(self, q: Array, qd: Array, qdd: Array) -> Array:
        """The torques of a motion, shape (..., n_dof)."""
        return self.dynamics.inverse((q, qd, qdd), None, None, None)

    def along(self, grid: Grid) -> PathBounds:
        """The bounds of the path speed and acceleration from the motors' limits.

        Raises:
            InputError: A gravity torque on the path exceeds its limit.
        """
        n, ends = len(grid.steps), grid.slopes + grid.steps[:, None] * grid.bends
        until = grid.starts + grid.steps[:, None] * (grid.slopes + 0.5 * grid.steps[:, None] * grid.bends)
        sides, lows, highs, still = [], [], [], np.zeros((n, grid.starts.shape[1]))
        lengths = np.concatenate([[0.0], np.cumsum(grid.steps)]) / grid.steps.sum()
        for q, slopes, shares in ((grid.starts, grid.slopes, lengths[:-1]), (until, ends, lengths[1:])):
            rest = self.dynamics.gravity_torque(q, None, None)
            self._refuse_at_rest(rest, shares)
            along = self.torques(q, still, slopes) - rest
            sides.append(Side(along, self.torques(q, slopes, grid.bends) - rest))
            most = (1.0 - MARGIN - _ALONG) * self.most
            lows.append(np.minimum(self.dynamic * (-most - rest), 0.0))
            highs.append(np.maximum(self.dynamic * (most - rest), 0.0))
        limits = np.hstack(lows), np.hstack(highs)
        finite = (np.clip(limits[0], -NO_LIMIT, 0.0), np.clip(limits[1], 0.0, NO_LIMIT))
        return PathBounds(np.full(n, NO_LIMIT), np.full(n, NO_LIMIT), rows_of(grid.steps, sides[0], sides[1], finite))

    def peaks(self, timed: Timed, since: float) -> tuple[TorquePeak, ...]:
        """The torque with the largest share of its limit, at samples of a motion from a time on."""
        times = self._sampled(timed, since)
        moment = timed.at(times)
        torque, rest = self.torques(*moment[:3]), self.dynamics.gravity_torque(moment.q, None, None)
        shares = np.abs(torque) / self.most
        row, joint = divmod(int(np.argmax(shares)), shares.shape[1])
        room = (1.0 - MARGIN) * self.most - np.sign(torque - rest) * rest  # for torques that grow with the speed
        with np.errstate(divide="ignore", invalid="ignore"):
            squares = np.where(torque != rest, np.maximum(room, 0.0) / np.abs(torque - rest), np.inf)
        factor = float(np.sqrt(min(1.0, squares.min())))
        found = float(np.abs(torque)[row, joint]), float(times[row]), float(self.most[joint]), factor
        return (TorquePeak(self.names[joint], *found),)

    def narrowed(self, peaks: Iterable[Any], share: float) -> Motors:
        """A copy with the dynamic share reduced by the excess of the peaks, and by the factor ``share``."""
        factor = min((peak.factor for peak in peaks if isinstance(peak, TorquePeak) and not peak), default=1.0)
        return self if factor == 1.0 else self._replace(dynamic=self.dynamic * factor**2 * share)

    def with_less_acceleration(self, share: float) -> Motors:
        """A copy with a share of the dynamic torques."""
        return self._replace(dynamic=share * self.dynamic)

    def stopping_distance(self, q: Array, qd: Array) -> float:
        """The braking distance of a straight motion with the motors' torques."""
        size = float(np.linalg.norm(qd))
        if size == 0.0:
            return 0.0
        rest, still = self.dynamics.gravity_torque(q, None, None), np.zeros_like(q)
        braking, carried = self.torques(q, still, -qd / size) - rest, self.torques(q, qd, still)
        room = np.where(braking > 0.0, self.most - carried, self.most + carried)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = float(np.where(braking != 0.0, np.maximum(room, 0.0) / np.abs(braking), np.inf).min())
        return size * size / max(rate, 1e-9)  # with half of the available deceleration

    def refuse_ends(self, q: Array, velocities: Iterable[Array]) -> None:
        """Raise an error if the motors cannot hold the velocities at the ends of a motion."""
        ends = ("start_velocity", "end_velocity"), q, velocities, np.array([[0.0], [1.0]])
        for name, at, qd, share in zip(*ends, strict=True):
            self._refuse_at_rest(self.dynamics.gravity_torque(at, None, None)[None], share)
            torque = np.abs(self.torques(at, qd, np.zeros_like(qd)))
            if (torque > (1.0 - MARGIN) * self.most).any():
                joint = int(np.argmax(torque / self.most))
                beyond = f"{self.names[joint]} would need a torque of {torque[joint]:.4g} to hold this velocity"
                raise InputError(name, f"{beyond}, but less than its limit of {self.most[joint]:.4g} is expected")

    def _refuse_at_rest(self, rest: Array, shares: Array) -> None:
        """Raise an error if gravity torques leave no torque for a motion. shares: the path's share at each row."""
        beyond = np.abs(rest) >= (1.0 - 2.0 * MARGIN) * self.most
        if beyond.any():
            row, joint = np.argwhere(beyond)[0]
            needed = f"{self.names[joint]} needs {abs(float(rest[row, joint])):.4g} to hold the robot still"
            where = f"at {100.0 * shares[row]:.0f} % of the path"
            raise InputError(
                "torque", f"{needed} {where}, and its limit is {self.most[joint]:.4g}: no motion is within the limits"
            )

    def _sampled(self, timed: Timed, since: float) -> Array:
        """Sample times between the grid points, and just before and after them, where accelerations jump."""
        times = np.concatenate([[since], timed.times[timed.times > since]])
        steps = np.diff(times)
        steps, times = steps[steps > 0.0], times[:-1][steps > 0.0]
        if not len(steps):
            return np.array([min(since, timed.duration)])
        counts = np.maximum(_SAMPLES, np.ceil(steps / _APART)).astype(np.int64)
        counts = np.maximum(2, (counts * min(1.0, _MAX_SAMPLES / counts.sum())).astype(np.int64))
        of = np.repeat(np.arange(len(steps)), counts)
        first = np.repeat(np.cumsum(counts) - counts, counts)
        shares = np.clip((np.arange(len(of)) - first) / (counts[of] - 1), 1e-9, 1.0 - 1e-9)
        return np.minimum(times[of] + shares * steps[of], timed.duration)


def as_motors(
    torque: ArrayLike | None, tree: Tree, dynamics: Dynamics | None, torque_rate: ArrayLike | None = None
) -> Motors | None:
    """Check given torque limits: True for the description's, None or False for no limits.

    torque_rate: limits of the torques' rates of change; None for no limits.

    Raises:
        InputError: They are neither a number above 0 nor one for each entry of q; or the description has none; or the robot of a
            motion is unknown.
        InertiaError: A moving link has a shape but no inertia.
    """
    if isinstance(torque, bool | np.bool_) and not torque:
        torque = None
    if torque is None and torque_rate is None:
        return None
    if dynamics is None:
        raise InputError("torque", "the inertias of this motion's robot are unknown")
    most = np.full(tree.n_dof, np.inf) if torque is None else as_effort_limits(torque, tree)
    most_rate = np.full(tree.n_dof, np.inf) if torque_rate is None else as_torque_rates(torque_rate, tree)
    dynamics.mechanism  # noqa: B018 - raises an error for a robot without inertias
    return Motors(dynamics, tuple(entry_names(tree)), most, most_rate)


def as_caps(
    hand: HandLimits | Iterable[HandLimits] | None, torque: ArrayLike | None, tree: Tree, dynamics: Dynamics | None
) -> tuple[PathLimit, ...]:
    """Check the limits of hands and torques of a motion.

    Raises:
        InputError, UnknownNameError: See ``hand.as_hands`` and ``as_motors``.
        InertiaError: See ``as_motors``.
    """
    hands, motors = as_hands(hand, tree), as_motors(torque, tree, dynamics)
    return hands if motors is None else (*hands, motors)
