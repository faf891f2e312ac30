"""The short way for one target and no special wishes: everything but the target made ready once, one call of the kernel."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.ik.bounds import limit_bounds, seed_share, shares
from ulna.ik.problem import SEEDED_STEPS, STEPS, as_count, positive, refuse_immovable
from ulna.ik.result import IKResult
from ulna.kernels import search_layout as layout
from ulna.kernels.levenberg_marquardt import search_jobs
from ulna.model.arrays import as_floats
from ulna.model.tree import Tree

Array = NDArray[np.float64]
_STARTS = 64  # eight in each lane; a target that needs more goes the long way
_MATRIX = (4, 4)
LEAST_BUDGET = _STARTS * STEPS


class QuickSearch:
    """Searches for one pose of one link. ``solve`` may be called from many threads: nothing that it writes to is shared."""

    __slots__ = ("_fixed", "_from_seed", "_n", "_order", "_random", "_tolerances")

    def __init__(self, tree: Tree, link: str, home: Array, tolerances: tuple[float, float], seed: int) -> None:
        refuse_immovable(tree)
        self._n, self._tolerances = tree.n_dof, tolerances
        self._order = np.zeros(1, dtype=np.int64)
        bounds, home = limit_bounds(tree.bounds), home.copy()
        settings = np.zeros(layout.N_SETTINGS)
        settings[layout.POSITION_TOLERANCE] = positive("position_tolerance", tolerances[0])
        settings[layout.ROTATION_TOLERANCE] = positive("rotation_tolerance", tolerances[1])
        settings[layout.FIRST_WINS], settings[layout.STEPS] = 1.0, STEPS
        seeded = settings.copy()
        seeded[layout.STEPS] = SEEDED_STEPS
        random = np.vstack([seed_share(tree.n_dof), shares(tree.n_dof, as_count("seed", seed), 0, _STARTS - 1)])
        self._fixed = tree.chain(link), home.reshape(1, -1)
        self._random = bounds, random, home, settings
        self._from_seed = bounds, seed_share(tree.n_dof), home, seeded

    def solve(self, T: ArrayLike, q_seed: ArrayLike | None = None) -> IKResult | None:
        """The result if it is a solution; None if this is not one target, or one that needs a longer search or is none."""
        T = as_floats("T", T)
        if T.shape != _MATRIX:
            return None
        chain, seeds = self._fixed
        how = self._random
        if q_seed is not None:
            q_seed = as_floats("q_seed", q_seed)
            if q_seed.shape != (self._n,):
                return None
            seeds, how = q_seed.reshape(1, -1), self._from_seed
        q, info = np.empty((1, self._n)), np.empty((1, layout.N_INFO))
        search_jobs(chain, T.reshape(1, 4, 4), self._order, seeds, *how, q, info)
        if info[0, layout.STATUS] != layout.SOLVED:
            return None
        return IKResult(q[0], info, (), self._tolerances)
