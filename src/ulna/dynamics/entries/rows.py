"""Allocates the scratch memory, called workspaces, of the compiled functions for dynamics.

A compiled function that Python calls is an *entry* (``engine.entries``). Each function here returns the arrays that an entry
passes to its kernels (``kernels.dynamics.dynamics_records``).
"""

from ulna.engine.decorators import workspace
from ulna.engine.lanes import empty_rows
from ulna.engine.signatures import NUMBERS, TABLE, Group
from ulna.kernels.dynamics.dynamics_records import MOTION_WIDTH, BodyRows, FallRows, ForceRows, Mechanism, RateRows
from ulna.kernels.layout import INERTIA_WIDTH

MECHANISM = Group((TABLE, TABLE), of=Mechanism)
FORCE_ROWS = Group((NUMBERS, NUMBERS, NUMBERS), of=ForceRows)


@workspace
def force_rows(n):
    """Allocate ``ForceRows`` for n joints."""
    return ForceRows(empty_rows(MOTION_WIDTH * (n + 1)), empty_rows(12 * n), empty_rows(6 * n))


@workspace
def fall_rows(n):
    """Allocate ``FallRows`` for n joints."""
    return FallRows(empty_rows(12 * n), empty_rows(3 * (n + 1)), empty_rows(3 * n), empty_rows(n))


@workspace
def body_rows(n):
    """Allocate ``BodyRows`` for n joints."""
    return BodyRows(empty_rows(12 * n), empty_rows(6 * n), empty_rows(INERTIA_WIDTH * n))


@workspace
def rate_rows(n):
    """Allocate ``RateRows`` for n joints."""
    size = 6 * n
    return RateRows(
        empty_rows(size),
        empty_rows(size),
        empty_rows(size),
        empty_rows(size),
        empty_rows(size),
        empty_rows(size),
        empty_rows(size),
    )
