"""Limits the speed and acceleration of a hand along a path, and bounds them in a motion at all times.

Along a path q(s) the hand is at p(s), with p' = J_v q' and p'' = J_v q'' + (dJ_v/ds) q'. At the path speed ds/dt, the hand's
speed is |p'| ds/dt. Its acceleration is p' u + p'' x, with x = (ds/dt)^2 and u = d2s/dt2. Limits of both constrain x and u like
the limits of joints (``kernels.planning.time_optimal``). The acceleration lies in the plane of p' and p''. There a polygon
inscribed in the circle approximates its limit.

Between two samples h apart, the distance of a curve f from its chord is at most h^2 / 8 times the largest |f''|. The norm on a
chord is largest at one of its ends. The rates of the joints bound the derivatives of p. A mixed derivative with
respect to several joints is bounded by a distance: from the hand to the axis of the last of these joints in the chain.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_number
from ulna.errors import InputError, cited
from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, PRISMATIC, RATIO
from ulna.kinematics.jacobian import CompiledJacobian
from ulna.kinematics.tree import Tree
from ulna.planning.path_limits import NO_LIMIT, PathBounds, Side, Timed, rows_of

if TYPE_CHECKING:
    from ulna.planning.blend import Grid

Array = NDArray[np.float64]
QUANTITIES = "speed", "acceleration", "angular_speed"
UNITS = {"speed": "m/s", "acceleration": "m/s^2", "angular_speed": "rad/s"}
LARGEST = 1e9  # the maximum of a limit: for larger ones, times are rounding
_DIRECTIONS = 12  # half the number of sides of the polygon, which is 0.9 % narrower than the circle
_WITHIN = 1 - 1e-4  # factor of a limit along a path; the rest covers the bound between samples of the motion
_PRECISION = 5e-5  # precision of the bound between samples, relative to the limit
_DIFFERENCE = 1e-4  # [rad]: step of the fastest joint in the finite difference of J
_MAX_SAMPLES = 300_000  # maximum samples of a motion; the bound becomes wider instead of more samples
_NODES = np.array([0.1, 0.3, 0.5, 0.7, 0.9])  # interpolation nodes inside an interval, away from jumps at its ends
_DEGREE = len(_NODES) - 1
_CHOICES = np.array([math.comb(_DEGREE, k) for k in range(_DEGREE + 1)], dtype=np.float64)


@dataclass(frozen=True)
class HandLimits:
    """Limits of the speed and the acceleration of a link, which hold at all times of a motion.

    Attributes:
        speed: Maximum speed of the link's origin [m/s]; no limit for None.
        acceleration: Maximum acceleration of the link's origin [m/s^2]; no limit for None.
        angular_speed: Maximum angular speed of the link [rad/s]; no limit for None.
        link: The link; the robot's tip for None.

    Raises:
        InputError: No limit is given, or a limit is not a number above 0.

    Example:
        >>> import ulna
        >>> robot = ulna.load("panda")
        >>> slow = ulna.HandLimits(speed=0.25)
        >>> motion = robot.trajectory([robot.home, robot.home + 0.3], acceleration=5.0, hand=slow)
        >>> motion.check().within
        True
    """

    speed: float | None = None
    acceleration: float | None = None
    angular_speed: float | None = None
    link: str | None = None

    def __post_init__(self) -> None:
        for name in QUANTITIES:
            value = getattr(self, name)
            if value is not None:
                expected = f"a number above 0 [{UNITS[name]}], at most {LARGEST:g}"
                object.__setattr__(self, name, as_number(name, value, 0.0, expected, above=True, most=LARGEST))
        if all(getattr(self, name) is None for name in QUANTITIES):
            raise InputError("hand", f"it limits nothing; one of {', '.join(QUANTITIES)} is expected")


@dataclass(frozen=True)
class HandPeak:
    """The peak of a quantity of a hand in a motion. ``bool(peak)`` is True if it is within its limit.

    Attributes:
        link: The link.
        quantity: "speed", "acceleration" or "angular_speed".
        value: The largest sampled value [m/s, m/s^2 or rad/s].
        time: The time of the peak [s].
        bound: An upper bound at all times, up to a relative error of 1e-6 from a finite difference in the acceleration.
        limit: The limit; infinite if none was given.
    """

    link: str
    quantity: str
    value: float
    time: float
    bound: float
    limit: float

    def __bool__(self) -> bool:
        return self.bound <= self.limit

    @property
    def share(self) -> float:
        """The value as a share of its limit."""
        return self.value / self.limit

    @property
    def factor(self) -> float:
        """The factor by which to slow the motion down to be within the limit."""
        return (self.limit / self.bound) ** (0.5 if self.quantity == "acceleration" else 1.0)

    def __str__(self) -> str:
        words, unit = self.quantity.replace("_", " "), UNITS[self.quantity]
        most = f"the {words} of {self.link} peaks at {self.value:.4g} {unit} at {self.time:.3f} s"
        if np.isinf(self.limit):
            return most
        beyond = "" if self or self.value > self.limit else f", with an upper bound of {self.bound:.9g}"
        return f"{most}{beyond}, {100.0 * self.share:.4g} % of its limit of {self.limit:.4g} {unit}"


class Hand(NamedTuple):
    """A link of a robot with its limits."""

    tree: Tree
    limits: HandLimits
    """The limits, with the name of the link."""
    jacobian: CompiledJacobian
    """The Jacobian of the link, in the axes of the base."""

    @property
    def link(self) -> str:
        """The name of the link."""
        return str(self.limits.link)

    def limit(self, quantity: str) -> float:
        """The limit of a quantity; infinite without one."""
        most = getattr(self.limits, quantity)
        return np.inf if most is None else float(most)

    def narrowed(self, peaks: Iterable[Any], share: float) -> Hand:
        """A copy with limits reduced by the excess of the peaks, and by the factor ``share``."""
        beyond = {peak.quantity: peak.limit / peak.bound * share for peak in _peaks_of_link(peaks, self.link) if not peak}
        return self._replace(limits=replace(self.limits, **{name: factor * self.limit(name) for name, factor in beyond.items()}))

    def with_less_acceleration(self, share: float) -> Hand:
        """A copy with a share of the acceleration limit."""
        most = self.limits.acceleration
        return self if most is None else self._replace(limits=replace(self.limits, acceleration=share * most))

    def velocities(self, q: Array, qd: Array) -> tuple[Array, Array]:
        """The velocity and the angular velocity of the link, shape (n, 3) each; q, qd: shape (n, n_dof)."""
        twist = (self.jacobian(q) @ qd[..., None])[..., 0]
        return twist[..., :3], twist[..., 3:]

    def stopping_distance(self, q: Array, qd: Array) -> float:
        """The braking distance, in the norm of q, with half of the hand's acceleration; the other half may turn it."""
        speed = float(np.linalg.norm(self.velocities(q[None], qd[None])[0]))
        return float(np.linalg.norm(qd)) * speed / self.limit("acceleration")

    def bias_acceleration(self, q: Array, qd: Array) -> Array:
        """The acceleration (dJ_v/dt) qd, shape (n, 3), by a central difference of J along the motion."""
        size = np.abs(qd).max(axis=-1, keepdims=True)
        step = _DIFFERENCE * qd / np.where(size > 0.0, size, 1.0)
        (before, _), (behind, _) = self.velocities(q - step, qd), self.velocities(q + step, qd)
        return (behind - before) * size / (2.0 * _DIFFERENCE)

    def along(self, grid: Grid) -> PathBounds:
        """The bounds of the path speed and acceleration from the hand's limits."""
        n, ends = len(grid.steps), grid.slopes + grid.steps[:, None] * grid.bends
        until = grid.starts + grid.steps[:, None] * (grid.slopes + 0.5 * grid.steps[:, None] * grid.bends)
        before, behind = np.full(n, NO_LIMIT), np.full(n, NO_LIMIT)
        steepest = np.maximum(np.abs(grid.slopes), np.abs(ends))
        extents = np.maximum(np.abs(grid.starts), np.abs(until)).max(axis=0) + (steepest * grid.steps[:, None]).max(axis=0)
        at_ends = [self.velocities(grid.starts, grid.slopes), self.velocities(until, ends)]
        rates, beside = self.rates(extents, steepest, grid.bends, np.zeros_like(ends)), grid.steps**2 / 8.0
        for k, (quantity, weights) in enumerate((("speed", rates.arms), ("angular_speed", rates.turns))):
            if self.limit(quantity) < np.inf:
                more = beside * rates.third_derivative_bound(weights) + 1e-100
                sizes = [np.linalg.norm(moved[k], axis=1) + more for moved in at_ends]
                early, late = ((_WITHIN * self.limit(quantity) / size) ** 2 / _max_between(*sizes) for size in sizes)
                early[0] = (self.limit(quantity) / (sizes[0][0] - more[0] + 1e-100)) ** 2  # a motion may start at its limit
                before, behind = np.minimum(before, early), np.minimum(behind, late)
        if self.limit("acceleration") == np.inf:
            return PathBounds(before, behind)
        limit = _WITHIN * self.limit("acceleration")
        curved = [
            self.velocities(q, grid.bends)[0] + self.bias_acceleration(q, slopes)
            for q, slopes in ((grid.starts, grid.slopes), (until, ends))
        ]
        sides = [_polygon_components(moved[0], bend) for moved, bend in zip(at_ends, curved, strict=True)]
        before, behind = (
            np.minimum(ceiling, limit / np.maximum(across, 1e-100))
            for ceiling, (*_, across) in zip((before, behind), sides, strict=True)
        )
        first, last = (Side(slopes, bends) for slopes, bends, _ in sides)
        most = np.full((n, 2 * _DIRECTIONS), limit * np.cos(0.5 * np.pi / _DIRECTIONS))
        return PathBounds(before, behind, rows_of(grid.steps, first, last, (-most, most)))

    def peaks(self, timed: Timed, since: float) -> tuple[HandPeak, ...]:
        """The peaks of the hand's limited quantities, with bounds at all times."""
        pieces = _pieces_of(timed, since)
        rates = pieces.rates(self)
        limited = [(name, self.limit(name)) for name in QUANTITIES if self.limit(name) < np.inf]
        return tuple(_peak(self, name, timed, pieces, rates, limit) for name, limit in limited)

    def equals(self, other: object) -> bool:
        """Whether another limit is equal and for the same link."""
        return isinstance(other, Hand) and self == other

    def with_dynamics(self, dynamics: object) -> Hand:  # noqa: ARG002 - the signature of PathLimit
        """The hand itself, since attached objects do not change its limits."""
        return self

    def refuse_ends(self, q: Array, velocities: Iterable[Array]) -> None:
        """Raise an error if velocities at the ends of a motion exceed the hand's limits."""
        for name, at, qd in zip(("start_velocity", "end_velocity"), q, velocities, strict=True):
            for quantity, moved in zip(("speed", "angular_speed"), self.velocities(at[None], qd[None]), strict=True):
                value, limit = float(np.linalg.norm(moved)), self.limit(quantity)
                if value > _WITHIN * limit:
                    how = f"{quantity.replace('_', ' ')} of {self.link} would be {value:.4g} {UNITS[quantity]}"
                    raise InputError(
                        name, f"the {how}, but less than its limit of {limit:.4g} is expected; give a slower velocity"
                    )

    def rates(self, extents: Array, *rates: Array) -> _Rates:
        """The data for bounds from derivatives of q, shape (n, n_dof) each. extents: the largest |q|, (n_dof,)."""
        chain = self.tree.chain(self.link)
        moving, columns = chain[:, KIND] != FIXED, chain[:, COLUMN].astype(np.int64)
        slides = np.where(chain[:, KIND] == PRISMATIC, np.abs(chain[:, RATIO]) * extents[columns] + np.abs(chain[:, OFFSET]), 0.0)
        lengths = np.linalg.norm(chain[:, [3, 7, 11]], axis=1) + slides
        behind = np.cumsum(lengths[::-1])[::-1] - lengths
        arms = np.where(chain[:, KIND] == PRISMATIC, 1.0, behind)[moving]
        turns = np.where(chain[:, KIND] == PRISMATIC, 0.0, 1.0)[moving]
        ratios = np.abs(chain[moving, RATIO])
        return _Rates(arms, turns, tuple(np.abs(rate)[:, columns[moving]] * ratios for rate in rates))


