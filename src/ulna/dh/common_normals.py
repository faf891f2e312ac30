"""Computes the axes of a serial arm, their common normals, and the DH parameters between them.

The lines are the z axis of the base, the axes of the n joints, and the z axis of the tip. A common normal, along x, leads from
each line to the next. So the arm at zero is

    Z_0 X_0  Z_1 X_1 ... Z_n X_n  Z_n+1      with  Z = Tz(d) Rz(theta)  and  X = Tx(a) Rx(alpha)

Both conventions are this one product, cut differently: a modified row is X_(i-1) Z_i, a standard row is Z_i X_i.
Source: Craig, Introduction to Robotics (3rd ed., 2005), sections 3.4 and 3.5.

Rules where the product is not unique:

1. z points along the joint's positive direction, so no joint needs a sign.
2. x and -x are both valid. x_i is the one with the smaller rotation from x_(i-1) (theta in (-pi/2, pi/2]), so a may be negative.
   The last x of a standard table is the one with the smaller rotation to the tip's x, where the table ends.
3. Parallel axes have a common normal everywhere: take the one that makes d of the first axis zero. For coincident axes theta is
   zero too.
4. If the last axis is parallel to the tip's z, the last common normal may start anywhere on this axis. In a standard table it
   starts at the projection of the tip's origin onto the axis. In a modified table it starts at the last joint's own origin. If
   the axis and the tip's z coincide, x_n is the tip's x.
5. The base's z and the tip's z count as parallel to their neighbor within 1e-3 rad. T_base_0 and T_n_tip represent any tilt
   exactly, and a distant common normal would be useless.
6. Only the direction of a prismatic joint matters, so its axis may be placed anywhere. It passes through the origin of the next
   frame, which makes a and the next d zero. This origin is the start of the common normal of the next two axes. If these two are
   within 1e-3 rad of parallel, the start is far away or arbitrary. The prismatic axis then passes through the next joint's own
   origin. If the second of the two is the tip's z, a standard table uses the projection of rule 4 instead.
7. By rule 3 a normal starts at the end of the previous normal. This point may be farther away than the arm is long, if the
   previous axes are nearly parallel. The normal then starts at the joint's own origin. The reason: a tilt that is neglected
   causes an error in proportion to the distance of the normal. If the axes have no tilt, rule 3 holds at any distance.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_SLACK = 1e-9  # a rotation by a quarter or a half turn counts as positive, also after rounding
_ROUNDING = 1e-12  # [m]: displacement by a tilt that is rounding alone
NEARLY_PARALLEL = 1e-3  # [rad]


@dataclass(frozen=True, eq=False)
class Axes:
    """Lines in the base's frame: ``points`` and ``directions``, shape (n + 2, 3), from base to tip.

    ``prismatic`` has an entry for each line; ``x_tip`` is the tip's x axis.
    """

    points: Array
    directions: Array
    prismatic: tuple[bool, ...]
    x_tip: Array

    def parallel(self, tolerance: float) -> NDArray[np.bool_]:
        """Mask of the lines that are parallel to the next one, by rule 5 at the ends."""
        tolerances = np.full(len(self.directions) - 1, tolerance)
        tolerances[[0, -1]] = max(tolerance, NEARLY_PARALLEL)
        return self.tilts <= tolerances

    @property
    def length(self) -> float:
        """The length of the path from point to point [m]."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    @property
    def tilts(self) -> Array:
        """The angle [rad] between neighboring lines; 0 for parallel and for opposite ones. Large angles are given as sines."""
        return np.linalg.norm(np.cross(self.directions[:-1], self.directions[1:]), axis=1)


@dataclass(frozen=True, eq=False)
class Normals:
    """The normals X_0 ... X_n as ``a`` and ``alpha``, and Z_1 ... Z_n as ``d`` and ``theta``.

    Normal i runs along ``x[i]``, from ``starts[i]`` on line i to ``ends[i]`` on line i + 1; shape (n + 1, 3).
    """

    a: Array
    alpha: Array
    d: Array
    theta: Array
    x: Array
    starts: Array
    ends: Array


