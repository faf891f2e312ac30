"""Decides whether an arm has a closed form, and of which family; the interface of this folder.

The idea. The pose of the end is a product of rotations, rot(h_1, q_1) ... rot(h_6, q_6), about six axes with directions h_i. R is
the given rotation of the end, relative to its orientation at q = 0. The last three axes of a *spherical wrist* intersect in a
point. They do not move this point, so its position p depends on three joints alone:

    p = R_1 (P_1 + R_2 (P_2 + R_3 P_3)),    R_i = rot(h_i, q_i),  P_i the vector from axis i to axis i + 1.

If two of the first axes are parallel or intersect, a length or a component in that equation is independent of two angles. If axes
2 and 3 are parallel, h_2 . R_1' p = h_2 . (P_1 + P_2 + P_3). This is one equation in q_1, the intersection of a circle and a
plane: two angles. The remaining equations are of the same kind, and R_4 R_5 R_6 = (R_1 R_2 R_3)' R gives the wrist. Two angles
each time make eight branches. (If no axes are parallel or intersect, the equation in one angle is a quartic, with up to four
roots.)

1. ``axes`` computes the axes. ``families`` finds which are parallel or intersect, exactly or nearly. It moves the axes to be
   exactly so, and ``miss`` is the size of that move. With a miss of at most 1e-12 a form is *exact*; up to 1e-3 its branches are
   starts of Newton steps. A mimic joint may rotate about the axis of a neighboring joint. The two then count as one joint, which
   rotates by the sum of both angles (``axes.decoupled``).
2. ``added_joints`` turns an arm of fewer joints into one of six. For an arm of seven joints one is held (``branches``).
3. ``six_joints`` makes the table of the kernels (``kernels/chain``), which compute the branches. ``branches`` brings them into
   the limits.

The proof. The equations follow from the pose, so a pose has no other solutions than these: the result is ``complete`` unless
rounding hides a solution. Each branch carries the accuracy of its worst angle. Consider a cos q + b sin q = c. If its amplitude
(a^2 + b^2)^(1/2) is rounding alone, any q solves it. With a solution, the solutions are a continuum; without one, nothing is
proved. If its two roots are equal up to rounding, they are ``coinciding``. If it has no root, and rounding alone may have removed
it, nothing is proved (``kernels/chain/accuracy``).
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError, UnknownNameError
from ulna.ik.closed_form.added_joints import free_turns
from ulna.ik.closed_form.axes import N_AXES, Coupling, decoupled, turning_order
from ulna.ik.closed_form.families import EXACT
from ulna.ik.closed_form.six_joints import SixJoints, six_joints
from ulna.ik.task import Task
from ulna.kinematics.size import longest_slide
from ulna.kinematics.tree import Tree, entry_names, lengthened
from ulna.notebook.tables import OneLine

Array = NDArray[np.float64]
_POSE = Task.pose()
_SHARES = (0.43, 0.31, 0.83)  # of a held joint's range: positions where a family must hold. At the middle, axes may be parallel
_MAX_LINKS, _MAX_PLACES = 64, 256  # entries of the caches: of robots, and of positions of a held joint


@dataclass(frozen=True, eq=False, repr=False)
class ClosedForm(OneLine):
    """The closed form of the inverse kinematics of a link.

    Attributes:
        family: The parallel and the intersecting axes, counted from the base on, without the held joint.
        from_end: Whether the axes are counted from the end on instead.
        held: The held joint, for arms of seven joints; None for fewer.
        n_joints: The number of joints that it moves. Below six, joints are added that the task leaves free, or that are at rest.
        miss: The deviation of the axes from the family: the maximum angle [rad], or distance as a share of the arm's length.
        is_exact: Whether ``miss`` is at most 1e-12, so that the branches are all solutions. Otherwise, up to 1e-3, they are
            starts of Newton steps, which may miss solutions and prove nothing.
        slide: The longest stroke of the prismatic joints [m].
        couplings: The joints that also rotate with another entry of q; ``chain`` is without couplings.
    """

    family: str
    from_end: bool
    held: str | None
    n_joints: int
    miss: float
    is_exact: bool
    chain: Array = field(repr=False)
    columns: tuple[int, ...] = field(repr=False)
    held_column: int | None = field(repr=False)
    n_free: int = field(repr=False)
    slide: float = field(repr=False)
    couplings: tuple[Coupling, ...] = field(repr=False)

    @property
    def n_at_rest(self) -> int:
        """The number of added joints at rest. A reachable pose must satisfy as many conditions."""
        return N_AXES - self.n_joints - self.n_free

    @property
    def geometry(self) -> str:
        """The family, with the held joint, the end from which the axes are counted, and the number of added joints."""
        details = ", counted from the end" if self.from_end else ""
        if self.n_joints < N_AXES:
            details += f", with {N_AXES - self.n_joints} of the joints added"
        prefix = f"with {self.held} held: " if self.held else ""
        return f"{prefix}{self.family}{details}"

    def __str__(self) -> str:
        tier = "exact" if self.is_exact else "near"
        return f"{self.geometry}; {tier}, the axes deviate by {self.miss:.1g}"


def joints_at(form: ClosedForm, q: Array) -> SixJoints:
    """The form of the six joints, with the others at q, shape (n_dof,)."""
    joints = _six_joints(form, None if form.held_column is None else float(q[form.held_column]), len(q))
    if joints is None:
        raise AssertionError("a family that holds at three places of the held joint does not hold at another")
    return joints


def closed_form_of(tree: Tree, link: str, held: str | None = None, task: Task = _POSE) -> ClosedForm | None:
    """The closed form of a link, or None. Of seven joints it holds the one with the smallest miss.

    Args:
        tree: The robot.
        link: The link to bring to a pose.
        held: The joint to hold, for arms of seven joints; the best one unless given.
        task: The components of the pose to reach. The form is that of the task's frame.
    """
    tree.chain(link)
    return _closed_form_of(tree, link, held, task)


@lru_cache(maxsize=_MAX_LINKS)
def _closed_form_of(tree: Tree, link: str, held: str | None, task: Task) -> ClosedForm | None:
    (chain, couplings), n_free = decoupled(tree.chain(link)), free_turns(task)
    order = turning_order(chain)
    if couplings and len(order) != N_AXES:
        return None
    if task.turn is not None:
        chain = lengthened(chain, task.frame)
    if held is not None:
        column = _column_of(tree, held, order)
        return _make_form(tree, chain, order, 0, column) if n_free == 0 else None
    if n_free is None:
        return None
    if len(order) <= N_AXES:
        form = _make_form(tree, chain, order, n_free, None)
        return None if form is None else replace(form, couplings=couplings)
    if len(order) != N_AXES + 1 or n_free:
        return None
    forms = [form for column in _held_order(order) if (form := _make_form(tree, chain, order, 0, column)) is not None]
    return next((form for form in forms if form.is_exact), min(forms, key=lambda form: form.miss, default=None))


def _held_order(order: tuple[int, ...]) -> list[int]:
    """The order in which to try joints to hold.

    The joints at both ends come first: they do not change the geometry of the others.
    """
    return [order[k] for k in (6, 0, 2, 4, 1, 5, 3)]


def _make_form(tree: Tree, chain: Array, order: tuple[int, ...], n_free: int, held: int | None) -> ClosedForm | None:
    columns = tuple(column for column in order if column != held)
    slide = longest_slide(chain, tree.lower, tree.upper)
    forms = [six_joints(chain, columns, q, n_free, slide) for q in _places(tree, held)]
    if any(form is None for form in forms):
        return None
    families = [form.family for form in forms if form is not None]
    if len({(family.number, family.from_end) for family in families}) > 1:
        return None
    miss = max(family.miss for family in families)
    names = entry_names(tree)
    return ClosedForm(
        family=families[0].rule.name,
        from_end=families[0].from_end,
        held=None if held is None else names[held],
        n_joints=len(columns),
        miss=miss,
        is_exact=miss <= EXACT,
        chain=chain,
        columns=columns,
        held_column=held,
        n_free=n_free,
        slide=slide,
        couplings=(),
    )


def _places(tree: Tree, held: int | None) -> list[Array]:
    """Configurations at which a family must hold."""
    if held is None:
        return [np.zeros(tree.n_dof)]
    low, high = held_range(tree, held)
    return [np.where(np.arange(tree.n_dof) == held, low + share * (high - low), 0.0) for share in _SHARES]


def held_range(tree: Tree, column: int) -> tuple[float, float]:
    """The range of a held joint: its limits, at most one turn; without limits half a turn to both sides."""
    low, high = float(tree.lower[column]), float(tree.upper[column])
    if not np.isfinite(low) or not np.isfinite(high):
        return -np.pi, np.pi
    return low, high


@lru_cache(maxsize=_MAX_PLACES)
def _six_joints(form: ClosedForm, held_at: float | None, n_dof: int) -> SixJoints | None:
    q = np.zeros(n_dof)
    if form.held_column is not None and held_at is not None:
        q[form.held_column] = held_at
    return six_joints(form.chain, form.columns, q, form.n_free, form.slide)


def _column_of(tree: Tree, joint: str, order: tuple[int, ...]) -> int:
    names = entry_names(tree)
    if joint not in names:
        raise UnknownNameError("joint", str(joint), names)
    if len(order) != N_AXES + 1 or names.index(joint) not in order:
        raise InputError("redundancy", f"{joint!r}; a joint is held for arms of seven joints, one of them")
    return names.index(joint)