class _Rates(NamedTuple):
    """The data for bounds of a hand's derivatives: a lever and derivatives of q for each joint of its chain."""

    arms: Array
    """The largest distance of the hand from the axis of each joint [m], shape (k,); 1 for a slide."""
    turns: Array
    """1 for a revolute joint, 0 for a slide, shape (k,)."""
    of: tuple[Array, ...]
    """The largest first, second, third ... derivative of each joint, shape (n, k) each."""

    def third_derivative_bound(self, weights: Array) -> Array:
        """A bound of the position's third derivative, or of the angular velocity's second, shape (n,)."""
        one, two, three = self.of[:3]
        first, second = (np.cumsum(rate, axis=1) for rate in (one, two))
        return three @ weights + (first * (3.0 * second + first * first)) @ _weight_differences(weights)

    def fourth_derivative_bound(self, weights: Array) -> Array:
        """A bound of the position's fourth derivative, shape (n,)."""
        first, second, third_derivative_bound = (np.cumsum(rate, axis=1) for rate in self.of[:3])
        mixed = 4.0 * third_derivative_bound * first + 3.0 * second**2 + 6.0 * second * first**2 + first**4
        return self.of[3] @ weights + mixed @ _weight_differences(weights)


def _weight_differences(weights: Array) -> Array:
    """The differences of successive weights, shape (k,).

    Weighted with them, a product of cumulative sums gives each product of rates the weight of its last joint.
    """
    steps = weights.copy()
    steps[:-1] -= weights[1:]
    return steps


