"""Finds the reason why no joint path continues to a pose.

1. Continue the ends of all paths to the pose: within the limits, and without them.
2. If they continue within a step but collide, the collision is the reason. If they continue beyond the limits, the limits are.
3. If nothing continues within a step, and the pose has no solution at all, inverse kinematics gives the reason. The reason is a
   singularity if the arm is nearly singular, and one component alone makes the step too long. This component is the step along
   the right singular vector of the smallest singular value.
4. Otherwise the solutions are on other branches, or farther away than a step.

If the limits allow too many whole turns, ``lifts`` searches only some of them. Before step 2, it is checked whether a short step
leads to a turn outside the search. This is then the reason.

A step is the difference of two configurations, shortened by the whole turns that the limits allow. If the limits force a joint to
make a whole turn, the turn counts in full.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.errors import count_of
from ulna.ik.followed_path import Ending, PathStatus
from ulna.ik.following.course import Course
from ulna.ik.reason import Reason
from ulna.ik.result import Status
from ulna.kernels.chain.closed_form_layout import AT_LIMIT
from ulna.kinematics.forward import frame_poses
from ulna.kinematics.jacobian import geometric_jacobian
from ulna.kinematics.tree import entry_names
from ulna.kinematics.turns import TURN

Array = NDArray[np.float64]
_MAX_ENDS = 64
_WEAK = 5e-2  # smallest singular value relative to the largest
_SAME = {Status.JOINT_LIMITS: PathStatus.LIMITS, Status.IN_COLLISION: PathStatus.COLLISION}


def why_it_ends(course: Course, k: int, ends: Array, solutions: Array, *, are_all: bool) -> Reason:
    """The reason why no path leads to pose k.

    Args:
        course: The path.
        k: The first pose without a path.
        ends: Configurations of the previous pose in which paths end, shape (m, n_dof); for the first pose the start, if given.
        solutions: Known solutions of pose k within the limits and clear of the world, shape (j, n_dof).
        are_all: Whether these are proved to be all, so that no other step counts.
    """
    facts = _Facts(course, k, ends, solutions, are_all=are_all)
    for rule in (_unsolved, _start_beyond_limits, _omitted_turn, _collision, _limits, _singularity):
        ending = rule(facts)
        if ending is not None:
            return ending
    many = f"{len(facts.all_ends)} configuration{'s' * (len(facts.all_ends) != 1)} led to the pose before; " if k else ""
    return facts.ending(PathStatus.NO_BRANCH, f"{many}{facts.step_in_words()}, but max_step is {course.max_step:.3g}")


def out_of_time(course: Course, k: int, ends: Array) -> Reason:
    """The reason if the time was over before a path to pose k was found.

    ends: Configurations in which paths to the previous pose end, shape (m, n_dof).
    """
    many = f"; {count_of(len(ends), 'configuration')} led to the pose before" if k else ""
    words = f"time_limit={course.limit.seconds:g} was over before a path to it was found{many}; give more time"
    return _Facts(course, k, ends, ends[:0], are_all=False).ending(PathStatus.BUDGET_SPENT, words)


class _Facts:
    """The facts about the pose: the ends of paths, their continuations with and without the limits, and other solutions."""

    def __init__(self, course: Course, k: int, ends: Array, solutions: Array, *, are_all: bool) -> None:
        self.course, self.k, self.all_ends = course, k, ends
        self.ends = ends[:: max(1, len(ends) // _MAX_ENDS)]
        order = np.full(len(self.ends), k)
        (self.within, good), (self.beyond, free) = (
            course.solutions_near(order, self.ends, beyond_limits=wide) for wide in (False, True)
        )
        self.hits = course.collide(self.within)
        self.beyond = self.ends + course.lifts.steps(self.ends, self.beyond)[0]
        self.near_within = good & self._is_short(course.steps_within(self.ends, self.within))
        self.near_beyond = free & self._is_short(self.beyond - self.ends)
        self.reached = good
        solved = self.within[good & ~self.hits]
        self.solutions = solutions if are_all and len(solutions) else np.vstack([solutions, solved])

    def _is_short(self, steps: Array) -> NDArray[np.bool_]:
        return np.abs(steps).max(axis=-1, initial=0.0) <= self.course.max_step

    @property
    def smallest_step(self) -> float:
        """The smallest step from any end to any solution, with the whole turns that the limits allow."""
        if not len(self.ends) or not len(self.solutions):
            return float("inf")
        steps = self.course.steps_within(self.all_ends[:, None], self.solutions[None])
        return float(np.abs(steps).max(axis=-1, initial=0.0).min())

    def step_in_words(self) -> str:
        """The smallest step, as the beginning of a sentence."""
        step = self.smallest_step
        return f"the nearest solution is a step of {step:.3g} away" if np.isfinite(step) else "no solution was found"

    def step_of(self, i: int) -> Array:
        """The step from an end to its continuation, for the joints that move the link."""
        query = self.course.query
        return self.course.steps_within(self.ends[i], self.within[i])[query.tree.moving_columns(query.link)]

    def jacobian(self, i: int) -> Array:
        """The Jacobian at an end, for the joints that move the link, with lengths in the unit of the arm."""
        query = self.course.query
        J = geometric_jacobian(query.tree, self.ends[i], query.link, "base")[:, query.tree.moving_columns(query.link)]
        return J / _units(self.course)[:, None]

    def ending(self, status: PathStatus, sentence: str, excess: Array | None = None, collisions: tuple = ()) -> Reason:
        """The reason, with the numbers of the best end."""
        values = [np.linalg.svd(self.jacobian(i), compute_uv=False) for i in range(len(self.ends))] or [np.full(1, np.nan)]
        best = max(values, key=lambda value: value[-1] / value[0])
        n_dof = len(self.course.start)
        ending = Ending(
            status=status,
            alive=len(self.all_ends),
            smallest_step=self.smallest_step,
            manipulability=float(np.prod(best)),
            least_singular_value=float(best[-1] / best[0]) if best[0] else 0.0,
            limit_excess=np.zeros(n_dof) if excess is None else excess,
            collisions=collisions,
        )
        return Reason(sentence, ending)


def _unsolved(facts: _Facts) -> Reason | None:
    """The reason from inverse kinematics, if the pose has no solution at all."""
    if len(facts.solutions) or facts.near_within.any():
        return None
    course = facts.course
    found = course.solve(course.targets[facts.k], course.start)
    if found.success:
        facts.solutions = np.vstack([facts.solutions, found.q])
        return None
    status = _SAME.get(Status(str(found.status)), PathStatus.UNREACHABLE)
    if status is not PathStatus.UNREACHABLE and facts.near_beyond.any():
        return None  # the limits or the collision on the way are the better reason
    depths = _touching(course, found.q) if status is PathStatus.COLLISION else ()
    return facts.ending(status, str(found.reason) or "no solution was found", np.asarray(found.limit_excess), depths)


def _start_beyond_limits(facts: _Facts) -> Reason | None:
    """The reason if the given start is beyond the limits, and the first pose not near its clipped position."""
    course, excess = facts.course, facts.course.start_excess
    is_near = facts.near_within.any() or facts.smallest_step <= course.max_step
    if facts.k or is_near or not (excess > AT_LIMIT).any():
        return None
    words = f"q_start is beyond the limits of {_excess_in_words(course, excess)}; from the nearest configuration within them"
    return facts.ending(PathStatus.LIMITS, f"{words} {facts.step_in_words()}, but max_step is {course.max_step:.3g}", excess)


def _omitted_turn(facts: _Facts) -> Reason | None:
    """The reason if a step leads to a turn that was not searched."""
    course, lifts = facts.course, facts.course.lifts
    if not lifts.cut.any():
        return None
    steps = course.steps_within(facts.all_ends[:, None], facts.solutions[None])
    ends = facts.all_ends[:, None] + steps
    is_omitted = lifts.cut & ((ends < lifts.lower - AT_LIMIT) | (ends > lifts.lower + TURN * lifts.counts + AT_LIMIT))
    leading = is_omitted[(np.abs(steps).max(axis=-1, initial=0.0) <= course.max_step) & is_omitted.any(axis=-1)]
    if not len(leading):
        return None
    joints = np.flatnonzero(leading.any(axis=0))
    names = ", ".join(f"{count_of(lifts.counts[j], 'turn')} of {entry_names(course.query.tree)[j]}" for j in joints)
    words = f"{names} about the start were searched, fewer than the limits allow; a step of {facts.smallest_step:.3g} continues"
    return facts.ending(PathStatus.NO_BRANCH, f"{words} to another turn: follow the rest from there")


def _collision(facts: _Facts) -> Reason | None:
    course, hit = facts.course, facts.near_within & facts.hits
    if not facts.near_within.any() or course.world is None:
        return None
    q = facts.within[hit] if hit.any() else facts.within[facts.near_within]
    reports = [_touching(course, row) for row in q[:8]]
    pairs = min(reports, key=lambda pairs: max((depth for *_, depth in pairs), default=0.0))
    words = ", ".join(f"{a} hits {b} by {depth:.3g} m" for a, b, depth in pairs[:4]) or "something touches between the poses"
    return facts.ending(PathStatus.COLLISION, words, collisions=pairs)


def _limits(facts: _Facts) -> Reason | None:
    nearest = facts.beyond[facts.near_beyond]
    excess = facts.course.excess(nearest)
    excess = excess[(excess > AT_LIMIT).any(axis=1)]
    if not len(excess):
        return None
    min_excess = excess[excess.max(axis=1).argmin()]
    joints = _excess_in_words(facts.course, min_excess)
    words = f"the path continues only beyond the limits of {joints}; within them {facts.step_in_words()}"
    return facts.ending(PathStatus.LIMITS, words, min_excess)


def _excess_in_words(course: Course, excess: Array) -> str:
    """The joints beyond their limits, with their excess."""
    names = entry_names(course.query.tree)
    return ", ".join(f"{name} by {x:.3g}" for name, x in zip(names, excess, strict=True) if x > AT_LIMIT)


def _singularity(facts: _Facts) -> Reason | None:
    """The reason if the step is too long only by its part along the arm's weakest direction.

    The arm must be nearly singular. This is defined for whole poses only.
    """
    if not facts.course.is_whole:
        return None
    longest = facts.course.max_step
    for i in range(len(facts.ends)):
        _, values, Vt = np.linalg.svd(facts.jacobian(i), full_matrices=False)
        share = values[-1] / values[0]
        steps = [_first_order_step(facts, i)] + [facts.step_of(i)] * bool(facts.reached[i])
        reduced = [step - (step @ Vt[-1]) * Vt[-1] for step in steps]
        is_reason = [_largest(step) > longest >= _largest(rest) for step, rest in zip(steps, reduced, strict=True)]
        if share < _WEAK and any(is_reason):
            words = f"the smallest singular value is {share:.2g} of the largest; {facts.step_in_words()}"
            return facts.ending(PathStatus.SINGULAR, f"{words}, but max_step is {facts.course.max_step:.3g}")
    return None


def _largest(step: Array) -> float:
    return float(np.abs(step).max(initial=0.0))


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
    """The pairs that overlap, deepest first, with their depths [m]."""
    report = course.query.checker.check_collision(q, course.world, self_collision=True, max_distance=0.0)
    pairs = [(pair.name_a, pair.name_b, -pair.signed_distance) for pair in report.pairs]
    return tuple(sorted(pairs, key=lambda pair: -pair[2]))
