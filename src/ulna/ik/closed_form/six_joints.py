"""Computes all branches of targets by the closed form of six joints, with other joints fixed.

For an arm of fewer joints, ``added_joints`` adds some.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.added_joints import six_joint_arms
from ulna.ik.closed_form.axes import N_AXES, Axes, axes_of, frame_along
from ulna.ik.closed_form.families import EXACT, Family, family_of
from ulna.ik.entries import closed_form
from ulna.ik.solutions import PROOFS, Proof
from ulna.kernels.chain import closed_form_layout as layout
from ulna.kernels.layout import COLUMN, FIXED, KIND, PRISMATIC
from ulna.kinematics.turns import TURN

Array = NDArray[np.float64]
Found = tuple[Array, NDArray[Any], NDArray[Any]]
Workers = Callable[["SixJoints", Array, Array, Array], Found] | None
"""Computes branches in place of threads of this process, if given: from a form, targets, seeds and a plan."""
_MIN_TARGETS = 512  # of a part
_NO_BOUNDS = np.zeros(2)
_MORE_THAN_ANY = 1e12  # m: what a whole turn of a joint that slides would add
_NEAR_ERROR = 1e-9  # more than is allowed, so that every branch of a near form takes a step
_NOTHING = 1e-28  # of a bend, which the rounding of right angles leaves


@dataclass(frozen=True, eq=False)
class SixJoints:
    """A closed form of six joints, with other joints fixed.

    Attributes:
        table: The table of the kernels.
        chain: The chain of the six joints.
        own: The chain of the arm's own joints, which come first.
        columns: The entries of q of the arm's own joints, shape (n,).
        n_free: The number of free added joints; the other added joints are at rest.
        family: The family.
    """

    table: Array
    chain: Array
    own: Array
    columns: NDArray[np.int64]
    n_free: int
    family: Family

    @cached_property
    def slides(self) -> NDArray[np.bool_]:
        """Mask of the prismatic joints among the arm's own joints, shape (n,)."""
        return self.own[:-1, KIND] == PRISMATIC

    def entries_of(self, q: Array) -> Array:
        """The six joints in configurations q (..., n_dof), shape (..., 6); added joints are at 0."""
        entries = np.zeros((*q.shape[:-1], N_AXES))
        entries[..., : len(self.columns)] = q[..., self.columns]
        return entries

    @property
    def is_exact(self) -> bool:
        """Whether the branches are all solutions."""
        return self.family.miss <= EXACT

    @cached_property
    def without_rest(self) -> Array:
        """The chain of the arm's own joints and the free ones; joints at rest become part of the links."""
        chain, n_own, n_rest = self.chain.copy(), len(self.columns), N_AXES - len(self.columns) - self.n_free
        moving, entry_of = chain[:, KIND] != FIXED, chain[:, COLUMN]
        at_rest = moving & (entry_of >= n_own) & (entry_of < n_own + n_rest)
        chain[moving & (entry_of >= n_own + n_rest), COLUMN] -= n_rest
        chain[at_rest, KIND] = FIXED
        chain.setflags(write=False)
        return chain

    def plan(self, lower: Array, upper: Array, tolerances: tuple[float, float] = (0.0, 0.0)) -> Array:
        """The kernels' bounds and units of the joints (``ik.entries.closed_form``), from bounds of q, shapes (n_dof,)."""
        turns = np.where(self.slides, _MORE_THAN_ANY, TURN)
        units = np.where(self.slides, 1.0 / self.table[layout.FORM, layout.INVERSE_REACH], 1.0)
        return np.concatenate([tolerances, lower[self.columns], upper[self.columns], turns, 1.0 / turns, units])

    def branches(self, targets: Array, seeds: Array, workers: Workers = None, plan: Array = _NO_BOUNDS) -> Found:
        """All branches of rigid motions (n, 4, 4): q (n, 8, 6), known (n, 8) and proof (n,).

        ``known`` is the sum of a branch's flags, and ``proof`` follows from the flags (``closed_form_layout``). Undetermined
        joints get their values from seeds (n or 1, 6). The entries of q are the arm's own joints from the base on, then the added
        ones. With the bounds of a plan, whole turns bring branches towards the seeds within the bounds, and branches that are not
        real are NaN.
        """
        if workers is not None:
            return workers(self, targets, seeds, plan)
        n = len(targets)
        q, known, proof = np.empty((n, layout.N_BRANCHES, N_AXES)), np.empty((n, layout.N_BRANCHES)), np.empty(n)
        all_branches = closed_form.all_branches

        def run(part: slice) -> bool:
            own = seeds[part] if len(seeds) > 1 else seeds
            return all_branches(self.table, self.chain, plan, targets[part], own, q[part], known[part], proof[part])

        in_parts(run, n, _MIN_TARGETS)
        return q, known, proof


