"""Finds why no joint path leads on to a pose. Used by ``follow``.

1. Continue the ends of all paths to the pose: within the limits, and without them.
2. What continues within a step but collides: the collision is the reason. What continues beyond the limits: the limits.
3. Nothing continues within a step: if the pose has no solution at all, inverse kinematics says why. If the arm is singular, or
   nearly so and the step would not be too long without its part along the weakest direction, a singularity is the reason.
4. Else the solutions are on other branches, or further away than a step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.entry_names import entry_names
from ulna.ik.following.course import Course
from ulna.ik.following.result import Ending, PathStatus
from ulna.ik.result import Status
from ulna.kinematics.forward import frame_poses
from ulna.kinematics.jacobian import geometric_jacobian

Array = NDArray[np.float64]
_MOST_ENDS = 64
_SINGULAR, _WEAK = 1e-2, 5e-2  # smallest singular values, of the largest
_SAME = {
    Status.UNREACHABLE: PathStatus.UNREACHABLE,
    Status.JOINT_LIMITS: PathStatus.LIMITS,
    Status.IN_COLLISION: PathStatus.COLLISION,
    Status.SINGULAR: PathStatus.UNREACHABLE,
    Status.STATIONARY: PathStatus.UNREACHABLE,
    Status.NOT_FOUND: PathStatus.UNREACHABLE,
}


def why_it_ends(course: Course, k: int, ends: Array, solutions: Array) -> Ending:
    """Why no path leads to pose k.

    Args:
        course: The path.
        k: The first pose without a path.
        ends: Configurations of the pose before in which paths end, shape (m, n_dof); for the first pose the start, if given.
        solutions: Solutions of pose k within the limits and clear of the world, as far as they are known, shape (j, n_dof).
    """
    facts = _Facts(course, k, ends, solutions)
    for rule in (_unsolved, _collision, _limits, _singularity):
        ending = rule(facts)
        if ending is not None:
            return ending
    many = f"{len(facts.ends)} configuration{'s' * (len(facts.ends) != 1)} led to the pose before; " if k else ""
    return facts.ending(PathStatus.NO_BRANCH, f"{many}{facts.step_in_words()}, and {course.max_step:.3g} is allowed")


class _Facts:
    """What is known about the pose: the ends of paths, continued to it with the limits and without, and other solutions."""

    def __init__(self, course: Course, k: int, ends: Array, solutions: Array) -> None:
        self.course, self.k, self.all_ends = course, k, len(ends)
        self.ends = ends[:: max(1, len(ends) // _MOST_ENDS)]
        order = np.full(len(self.ends), k)
        (self.within, good), (self.beyond, free) = (course.near(order, self.ends, beyond_limits=wide) for wide in (False, True))
        self.hits = course.collide(self.within)
        self.near_within, self.near_beyond = good & self._is_near(self.within), free & self._is_near(self.beyond)
        self.reached = good
        solved = self.within[good & ~self.hits]
        self.solutions = np.vstack([solutions, solved])

    def _is_near(self, q: Array) -> NDArray[np.bool_]:
        return np.abs(self.course.lifts.steps(self.ends, q)[0]).max(axis=-1, initial=0.0) <= self.course.max_step

    @property
    def smallest_step(self) -> float:
        """From any end to any solution, whole turns aside."""
        if not len(self.ends) or not len(self.solutions):
            return float("inf")
        steps = self.course.lifts.steps(self.ends[:, None], self.solutions[None])[0]
        return float(np.abs(steps).max(axis=-1, initial=0.0).min())

    def step_in_words(self) -> str:
        """The smallest step, as the beginning of a sentence."""
        step = self.smallest_step
        return f"the nearest solution is a step of {step:.3g} away" if np.isfinite(step) else "no solution was found"

    def step_of(self, i: int) -> Array:
        """The step from an end to what it continues to, of the joints that move the link."""
        query = self.course.query
        return self.course.lifts.steps(self.ends[i], self.within[i])[0][query.tree.moving_columns(query.link)]

    def jacobian(self, i: int) -> Array:
        """The Jacobian at an end, of the joints that move the link, lengths in the unit of the arm."""
        query = self.course.query
        J = geometric_jacobian(query.tree, self.ends[i], query.link, "base")[:, query.tree.moving_columns(query.link)]
        return J / _units(self.course)[:, None]

    def ending(self, status: PathStatus, reason: str, excess: Array | None = None, collisions: tuple = ()) -> Ending:
        """The result, with the numbers of the best end."""
        values = [np.linalg.svd(self.jacobian(i), compute_uv=False) for i in range(len(self.ends))] or [np.full(1, np.nan)]
        best = max(values, key=lambda value: value[-1] / value[0])
        n_dof = len(self.course.start)
        return Ending(
            status=status,
            reason=reason,
            alive=self.all_ends,
            smallest_step=self.smallest_step,
            manipulability=float(np.prod(best)),
            least_singular_value=float(best[-1] / best[0]) if best[0] else 0.0,
            limit_excess=np.zeros(n_dof) if excess is None else excess,
            collisions=collisions,
        )


def _unsolved(facts: _Facts) -> Ending | None:
    """The reason that inverse kinematics gives, where the pose has no solution at all."""
    if len(facts.solutions) or facts.near_within.any():
        return None
    course = facts.course
    found = course.solve(course.targets[facts.k], course.start)
    if found.success:
        facts.solutions = np.vstack([facts.solutions, found.q])
        return None
    status = _SAME.get(Status(str(found.status)), PathStatus.UNREACHABLE)
    if status is not PathStatus.UNREACHABLE and facts.near_beyond.any():
        return None  # the limits or the collision on the way are told with more detail
    depths = _touching(course, found.q) if status is PathStatus.COLLISION else ()
    return facts.ending(status, found.reason or "no solution was found", np.asarray(found.limit_excess), depths)


def _collision(facts: _Facts) -> Ending | None:
    course, hit = facts.course, facts.near_within & facts.hits
    if not facts.near_within.any() or course.world is None:
        return None
    q = facts.within[hit] if hit.any() else facts.within[facts.near_within]
    reports = [_touching(course, row) for row in q[:8]]
    pairs = min(reports, key=lambda pairs: max((depth for *_, depth in pairs), default=0.0))
    words = ", ".join(f"{a} hits {b} by {depth:.3g} m" for a, b, depth in pairs[:4]) or "something touches between the poses"
    return facts.ending(PathStatus.COLLISION, words, collisions=pairs)


def _limits(facts: _Facts) -> Ending | None:
    tree, near = facts.course.query.tree, facts.beyond[facts.near_beyond]
    excess = np.maximum(np.maximum(tree.lower - near, near - tree.upper), 0.0)
    excess = excess[(excess > 0.0).any(axis=1)]
    if not len(excess):
        return None
    least = excess[excess.max(axis=1).argmin()]
    names = [f"{name} by {x:.3g}" for name, x in zip(entry_names(tree), least, strict=True) if x > 0]
    words = f"leads on only beyond the limits of {', '.join(names)}; else {facts.step_in_words()}"
    return facts.ending(PathStatus.LIMITS, words, least)


def _singularity(facts: _Facts) -> Ending | None:
    """Whether the step would be short enough without its part along the arm's weakest direction, and that is weak."""
    for i in range(len(facts.ends)):
        _, values, Vt = np.linalg.svd(facts.jacobian(i), full_matrices=False)
        share = values[-1] / values[0]
        step = _first_order_step(facts, i) if not facts.reached[i] else facts.step_of(i)
        without = np.abs(step - (step @ Vt[-1]) * Vt[-1]).max(initial=0.0)
        if share < _SINGULAR or (share < _WEAK and without <= facts.course.max_step):
            words = f"the smallest singular value is {share:.2g} of the largest; {facts.step_in_words()}"
            return facts.ending(PathStatus.SINGULAR, f"{words}, and {facts.course.max_step:.3g} is allowed")
    return None