def _peaks_of_link(peaks: Iterable[Any], link: str) -> Iterator[HandPeak]:
    """The peaks of one hand."""
    return (peak for peak in peaks if isinstance(peak, HandPeak) and peak.link == link)


def as_hands(hand: HandLimits | Iterable[HandLimits] | None, tree: Tree) -> tuple[Hand, ...]:
    """Check given limits of hands, and give each the name of its link.

    Raises:
        InputError: An element is not a ``HandLimits``, no joint moves its link, or a link is named twice.
        UnknownNameError: There is no such link.
    """
    hands: list[Hand] = []
    if hand is not None and (isinstance(hand, (str, bytes, dict)) or not isinstance(hand, (HandLimits, Iterable))):
        raise InputError("hand", f"{cited(hand)}; an ulna.HandLimits, or several, is expected")
    for one in () if hand is None else (hand,) if isinstance(hand, HandLimits) else hand:
        if not isinstance(one, HandLimits):
            raise InputError("hand", f"{cited(one)}; an ulna.HandLimits, or several, is expected")
        link = tree.link_or_tip(one.link)
        if not len(tree.moving_columns(link)):
            raise InputError("hand", f"no joint moves link {link!r}")
        if any(link == other.link for other in hands):
            raise InputError("hand", f"link {link!r} is limited twice")
        hands.append(Hand(tree, replace(one, link=link), CompiledJacobian(tree, link, "base")))
    return tuple(hands)


