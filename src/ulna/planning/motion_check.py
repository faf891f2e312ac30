"""Checks a motion as an arm's controller does, by finite differences of the commanded positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.planning.arm_limits import ArmLimits
from ulna.planning.hand import HandPeak
from ulna.planning.motors import TorquePeak
from ulna.planning.positions import Beyond
from ulna.planning.timing import QUANTITIES

Array = NDArray[np.float64]
_ROUNDING = 16 * np.finfo(float).eps  # relative rounding of a position, and of the time times the velocity
_LITTLE = 1.1  # a smaller multiple of a limit is reported in percent above it


class Samples(NamedTuple):
    """The samples for a controller: one row per period.

    Attributes:
        t: Times [s], shape (n,), evenly spaced from 0.
        q: Positions [rad or m], shape (n, n_dof).
        qd: Velocities [rad/s or m/s], shape (n, n_dof).
        qdd: Accelerations [rad/s^2 or m/s^2], shape (n, n_dof).
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array


@dataclass(frozen=True)
class MotionCheck:
    """The check of a motion against limits. ``bool(check)`` is True if the motion is within all limits.

    The attributes name the worst violation, or the value nearest to its limit if there is no violation.

    Attributes:
        within: Whether all differences of samples are within their limits, up to rounding, and all hands and torques too.
        joint: The joint of the value; or the link of a hand that violates its limit.
        quantity: "velocity", "acceleration" or "jerk" of a joint; "position" if the motion leaves the position limits; "speed",
            "acceleration" or "angular_speed" of a hand that violates its limit; or "torque".
        time: The time of the value [s].
        value: The magnitude [rad/s, rad/s^2 or rad/s^3; m for a slide]; or the extreme position [rad or m].
        limit: The limit, in the unit of ``value``.
        period: The time between two samples [s].
        hands: The peak speed and acceleration of each limited hand, at all times.
        torques: The torque with the largest share of its limit, if torques are limited.
    """

    within: bool
    joint: str
    quantity: str
    time: float
    value: float
    limit: float
    period: float
    hands: tuple[HandPeak, ...] = ()
    torques: tuple[TorquePeak, ...] = ()
    _beside: bool = False  # whether the worst violation is a hand's or a torque's

    def __bool__(self) -> bool:
        return self.within

    def with_peaks(self, peaks: Sequence[HandPeak | TorquePeak]) -> MotionCheck:
        """A copy with peaks of hands and torques."""
        hands = tuple(peak for peak in peaks if isinstance(peak, HandPeak))
        torques = tuple(peak for peak in peaks if isinstance(peak, TorquePeak))
        checked = replace(self, within=self.within and all(peaks), hands=hands, torques=torques)
        beyond = [peak for peak in peaks if not peak]
        if not beyond or not self.within:
            return checked
        worst = max(beyond, key=lambda peak: peak.share)
        of = (worst.link, worst.quantity) if isinstance(worst, HandPeak) else (worst.joint, "torque")
        found = dict(zip(("joint", "quantity"), of, strict=True)) | {
            "time": worst.time,
            "value": worst.value,
            "limit": worst.limit,
        }
        return replace(checked, _beside=True, **found)

    def beyond_position(self, beyond: Beyond, names: Sequence[str]) -> MotionCheck:
        """A copy with a violation of position limits."""
        return replace(
            self,
            within=False,
            joint=names[beyond.column],
            quantity="position",
            time=beyond.time,
            value=beyond.position,
            limit=beyond.limit,
            _beside=False,
        )

    def __str__(self) -> str:
        if self._beside:
            return f"beyond a limit: {'; '.join(str(peak) for peak in (*self.hands, *self.torques) if not peak)}"
        return "; ".join([self._of_joints, *map(str, (*self.hands, *self.torques))])

    @property
    def _of_joints(self) -> str:
        if self.quantity == "position":
            which, by = "upper" if self.value > self.limit else "lower", abs(self.value - self.limit)
            beyond = f"{by:.3g} beyond its {which} limit of {self.limit:.6g}"
            return f"beyond a limit: the position of {self.joint} is {self.value:.6g} at {self.time:.3f} s, {beyond}"
        verdict = "within the limits" if self.within else "beyond a limit"
        share, value = ", where 0 is allowed", f"{self.value:.4g}"
        if self.limit:
            of = self.value / self.limit
            share = f", {100.0 * of:.4g} % of its limit of" if self.within else f", {of:.4g} times its limit of"
            share += f" {self.limit:.4g}"
        if not self.within and self.value < _LITTLE * self.limit:
            share = f", {100.0 * (self.value - self.limit) / self.limit:.2g} % above its limit of {self.limit:.9g}"
            value = f"{self.value:.9g}"
        return (
            f"{verdict}: the {self.quantity} of {self.joint} is {value} at {self.time:.3f} s{share}, "
            f"by differences of samples {self.period * 1e3:.4g} ms apart"
        )


def check_of(samples: Samples, period: float, limits: ArmLimits, names: Sequence[str], ends: Array) -> MotionCheck:
    """Check samples. ends: the velocities before the first and after the last sample, shape (2, n_dof)."""
    steps = period * np.arange(1.0, 4.0)[:, None]
    q = np.concatenate([samples.q[0] - steps[::-1] * ends[0], samples.q, samples.q[-1] + steps * ends[1]])
    size = max(1.0, float(np.abs(q).max()), float(samples.t[-1] * np.abs(np.diff(q, axis=0)).max() / period))
    worst, found = (False, -1.0), ("", "", 0.0, 0.0, 0.0)
    differences = q
    for order, quantity in enumerate(QUANTITIES[1:], start=1):
        differences = np.diff(differences, axis=0) / period
        most = _allowed(quantity, limits, q[order:], differences)
        if most is None:
            continue
        values = np.abs(differences)
        rounding = _ROUNDING * (2.0 / period) ** order * size
        over = values > most + rounding
        beyond = bool(over.any())
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(over if beyond else values > rounding, values / most, 0.0)
        row, joint = divmod(int(np.argmax(shares)), shares.shape[1])
        share = float(shares[row, joint])
        if (beyond, share) > worst:  # violations come before values within rounding
            time = max(0.0, (row + order - 3) * period)
            worst, found = (beyond, share), (names[joint], quantity, time, float(values[row, joint]), float(most[row, joint]))
    return MotionCheck(not worst[0], *found, period)


def _allowed(quantity: str, limits: ArmLimits, q: Array, differences: Array) -> Array | None:
    """The limit of each difference, shape (n, n_dof), or None. q: the positions at the differences' ends."""
    if quantity == "velocity":
        return limits.velocity_at(q, differences)
    most = getattr(limits, quantity)
    return None if most is None else np.broadcast_to(most, differences.shape)
