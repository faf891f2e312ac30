"""Makes the ROS message of a trajectory, whose names are the same in ROS 1 and ROS 2."""

# pyright: reportMissingImports=false
# ROS is installed by the system, not by pip, so pyright cannot check these imports without it.

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import positive
from ulna.errors import InputError, MissingROSError, UnknownNameError
from ulna.planning.timing import Moment

Array = NDArray[np.float64]
_NANO = 1_000_000_000


def joint_trajectory(
    at: Callable[[Array], Moment], rests: Array, ends: Array, known: Sequence[str], joint_names: Sequence[str], period: float
) -> Any:
    """Make a ``trajectory_msgs/JointTrajectory``; see ``Trajectory.to_ros``. ends: velocities, shape (2, n_dof)."""
    period = positive("period", period, "a time [s] above 0")
    names = (joint_names,) if isinstance(joint_names, str) else tuple(joint_names)
    for name in names:
        if name not in known:
            raise UnknownNameError("joint", str(name), known)
    twice = next((name for name in names if names.count(name) > 1), None)
    if not names or twice is not None:
        raise InputError("joint_names", "no joint is named; None means all" if not names else f"{twice!r} is named twice")
    columns = [known.index(name) for name in names]
    try:
        from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint  # noqa: PLC0415 - part of the caller's ROS
    except ImportError as error:
        reason = f"this Python cannot import trajectory_msgs: {' '.join(str(error).split())}"
        raise MissingROSError(
            f"a message needs trajectory_msgs of ROS ({reason}); docs/ros.md names its packages, to_csv needs none"
        ) from None
    points = []
    for time, *values in message_points(at, rests, ends, columns, period):
        point = JointTrajectoryPoint(**dict(zip(("positions", "velocities", "accelerations"), values, strict=True)))
        _set_time(point.time_from_start, *time)
        points.append(point)
    return JointTrajectory(joint_names=list(names), points=points)


def message_points(
    at: Callable[[Array], Moment], rests: Array, ends: Array, columns: Sequence[int], period: float
) -> Iterator[tuple[tuple[int, int], list[float], list[float], list[float]]]:
    """Yield the points of a message: (seconds, nanoseconds), positions, velocities and accelerations of some columns."""
    t, at_rest = _sample_times(rests, period)
    q, qd, qdd = (values[:, columns] for values in at(t)[:3])
    qd[at_rest] = 0.0  # exactly 0: a ROS 2 controller refuses a trajectory that does not end at rest
    if len(t) > 1:
        qd[[0, -1]] = ends[:, columns]
    qdd[at_rest[1:-1]] = 0.0  # 0, since the accelerations before and after a stop differ
    times = (divmod(round(seconds * _NANO), _NANO) for seconds in t.tolist())
    yield from zip(times, q.tolist(), qd.tolist(), qdd.tolist(), strict=True)


def _sample_times(rests: Array, period: float) -> tuple[Array, list[int]]:
    """Times at most a period apart, evenly spaced between rests and including them; the indices of the rests."""
    t, at = [rests[0]], [0]
    for begin, end in pairwise(rests.tolist()):
        if end > begin:
            t += np.linspace(begin, end, max(1, int(np.ceil((end - begin) / period - 1e-9))) + 1)[1:].tolist()
            at.append(len(t) - 1)
    return np.array(t), at


def _set_time(duration: Any, whole: int, rest: int) -> None:
    """Set a duration; its fields are secs and nsecs in ROS 1, sec and nanosec in ROS 2."""
    one = hasattr(duration, "secs")
    setattr(duration, "secs" if one else "sec", whole)
    setattr(duration, "nsecs" if one else "nanosec", rest)