def _max_between(first: Array, last: Array) -> Array:
    """The largest (speed / limit)^2 within each interval for a hand at its limit at both ends, shape (n,).

    It is computed at 17 samples, since (ds/dt)^2 is linear in the length, and |p'| at most linear.
    """
    share, ratio = np.linspace(0.0, 1.0, 17), (last / first)[:, None]
    return ((1.0 + share * (ratio**-2 - 1.0)) * (1.0 + share * (ratio - 1.0)) ** 2).max(axis=1)


def _polygon_components(slopes: Array, bends: Array) -> tuple[Array, Array, Array]:
    """The components of p' and p'' along a polygon's directions, shape (n, m) each, and |p''| across p', shape (n,)."""
    size = np.linalg.norm(slopes, axis=1)
    forward = slopes / np.where(size > 0.0, size, 1.0)[:, None]
    ahead = (forward * bends).sum(axis=1)
    across = np.linalg.norm(bends - ahead[:, None] * forward, axis=1)
    angles = np.arange(_DIRECTIONS) * np.pi / _DIRECTIONS
    cos, sin = np.cos(angles), np.sin(angles)
    cos[np.abs(cos) < 1e-12] = 0.0
    return size[:, None] * cos, ahead[:, None] * cos + across[:, None] * sin, across


def peak_of(timed: Timed, tree: Tree, link: str | None, quantity: str) -> HandPeak:
    """The peak of one quantity of a link in a motion, without a limit."""
    (hand,) = as_hands(HandLimits(**{quantity: LARGEST}, link=link), tree)
    pieces = _pieces_of(timed, 0.0)
    return _peak(hand, quantity, timed, pieces, pieces.rates(hand), np.inf)


