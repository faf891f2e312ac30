"""Turns results into plain data, which JSON can hold. Used by every command."""

import numpy as np
from numpy.typing import NDArray

from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Data = dict[str, object]
Q_KEYS = "robot; q; outside_limits: joints of q beyond their limits"


def plain(value):
    """A value as dictionaries, lists, strings and numbers; NaN and infinity, which JSON has not, become None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def data_of_q(robot: Robot, q: NDArray[np.float64]) -> Data:
    """The robot's name, q, shape (n_dof,), and the joints beyond their limits; see ``Q_KEYS``."""
    outside = (q < robot.lower) | (q > robot.upper)
    names = [entry.name for entry, out in zip(coordinates_of(robot), outside, strict=True) if out]
    return {"robot": robot.name, "q": q, "outside_limits": names}
