"""Limits the torques of motors along a path, and finds their peaks in a motion.

Along a path q(s) the torques are tau = a u + b x + c, with x = (ds/dt)^2 and u = d2s/dt2. Here a is M q', b is M q'' + C(q,
q') q', and c holds the robot still. So each motor bounds u and x by -most - c <= a u + b x <= most - c, at both ends of each
interval of a path (``kernels.planning.time_optimal``). Between the ends torques are smooth. There, and in a motion that is the
mean of one along a path, they are judged at samples, with a share of each limit to spare.

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
MARGIN = 0.005  # of a limit: what torques between two samples of a motion may be beyond what they are there
_ALONG = 0.5 * MARGIN  # of a limit, along a path
_SAMPLES = 4  # between two grid points of a motion
_APART = 0.002  # [s]: two samples of a motion are no farther apart
_MAX_SAMPLES = 300_000  # of a motion


@dataclass(frozen=True)
class TorquePeak:
    """The torque of a motion that is the greatest share of its limit. ``if peak:`` asks whether it is within it.

    Attributes:
        joint: The joint.
        value: The torque [Nm or N], without its sign.
        time: When [s].
        limit: The limit [Nm or N].
        factor: The share of its speed with which the motion is within the limits.
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
        spare = "" if self or self.share > 1.0 else f"; {100.0 * MARGIN:g} % of it is kept for what is between samples"
        return (
            f"the torque of {self.joint} is at most {self.value:.4g}, at {self.time:.3f} s, "
            f"{100.0 * self.share:.4g} % of its limit of {self.limit:.4g}{spare}"
        )