def _first_order_step(facts: _Facts, i: int) -> Array:
    course, end = facts.course, facts.ends[i]
    twist = _twist(_pose(course, end), course.targets[facts.k]) / _units(course)
    return np.linalg.pinv(facts.jacobian(i)) @ twist


def _pose(course: Course, q: Array) -> Array:
    tree = course.query.tree
    return frame_poses(tree, tree.frame_row(course.query.link, np.eye(4))[None], q)[0]


def _units(course: Course) -> Array:
    return np.array([course.query.unit] * 3 + [1.0] * 3)


def _twist(T: Array, target: Array) -> Array:
    """The small motion from one pose to another, in the axes of the base [m, rad], shape (6,)."""
    R = target[:3, :3] @ inverse(T)[:3, :3]
    return np.r_[target[:3, 3] - T[:3, 3], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]] * np.r_[[1.0] * 3, [0.5] * 3]


def _touching(course: Course, q: Array) -> tuple[tuple[str, str, float], ...]:
    """The pairs that overlap, deepest first, and how deep [m]."""
    report = course.query.checker.check_collision(q, course.world, self_collision=True, max_distance=0.0)
    pairs = [(pair.name_a, pair.name_b, -pair.signed_distance) for pair in report.pairs]
    return tuple(sorted(pairs, key=lambda pair: -pair[2]))
