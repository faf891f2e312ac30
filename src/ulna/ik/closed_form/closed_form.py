"""Says whether an arm has a closed form, and of which family; from here the other folders import.

The idea. The pose of the end is a product of turns, rot(h_1, q_1) ... rot(h_6, q_6), about six axes with directions h_i. With a
*spherical wrist* the last three axes intersect in a point, which they do not move: its place p depends on three joints alone,

    p = R_1 (P_1 + R_2 (P_2 + R_3 P_3)),    R_i = rot(h_i, q_i),  P_i the way from axis i to axis i + 1.

Where two of the first axes are parallel or intersect, a length or a part of that equation does not depend on two of the angles:
if axes 2 and 3 are parallel, h_2 . R_1' p = h_2 . (P_1 + P_2 + P_3). That is one equation in q_1, a circle cut by a plane: two
angles. What is left is again of that kind, and R_4 R_5 R_6 = (R_1 R_2 R_3)' R gives the wrist: two each time, eight branches.
(Where no axes are parallel or intersect, the equation in one angle is a quartic, with up to four.)

1. ``axes``: where the axes are. ``families``: which are parallel or intersect, or nearly; then the axes are moved to be exactly
   so, and ``miss`` says by how much. With a miss of at most 1e-12 a form is *exact*; up to 1e-3 its branches are starts of
   Newton steps.
   A joint that another one turns too is seen as one that turns by the sum of both (``axes.decoupled``).
2. ``added_joints``: an arm of fewer joints becomes one of six. Of an arm of seven one joint is held (``branches``).
3. ``six_joints``: the table of the kernels (``kernels/chain``), which compute the branches; ``branches``: within the limits.

The proof. The equations follow from the pose, so a pose has no solution but those found: it is ``complete`` unless rounding
hides one. Each branch carries how well its worst angle is determined. Where a cos q + b sin q = c has an amplitude
(a^2 + b^2)^(1/2) of nothing but rounding, any q solves it: the solutions are a continuum where there is one, and else
nothing is proved. Where its two roots are one to rounding, they are ``coinciding``. Where it has no root, but rounding alone may
have taken it, nothing is proved (``kernels/chain/accuracy``).
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
_SHARES = (0.43, 0.31, 0.83)  # of the range of a held joint: where a family has to hold. In the middle axes may be parallel
_MAX_LINKS, _MAX_PLACES = 64, 256  # that are kept: of robots, and places of a joint that is held


@dataclass(frozen=True, eq=False, repr=False)
class ClosedForm(OneLine):
    """The closed form of the inverse kinematics of a link.

    Attributes:
        family: Which axes are parallel and which intersect, counted from the base on, the held joint left out.
        from_end: Whether the axes are counted from the end on instead.
        held: The joint that is held, for arms of seven joints; None for fewer.
        n_joints: How many joints it moves; below six, joints are added that the task leaves free, or that are at rest.
        miss: By how much the axes miss the family: the largest angle [rad], or distance as a share of the arm's length.
        is_exact: Whether ``miss`` is at most 1e-12, so that the branches are all there are. Otherwise, up to 1e-3, they are
            starts of Newton steps, which may miss some, and prove nothing.
        slide: How far the longest slide may move [m].
        couplings: The joints that turn with another entry of q too; ``chain`` has none of them.
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
        """How many of the added joints are at rest: so many conditions must a pose satisfy to be reached."""
        return N_AXES - self.n_joints - self.n_free

    @property
    def geometry(self) -> str:
        """The family, with the joint that is held, the end from which the axes are counted, and how many joints were added."""
        seen = ", counted from the end" if self.from_end else ""
        if self.n_joints < N_AXES:
            seen += f", with {N_AXES - self.n_joints} of the joints added"
        held = f"with {self.held} held: " if self.held else ""
        return f"{held}{self.family}{seen}"

    def __str__(self) -> str:
        tier = "exact" if self.is_exact else "near"
        return f"{self.geometry}; {tier}, the axes miss it by {self.miss:.1g}"


def joints_at(form: ClosedForm, q: Array) -> SixJoints:
    """The form of the six joints, the others at q, shape (n_dof,)."""
    joints = _six_joints(form, None if form.held_column is None else float(q[form.held_column]), len(q))
    if joints is None:
        raise AssertionError("a family that holds at three places of the held joint does not hold at another")
    return joints


def closed_form_of(tree: Tree, link: str, held: str | None = None, task: Task = _POSE) -> ClosedForm | None:
    """The closed form of a link, or None. Of seven joints, the one is held for which the axes miss a family least.

    Args:
        tree: The robot.
        link: The link that is brought to a pose.
        held: The joint to hold, for arms of seven joints; the best unless given.
        task: Which part of the pose must be reached. The form is that of the task's frame.
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
        return _made(tree, chain, order, 0, column) if n_free == 0 else None
    if n_free is None:
        return None
    if len(order) <= N_AXES:
        form = _made(tree, chain, order, n_free, None)
        return None if form is None else replace(form, couplings=couplings)
    if len(order) != N_AXES + 1 or n_free:
        return None
    found = [form for column in _by_preference(order) if (form := _made(tree, chain, order, 0, column)) is not None]
    return next((form for form in found if form.is_exact), min(found, key=lambda form: form.miss, default=None))


def _by_preference(order: tuple[int, ...]) -> list[int]:
    """The joints at both ends first: the geometry of the others does not change with them."""
    return [order[k] for k in (6, 0, 2, 4, 1, 5, 3)]


def _made(tree: Tree, chain: Array, order: tuple[int, ...], n_free: int, held: int | None) -> ClosedForm | None:
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
    """Configurations at which a family has to hold."""
    if held is None:
        return [np.zeros(tree.n_dof)]
    low, high = held_range(tree, held)
    return [np.where(np.arange(tree.n_dof) == held, low + share * (high - low), 0.0) for share in _SHARES]


def held_range(tree: Tree, column: int) -> tuple[float, float]:
    """Where a held joint may be: its limits, no more than a turn; without limits half a turn to both sides."""
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