class Motors(NamedTuple):
    """The greatest torque of each joint in a motion."""

    dynamics: Dynamics
    names: tuple[str, ...]
    """Of the entries of q."""
    most: Array
    """Limits [Nm or N], shape (n_dof,); infinite for a joint without one."""
    most_rate: Array
    """Limits of how fast torques change, which a servo keeps [Nm/s or N/s], shape (n_dof,); infinite for none."""
    dynamic: float = 1.0
    """The share of what a limit leaves beside the torques at rest, which the motion is made with."""

    @property
    def limits_rates(self) -> bool:
        """Whether the rate of a torque is limited."""
        return bool((self.most_rate < np.inf).any())

    def same_as(self, other: object) -> bool:
        """Whether these are the motors of another motion of the same robot, which holds the same."""
        return (
            isinstance(other, Motors)
            and np.array_equal(self.most, other.most)
            and np.array_equal(self.dynamics.mechanism.bodies, other.dynamics.mechanism.bodies)
            and np.array_equal(self.dynamics.gravity, other.dynamics.gravity)
        )

    def of(self, dynamics: Dynamics | None) -> Motors:
        """The motors of the same robot, which holds something else."""
        return self if dynamics is None else self._replace(dynamics=dynamics)

    def torques(self, q: Array, qd: Array, qdd: Array) -> Array:
        """The torques of motions, shape (..., n_dof)."""
        return self.dynamics.inverse((q, qd, qdd), None, None, None)

    def along(self, grid: Grid) -> PathBounds:
        """The bounds that the motors set along a path.

        Raises:
            InputError: On the path a torque at rest is beyond its limit.
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
        """The torque that is the greatest share of its limit at samples of a motion from a time on."""
        times = self._sampled(timed, since)
        moment = timed.at(times)
        torque, rest = self.torques(*moment[:3]), self.dynamics.gravity_torque(moment.q, None, None)
        shares = np.abs(torque) / self.most
        row, joint = divmod(int(np.argmax(shares)), shares.shape[1])
        room = (1.0 - MARGIN) * self.most - np.sign(torque - rest) * rest  # for what grows with the speed
        with np.errstate(divide="ignore", invalid="ignore"):
            squares = np.where(torque != rest, np.maximum(room, 0.0) / np.abs(torque - rest), np.inf)
        factor = float(np.sqrt(min(1.0, squares.min())))
        found = float(np.abs(torque)[row, joint]), float(times[row]), float(self.most[joint]), factor
        return (TorquePeak(self.names[joint], *found),)

    def narrowed(self, peaks: Iterable[Any], share: float) -> Motors:
        """The motors with less for what is beside the torques at rest, by as much as a peak is beyond its limit."""
        factor = min((peak.factor for peak in peaks if isinstance(peak, TorquePeak) and not peak), default=1.0)
        return self if factor == 1.0 else self._replace(dynamic=self.dynamic * factor**2 * share)

    def gentler(self, share: float) -> Motors:
        """The motors with a share of what is beside the torques at rest."""
        return self._replace(dynamic=share * self.dynamic)

    def stopping_distance(self, q: Array, qd: Array) -> float:
        """The distance in which the motors stop a motion that goes straight on."""
        size = float(np.linalg.norm(qd))
        if size == 0.0:
            return 0.0
        rest, still = self.dynamics.gravity_torque(q, None, None), np.zeros_like(q)
        braking, carried = self.torques(q, still, -qd / size) - rest, self.torques(q, qd, still)
        room = np.where(braking > 0.0, self.most - carried, self.most + carried)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = float(np.where(braking != 0.0, np.maximum(room, 0.0) / np.abs(braking), np.inf).min())
        return size * size / max(rate, 1e-9)  # with half of what there is

    def refuse_ends(self, q: Array, velocities: Iterable[Array]) -> None:
        """Refuse velocities at which the motors cannot keep the motion straight on at its speed."""
        ends = ("start_velocity", "end_velocity"), q, velocities, np.array([[0.0], [1.0]])
        for name, at, qd, share in zip(*ends, strict=True):
            self._refuse_at_rest(self.dynamics.gravity_torque(at, None, None)[None], share)
            torque = np.abs(self.torques(at, qd, np.zeros_like(qd)))
            if (torque > (1.0 - MARGIN) * self.most).any():
                joint = int(np.argmax(torque / self.most))
                beyond = f"{self.names[joint]} would need {torque[joint]:.4g} to go straight on at it"
                raise InputError(name, f"{beyond}, and less than its limit of torque of {self.most[joint]:.4g} is expected")

    def _refuse_at_rest(self, rest: Array, shares: Array) -> None:
        """Refuse torques at rest that leave nothing to move with. shares: of the path's length, up to each row."""
        beyond = np.abs(rest) >= (1.0 - 2.0 * MARGIN) * self.most
        if beyond.any():
            row, joint = np.argwhere(beyond)[0]
            needed = f"{self.names[joint]} needs {abs(float(rest[row, joint])):.4g} to hold the robot still"
            where = f"at {100.0 * shares[row]:.0f} % of the path"
            raise InputError(
                "torque", f"{needed} {where}, and its limit is {self.most[joint]:.4g}: no motion is within the limits"
            )

    def _sampled(self, timed: Timed, since: float) -> Array:
        """Times between the grid points, and just beside these, where accelerations jump."""
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
    """The limits of torques that a caller gives: those of the description for True, none for None or False.

    torque_rate: The limits of their rates; None for none.

    Raises:
        InputError: They are neither a number above 0 nor one for each entry of q; or the description states none; or the robot of
            a motion is not known.
        InertiaError: A link that moves and has a shape has no inertia.
    """
    if isinstance(torque, bool | np.bool_) and not torque:
        torque = None
    if torque is None and torque_rate is None:
        return None
    if dynamics is None:
        raise InputError("torque", "this motion is of a robot whose inertias are not known")
    most = np.full(tree.n_dof, np.inf) if torque is None else as_effort_limits(torque, tree)
    most_rate = np.full(tree.n_dof, np.inf) if torque_rate is None else as_torque_rates(torque_rate, tree)
    dynamics.mechanism  # noqa: B018 - refuses a robot without inertias
    return Motors(dynamics, tuple(entry_names(tree)), most, most_rate)


def as_caps(
    hand: HandLimits | Iterable[HandLimits] | None, torque: ArrayLike | None, tree: Tree, dynamics: Dynamics | None
) -> tuple[PathLimit, ...]:
    """The limits of a motion beside those of its joints.

    Raises:
        InputError, UnknownNameError: As for ``hand.as_hands`` and ``as_motors``.
        InertiaError: As for ``as_motors``.
    """
    hands, motors = as_hands(hand, tree), as_motors(torque, tree, dynamics)
    return hands if motors is None else (*hands, motors)