class _Pieces(NamedTuple):
    """A motion as n polynomials: Bernstein coefficients of velocities and accelerations, shape (n, degree + 1, n_dof)."""

    begins: Array
    """The start of each polynomial [s], shape (n,)."""
    steps: Array
    """The durations [s], shape (n,)."""
    velocities: Array
    accelerations: Array
    extents: Array
    """The largest |q|, shape (n_dof,)."""

    def rates(self, hand: Hand) -> _Rates:
        """The data for bounds of the hand's first four derivatives."""
        steps, rates = self.steps[:, None, None], [self.velocities, self.accelerations]
        for degree in (_DEGREE, _DEGREE - 1):
            rates.append(degree / steps * np.diff(rates[-1], axis=1))
        return hand.rates(self.extents, *(np.abs(rate).max(axis=1) for rate in rates))


def _pieces_of(timed: Timed, since: float) -> _Pieces:
    times = np.concatenate([[since], timed.times[timed.times > since]])
    if len(times) < 2:
        times = np.array([since, since])
    steps = np.diff(times)
    if steps.any():
        times, steps = times[:-1][steps > 0.0], steps[steps > 0.0]
    else:
        times, steps = times[:1], np.array([1.0])  # the motion is at rest
    moment = timed.at(np.minimum(times[:, None] + steps[:, None] * _NODES, timed.duration))
    velocities, accelerations = (np.einsum("ij,njk->nik", _AT_NODES, rate) for rate in (moment.qd, moment.qdd))
    extents = (np.abs(moment.q).max(axis=1) + steps[:, None] * np.abs(velocities).max(axis=1)).max(axis=0)
    return _Pieces(times, steps, velocities, accelerations, extents)


def _bernstein(shares: Array) -> Array:
    """The Bernstein polynomials at shares of an interval, shape (n, degree + 1)."""
    k = np.arange(_DEGREE + 1)
    return _CHOICES * shares[:, None] ** k * (1.0 - shares[:, None]) ** (_DEGREE - k)


_AT_NODES = np.linalg.inv(_bernstein(_NODES))  # maps values at the nodes to Bernstein coefficients


def _peak(hand: Hand, quantity: str, timed: Timed, pieces: _Pieces, rates: _Rates, limit: float) -> HandPeak:
    """The peak of a quantity. Its bound is larger by about ``_PRECISION`` of the limit, or of the peak."""
    if quantity == "acceleration":
        second = rates.fourth_derivative_bound(rates.arms)
    else:
        second = rates.third_derivative_bound(rates.arms if quantity == "speed" else rates.turns)
    scale = limit
    if limit == np.inf:
        scale = max(_sample_values(hand, quantity, timed, pieces, np.full(len(second), 2))[0].max(), 1e-9)
    precision = _PRECISION * scale
    parts = pieces.steps * np.sqrt(second / (8.0 * precision))
    parts *= min(1.0, _MAX_SAMPLES / max(parts.sum(), 1.0))
    counts = np.maximum(np.ceil(parts), 1.0).astype(np.int64)
    values, times, of = _sample_values(hand, quantity, timed, pieces, counts)
    bounds = values + (second * (pieces.steps / counts) ** 2 / 8.0)[of]
    worst = int(np.argmax(values))
    return HandPeak(hand.link, quantity, float(values[worst]), float(times[worst]), float(bounds.max()), limit)


def _sample_values(
    hand: Hand, quantity: str, timed: Timed, pieces: _Pieces, counts: NDArray[np.int64]
) -> tuple[Array, Array, Any]:
    """The values of a quantity at even times of each piece, including both ends; the times; and the pieces' indices."""
    of = np.repeat(np.arange(len(counts)), counts + 1)
    first = np.repeat(np.cumsum(counts + 1) - (counts + 1), counts + 1)
    shares = (np.arange(len(of)) - first) / counts[of]
    times = np.minimum(pieces.begins[of] + shares * pieces.steps[of], timed.duration)
    weights = _bernstein(shares)
    q, qd = timed.at(times).q, np.einsum("nj,njk->nk", weights, pieces.velocities[of])
    if quantity != "acceleration":
        moved = hand.velocities(q, qd)[0 if quantity == "speed" else 1]
    else:
        moved = hand.velocities(q, np.einsum("nj,njk->nk", weights, pieces.accelerations[of]))[0] + hand.bias_acceleration(q, qd)
    return np.linalg.norm(moved, axis=1), times, of
