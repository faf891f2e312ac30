"""Computes all branches of targets by the closed form of six joints, the others at one place.

Of an arm of fewer joints some are added (``added_joints``).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import closed_form
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.added_joints import of_six
from ulna.ik.closed_form.axes import N_AXES, axes_of
from ulna.ik.closed_form.families import EXACT, Family, family_of
from ulna.ik.closed_form.table import table_of
from ulna.ik.turns import TURN
from ulna.kernels.chain import closed_form_layout as layout
from ulna.kernels.layout import COLUMN, FIXED, KIND, PRISMATIC

Array = NDArray[np.float64]
Found = tuple[Array, NDArray[Any], NDArray[Any]]
Workers = int | None | Callable[["SixJoints", Array, Array, Array], Found]
"""How many threads to use at most; or what computes the branches in their place: of a form, targets, seeds and a plan."""
_LEAST_TARGETS = 512  # of a part
_NO_BOUNDS = np.zeros(2)
_MORE_THAN_ANY = 1e12  # m: what a whole turn of a joint that slides would add


@dataclass(frozen=True, eq=False)
class SixJoints:
    """A closed form of six joints, the others at one place.

    Attributes:
        table: That of the kernels.
        chain: The chain of the six joints.
        own: That of the arm's own joints, the first of them.
        columns: The entries of q that the arm's own joints are, shape (n,).
        n_free: How many of the added joints are free; the others are at rest.
        family: To which it belongs.
    """

    table: Array
    chain: Array
    own: Array
    columns: NDArray[np.int64]
    n_free: int
    family: Family

    @property
    def slides(self) -> NDArray[np.bool_]:
        """Which of the arm's own joints slide, shape (n,)."""
        return self.own[:-1, KIND] == PRISMATIC

    @property
    def is_exact(self) -> bool:
        """Whether the branches are all there are."""
        return self.family.miss <= EXACT

    @cached_property
    def without_rest(self) -> Array:
        """The chain of the arm's own joints and the free ones; those at rest are part of the links."""
        chain, n_own, n_rest = self.chain.copy(), len(self.columns), N_AXES - len(self.columns) - self.n_free
        moving, entry_of = chain[:, KIND] != FIXED, chain[:, COLUMN]
        at_rest = moving & (entry_of >= n_own) & (entry_of < n_own + n_rest)
        chain[moving & (entry_of >= n_own + n_rest), COLUMN] -= n_rest
        chain[at_rest, KIND] = FIXED
        chain.setflags(write=False)
        return chain

    def plan(self, lower: Array, upper: Array, tolerances: tuple[float, float] = (0.0, 0.0)) -> Array:
        """What the kernels take as the bounds of all entries of q, shapes (n_dof,) (``drivers.closed_form``)."""
        turns = np.where(self.slides, _MORE_THAN_ANY, TURN)
        return np.concatenate([tolerances, lower[self.columns], upper[self.columns], turns, 1.0 / turns])

    def branches(self, targets: Array, seeds: Array, workers: Workers = None, plan: Array = _NO_BOUNDS) -> Found:
        """All branches of targets (n, 4, 4), which are rigid motions: q (n, 8, 6), known (n, 8) and proof (n,).

        ``known`` is the sum of what is known of a branch, and ``proof`` what they prove (``closed_form_layout``). Joints that may
        have any angle get that of seeds (n or 1, 6). The entries of q are the arm's own joints from the base on, then the added
        ones. With the bounds of a plan branches are turned towards the seeds within them, and NaN where they are not real.
        """
        if callable(workers):
            return workers(self, targets, seeds, plan)
        n = len(targets)
        q, known, proof = np.empty((n, layout.N_BRANCHES, N_AXES)), np.empty((n, layout.N_BRANCHES)), np.empty(n)

        def run(part: slice) -> bool:
            own = seeds[part] if len(seeds) > 1 else seeds
            return closed_form.all_branches(self.table, self.chain, plan, targets[part], own, q[part], known[part], proof[part])

        in_parts(run, n, _LEAST_TARGETS, workers)
        return q, known, proof


def six_joints(chain: Array, columns: tuple[int, ...], q: Array, n_free: int = 0) -> SixJoints | None:
    """The closed form of the joints that some entries of q move, all others held at q (n_dof,).

    n_free: How many turns at the end are free (``added_joints.free_turns``).
    """
    own = axes_of(chain, columns, q)
    found = []
    if own is None:
        return None
    for axes in of_six(own, n_free):
        family = family_of(axes.directions, axes.points, axes.slides, axes.unit)
        if family is not None:
            found.append(SixJoints(table_of(axes, family, n_free), axes.chain, own.chain, np.array(columns), n_free, family))
    return next((six for six in found if six.is_exact), min(found, key=lambda six: six.family.miss, default=None))