def common_normals(axes: Axes, *, ends_at_tip: bool, tolerance: float) -> Normals:
    """The common normals of a chain of axes.

    Args:
        axes: The lines.
        ends_at_tip: The rule for the end (rule 4, and the end of rule 2): True for a standard table.
        tolerance: Axes within this angle [rad] are parallel; parallel ones within this distance [m] coincide.
    """
    z, parallel = axes.directions, axes.parallel(tolerance)
    points = _place_prismatic_axes(axes, parallel, ends_at_tip=ends_at_tip)
    last_line, xs, starts, ends = len(z) - 2, [np.array([1.0, 0.0, 0.0])], [], [points[0]]
    for i in range(last_line + 1):
        if parallel[i]:
            start = _free_start(i, axes, points, ends[-1], ends_at_tip=ends_at_tip)
            end = _project(start, points[i + 1], z[i + 1])
            direction = end - start
        else:
            start, end = _nearest_points(points[i], z[i], points[i + 1], z[i + 1])
            direction = np.cross(z[i], z[i + 1])
        if parallel[i] and np.linalg.norm(direction) <= tolerance:
            x = _perpendicular(axes.x_tip if i == last_line else xs[-1], z[i])
        else:
            x = _perpendicular(direction, z[i])
            to_tip = ends_at_tip and i == last_line
            angle = _angle(x, axes.x_tip, z[i + 1]) if to_tip else _angle(xs[-1], x, z[i])
            x = x if -np.pi / 2 + _SLACK < angle <= np.pi / 2 + _SLACK else -x
        xs.append(x)
        starts.append(start)
        ends.append(end)
    return _dh_numbers(z, np.array(xs), np.array(starts), np.array(ends))


def _dh_numbers(z: Array, xs: Array, starts: Array, ends: Array) -> Normals:
    """Compute the four DH numbers; ``xs`` begins with the base's x, ``ends`` with its origin."""
    x = xs[1:]
    return Normals(
        a=_row_products(x, ends[1:] - starts),
        alpha=np.array([_angle(*pair) for pair in zip(z[:-1], z[1:], x, strict=True)]),
        d=_row_products(z[1:-1], starts[1:] - ends[1:-1]),
        theta=np.array([_angle(*pair) for pair in zip(x[:-1], x[1:], z[1:-1], strict=True)]),
        x=x,
        starts=starts,
        ends=ends[1:],
    )


def _place_prismatic_axes(axes: Axes, parallel: NDArray[np.bool_], *, ends_at_tip: bool) -> Array:
    """The points, with those of prismatic axes moved to the next frame's origin, from tip to base."""
    points, z, tip = axes.points.copy(), axes.directions, len(axes.points) - 1
    for i in range(tip - 1, 0, -1):
        if not axes.prismatic[i]:
            continue
        following = i + 1
        points[i] = points[following]
        if following == tip or axes.prismatic[following]:
            continue
        if following + 1 == tip and parallel[following]:
            points[i] = _free_start(following, axes, points, points[following], ends_at_tip=ends_at_tip)
        elif axes.tilts[following] > NEARLY_PARALLEL:
            points[i] = _nearest_points(points[following], z[following], points[following + 1], z[following + 1])[0]
    return points


def _free_start(i: int, axes: Axes, points: Array, previous_end: Array, *, ends_at_tip: bool) -> Array:
    """The point of line i where the normal to a parallel line begins."""
    if i == len(points) - 2:
        return _project(points[-1], points[i], axes.directions[i]) if ends_at_tip else points[i]
    if axes.prismatic[i]:
        return points[i]
    distance = np.linalg.norm(previous_end - points[i])
    return previous_end if distance <= axes.length or axes.tilts[i] * distance <= _ROUNDING else points[i]


def _nearest_points(p: Array, u: Array, s: Array, v: Array) -> tuple[Array, Array]:
    """The nearest points of two lines, through p along u and through s along v."""
    normal, between = np.cross(u, v), s - p
    square = normal @ normal
    return p + u * (np.cross(between, v) @ normal / square), s + v * (np.cross(between, u) @ normal / square)


def _project(point: Array, p: Array, u: Array) -> Array:
    return p + u * ((point - p) @ u)


def _perpendicular(vector: Array, z: Array) -> Array:
    """The unit vector along the component of a vector orthogonal to z."""
    component = vector - (vector @ z) * z
    return component / np.linalg.norm(component)


def _angle(start: Array, end: Array, about: Array) -> float:
    angle = float(np.arctan2(np.cross(start, end) @ about, start @ end))
    return angle if angle > -np.pi + _SLACK else angle + 2 * np.pi


def _row_products(x: Array, vectors: Array) -> Array:
    return np.einsum("ij,ij->i", x, vectors)
