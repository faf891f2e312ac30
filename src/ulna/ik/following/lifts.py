"""Numbers the whole turns within limits, and measures steps up to whole turns.

A solution is stored once: each joint that can make whole turns is in the first turn from its lower limit. A *lift* adds turns.
The shortest step between two solutions adds the same whole turns to every lift of the first: it shifts the lifts. So one search
of the graph covers all lifts. If the limits are whole turns apart, a joint at one limit may be at the other: such a solution is
stored twice.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.chain.closed_form_layout import AT_LIMIT
from ulna.kinematics.turns import TURN

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
_MAX_LIFTS, _MIN_TURNS = 3**6, 3  # above the first bound, each joint with wide limits gets at most the second
_MAX_SHIFTS = 300_000  # shifts of the lifts by any number of turns, times lifts


@dataclass(frozen=True, eq=False)
class Lifts:
    """The whole turns of a robot.

    Attributes:
        lower: The begin of the first turn of each entry, shape (n_dof,).
        upper: The upper limits, shape (n_dof,).
        lifted: Mask of the entries that can make whole turns between two limits, shape (n_dof,).
        free: Mask of the entries that can make any number of turns, shape (n_dof,).
        closed: Mask of the lifted entries whose limits are whole turns apart, shape (n_dof,).
        table: The turns of each lift, shape (n_lifts, n_dof).
        cut: Mask of the entries whose limits allow more turns than the table, shape (n_dof,).
    """

    lower: Array
    upper: Array
    lifted: NDArray[np.bool_]
    free: NDArray[np.bool_]
    closed: NDArray[np.bool_]
    table: Counts
    cut: NDArray[np.bool_]
    _known: dict[int, Counts] = field(default_factory=dict, repr=False)

    @classmethod
    def make(cls, lower: Array, upper: Array, turning: NDArray[np.bool_], start: Array, *, one_sided: bool) -> Lifts:
        """The lifts of joints with these limits.

        Args:
            lower: The lower limits, shape (n_dof,).
            upper: The upper limits.
            turning: Mask of the entries that can make whole turns.
            start: If there are too many turns, the table has those about these positions, shape (n_dof,).
            one_sided: Whether joints with one finite limit are lifted; otherwise they are free, as if unlimited.
        """
        finite = np.isfinite(lower).astype(int) + np.isfinite(upper)
        free = turning & (finite < (1 if one_sided else 2))
        with np.errstate(invalid="ignore"):
            lifted = turning & ~free & (upper - lower >= TURN - AT_LIMIT)
            counts = np.where(lifted, np.ceil((upper - lower - AT_LIMIT) / TURN), 1.0)
            searched = _n_searched(counts)
            first_turns = np.minimum(start - TURN * searched / 2, upper - TURN * searched)
            first_limits = np.where(counts > searched, np.maximum(lower, first_turns), lower)
            is_whole = np.abs(upper - first_limits - TURN * np.rint((upper - first_limits) / TURN)) <= AT_LIMIT
        table = np.array(list(product(*map(range, searched))), dtype=np.int64)
        return cls(first_limits, upper, lifted, free, lifted & is_whole, table.reshape(-1, len(lower)), counts > searched)

    def first_turn(self, q: Array) -> Array:
        """q (..., n_dof) with each lifted entry in its first turn."""
        with np.errstate(invalid="ignore"):
            turned = np.mod(q - self.lower + AT_LIMIT, TURN) - AT_LIMIT
        return np.where(self.lifted, self.lower + np.maximum(turned, 0.0), q)

    def at_both_limits(self, q: Array) -> Array:
        """Rows of q (m, n_dof) in their first turn; those at a limit also at the other, shape (k, n_dof)."""
        upper_in_first_turn = self.upper - TURN * (self.counts - 1)  # the upper limit, in the first turn
        for j in np.flatnonzero(self.closed):
            copies = q[q[:, j] <= self.lower[j] + AT_LIMIT]
            copies[:, j] = np.minimum(copies[:, j] + TURN, upper_in_first_turn[j])
            q = np.vstack([q, copies])
        return q

    def allowed(self, q: Array) -> NDArray[np.bool_]:
        """Mask of the lifts of q (m, n_dof), in its first turn, within the limits, shape (m, n_lifts)."""
        max_turns = np.where(self.lifted, np.floor((self.upper + AT_LIMIT - q) / TURN), np.inf)
        return np.all(self.table <= max_turns[:, None], axis=-1)

    def apply(self, q: Array, lift: int) -> Array:
        """q (n_dof,) with the turns of a lift."""
        raised = q + TURN * self.table[lift]
        return np.where(self.lifted, np.minimum(raised, self.upper), q)

    def steps(self, a: Array, b: Array) -> tuple[Array, Counts]:
        """b - a by entry, up to whole turns, and the turns added to b; shapes (..., n_dof)."""
        difference = b - a
        turns = np.where(self.lifted | self.free, -np.rint(difference / TURN), 0.0)
        return difference + TURN * turns, turns.astype(np.int64)

    def nearest(self, q: Array, goal: Array) -> Array:
        """q (..., n_dof) with the turns within the limits that bring it nearest to a goal (n_dof,)."""
        nearest = q - TURN * np.rint((q - goal) / TURN)
        inside = (nearest >= self.lower - AT_LIMIT) & (nearest <= self.upper + AT_LIMIT)
        return np.where(self.free | (self.lifted & inside), nearest, q)

    def unwrapped(self, q: Array) -> Array:
        """A path (n, n_dof) with turns added to free entries so that no step exceeds half a turn."""
        whole = np.unwrap(q, axis=0) if len(q) else q
        return np.where(self.free, whole, q)

    def code(self, turns: Counts) -> Counts:
        """A number for the shift of the lifts by turns (m, n_dof), shape (m,)."""
        return np.where(self.lifted, turns + self.counts, 0) @ self._places

    def sources(self, code: int) -> Counts:
        """The lift that each lift comes from under the shift of a code, or -1, shape (n_lifts,)."""
        if code not in self._known:
            turns = np.where(self.lifted, code // self._places % (2 * self.counts + 1) - self.counts, 0)
            source = self.table - turns
            inside = np.all((source >= 0) & (source < self.counts), axis=1)
            place = np.ravel_multi_index(tuple(np.where(inside[:, None], source, 0).T), tuple(self.counts))
            self._known[code] = np.where(inside, place, -1)
        return self._known[code]

    def omits(self, longest: float) -> bool:
        """Whether steps of a whole turn and more, up to ``longest``, are left out because there are too many."""
        return longest >= TURN and int(np.prod((2 * self.counts - 1) * self.counts)) > _MAX_SHIFTS

    @cached_property
    def counts(self) -> Counts:
        """The number of turns of each entry in the table, shape (n_dof,)."""
        return np.max(self.table, axis=0) + 1

    @cached_property
    def _places(self) -> Counts:
        """The weight of each entry's turns in a code."""
        bases = np.where(self.lifted, 2 * self.counts + 1, 1)
        return np.cumprod(np.r_[1, bases[:-1]])


def _n_searched(counts: Array) -> Counts:
    """The number of turns of each entry to search: all, within bounds for unlimited joints and for all lifts."""
    searched = np.where(np.isfinite(counts), np.minimum(counts, _MAX_LIFTS), _MIN_TURNS).astype(np.int64)
    while float(np.prod(searched, dtype=np.float64)) > _MAX_LIFTS and searched.max() > _MIN_TURNS:
        searched[searched.argmax()] -= 1
    return searched
