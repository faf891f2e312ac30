"""The short way for one target and no special wishes: everything but the target made ready once, one call of the kernel."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.drivers import entry
from ulna.ik.bounds import limit_bounds
from ulna.ik.lengths import far_square
from ulna.ik.problem import SEEDED_STEPS, STEPS, as_count, positive, refuse_immovable
from ulna.ik.result import IKResult
from ulna.ik.unit_samples import seed_sample, unit_samples
from ulna.ik.units import unit_of
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
_STARTS = 64  # eight in each lane; a target that needs more goes the long way
_MATRIX = (4, 4)
LEAST_BUDGET = _STARTS * STEPS
SingleTargetKey = tuple[str | None, float, float, int]  # link, tolerances [m, rad], seed


class SingleTarget:
    """Searches for one pose of one link. ``solve`` may be called from many threads: nothing that it writes to is shared."""

    __slots__ = ("_chain", "_fits", "_from_home", "_from_seed", "_home", "_n", "_search_one", "_tolerances")

    def __init__(self, tree: Tree, link: str, home: Array, tolerances: tuple[float, float], seed: int) -> None:
        refuse_immovable(tree)
        self._search_one = entry("multi_start.search_one")
        self._chain, self._n, self._tolerances = tree.chain(link), tree.n_dof, tolerances
        settings = np.zeros(layout.N_SETTINGS)
        settings[layout.POSITION_TOLERANCE] = positive("position_tolerance", tolerances[0])
        settings[layout.ROTATION_TOLERANCE] = positive("rotation_tolerance", tolerances[1])
        settings[layout.FIRST_WINS], settings[layout.STEPS], settings[layout.FAR] = 1.0, STEPS, far_square(tree, link)
        bounds, from_seed = limit_bounds(tree.bounds), seed_sample(tree.n_dof)
        random = unit_samples(tree, link, as_count("seed", seed), 0, _STARTS - 1)
        self._fits = unit_of(tree, link) == 1.0
        self._home = home.copy()
        self._from_home = np.concatenate([settings, bounds.ravel(), home, from_seed.ravel(), random.ravel()])
        settings[layout.STEPS] = SEEDED_STEPS
        self._from_seed = np.concatenate([settings, bounds.ravel(), home, from_seed.ravel()])

    def solve(self, T: ArrayLike, q_seed: ArrayLike | None = None) -> IKResult | None:
        """The result if it is a solution; None if this is not one target, or one that needs a longer search or is none."""
        T = as_floats("T", T)
        if T.shape != _MATRIX or not self._fits:
            return None
        start, plan = self._home, self._from_home
        if q_seed is not None:
            start, plan = as_floats("q_seed", q_seed), self._from_seed
            if start.shape != (self._n,):
                return None
        q, info = np.empty((1, self._n)), np.empty((1, layout.N_INFO))
        self._search_one(self._chain, plan, T, start, q, info)
        if info[0, layout.STATUS] != layout.SOLVED:
            return None
        return IKResult(q[0], info, (), self._tolerances)
