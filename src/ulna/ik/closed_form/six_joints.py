"""Computes all branches of targets by the closed form of six joints, the others at one place. Used by ``closed_form``."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import entry
from ulna.engine.threads import in_parts
from ulna.ik.closed_form.axes import N_AXES, axes_of
from ulna.ik.closed_form.families import EXACT, Family, family_of
from ulna.ik.closed_form.table import table_of
from ulna.kernels.chain import closed_form_layout as layout

Array = NDArray[np.float64]
_LEAST_TARGETS = 512  # of a part


@dataclass(frozen=True, eq=False)
class SixJoints:
    """A closed form of six joints, the others at one place.

    Attributes:
        table: That of the kernels.
        chain: The chain of the six joints.
        columns: The entries of q that they are, shape (6,).
        family: To which it belongs.
    """

    table: Array
    chain: Array
    columns: NDArray[np.int64]
    family: Family

    @property
    def is_exact(self) -> bool:
        """Whether the branches are all there are."""
        return self.family.miss <= EXACT

    def branches(self, targets: Array, seeds: Array, threads: int | None = None) -> tuple[Array, Array]:
        """All branches of targets (n, 4, 4), which are rigid motions, whatever the limits: q (n, 8, 6) and known (n, 8).

        ``known`` is the sum of what is known of a branch (``closed_form_layout``). Joints that may have any
        angle get that of seeds (n or 1, 6).
        """
        n = len(targets)
        q, known = np.empty((n, layout.N_BRANCHES, N_AXES)), np.empty((n, layout.N_BRANCHES))
        all_branches, most, steps = entry("closed_form.all_branches"), *((1e-3, 4) if self.is_exact else (0.3, 8))

        def run(part: slice) -> bool:
            own = seeds[part] if len(seeds) > 1 else seeds
            return all_branches(self.table, self.chain, targets[part], own, most, steps, q[part], known[part])

        in_parts(run, n, _LEAST_TARGETS, threads)
        return q, known


def six_joints(chain: Array, columns: tuple[int, ...], q: Array) -> SixJoints | None:
    """The closed form of the joints that six entries of q turn, all others held at q (n_dof,)."""
    axes = axes_of(chain, columns, q)
    family = None if axes is None else family_of(axes.directions, axes.points, axes.reach)
    if axes is None or family is None:
        return None
    return SixJoints(table_of(axes, family), axes.chain, np.array(columns), family)