def six_joints(chain: Array, columns: tuple[int, ...], q: Array, n_free: int, slide: float) -> SixJoints | None:
    """The closed form of the joints that some entries of q move, with all others held at q (n_dof,).

    slide: The longest stroke of the prismatic joints [m]. n_free: The number of free rotations at the end
    (``added_joints.free_turns``).
    """
    own = axes_of(chain, columns, q, slide)
    found = []
    if own is None:
        return None
    for axes in six_joint_arms(own, n_free):
        family = family_of(axes.directions, axes.points, axes.slides, axes.unit)
        if family is not None:
            found.append(SixJoints(table_of(axes, family, n_free), axes.chain, own.chain, np.array(columns), n_free, family))
    return next((six for six in found if six.is_exact), min(found, key=lambda six: six.family.miss, default=None))


def table_of(axes: Axes, family: Family, n_free: int) -> Array:
    """The table of the kernels (``closed_form_layout``), shape (N_ROWS, 3), read-only; the last ``n_free`` joints are free."""
    table = np.zeros((layout.N_ROWS, 3))
    h, reach = family.directions, axes.unit
    c, T_end_0 = family.points / reach, inverse(axes.end)
    table[layout.AXES : layout.AXES + 6] = h
    table[layout.POINTS], table[layout.POINTS + 1 : layout.POINTS + 6], table[layout.LAST] = c[0], np.diff(c, axis=0), c[5]
    table[layout.FRAME : layout.FRAME + 3], table[layout.FRAME + 3] = T_end_0[:3, :3].T, T_end_0[:3, 3] / reach
    frames = {row: frame_along(h[j]) for row, j in ((layout.OF_2, 1), (layout.OF_4, 3), (layout.OF_6, 5))}
    for row, frame in frames.items():
        table[layout.NORMALS + row : layout.NORMALS + row + 2] = frame[:, :2].T
    table[layout.FIFTH : layout.FIFTH + 9] = _turns(frames[family.rule.before], h[4], frames[layout.OF_6])
    table[layout.BENDS, :2] = _bends(h[family.rule.bend], h[4], h[5])
    table[layout.BENDS, layout.FREE_WRIST] = n_free == 3 and not family.from_end
    table[layout.FORM] = family.number, family.from_end, 1.0 / reach
    order, slides = (axes.entries[::-1], axes.slides[::-1]) if family.from_end else (axes.entries, axes.slides)
    table[layout.COLUMNS : layout.COLUMNS + 2] = order.reshape(2, 3)
    table[layout.SIGNS : layout.SIGNS + 2] = np.where(slides, family.signs * reach, family.signs).reshape(2, 3)
    table[layout.POLISH] = (0.0, 1e-3, 4) if family.miss <= EXACT else (_NEAR_ERROR, 0.3, 8)
    table.setflags(write=False)
    return table


def _turns(F_before: Array, h: Array, F_behind: Array) -> Array:
    """The nine rows of K, C and S, by Rodrigues' formula.

    K + C cos(angle) + S sin(angle) = before' rot(h, angle) behind.
    """
    outer = np.outer(h, h)
    crossed: Array = np.cross(h, F_behind, axisb=0, axisc=0).astype(np.float64)
    return np.vstack([F_before.T @ outer @ F_behind, F_before.T @ (np.eye(3) - outer) @ F_behind, F_before.T @ crossed])


def _bends(h: Array, k: Array, p: Array) -> tuple[float, float]:
    """1 - cos(a - b) and 1 + cos(a + b), accurate near 0.

    a and b are the angles of k to h and to p.
    """
    a, b = (float(np.arctan2(np.linalg.norm(np.cross(k, v)), k @ v)) for v in (h, p))
    one_minus, one_plus = 2.0 * np.sin((a - b) / 2.0) ** 2, 2.0 * np.cos((a + b) / 2.0) ** 2
    return 0.0 if one_minus < _NOTHING else float(one_minus), 0.0 if one_plus < _NOTHING else float(one_plus)


def proofs_of(known: NDArray[np.int8], real: NDArray[np.bool_], n_at_rest: int = 0) -> NDArray[np.int64]:
    """The proofs of targets as indices into ``PROOFS``, from the flags of their branches (n, 8), shape (n,).

    If an unsolved branch has an undetermined angle, another value may solve it, so nothing is proved. The same holds if added
    joints must be at rest, since another value may bring them there.
    """
    free = (known & layout.IS_HARDLY_DETERMINED) > 0
    coinciding = ((known & layout.IS_COINCIDING) > 0) & real
    rules = [(free & real).any(axis=1) & (n_at_rest == 0), free.any(axis=1), coinciding.any(axis=1)]
    results = [PROOFS.index(proof) for proof in (Proof.CONTINUUM, Proof.SEARCHED, Proof.COINCIDING)]
    return np.select(rules, results, PROOFS.index(Proof.COMPLETE))
