"""Entries that take the arguments of a pose and of a Jacobian and do nothing."""

from ulna.engine.decorators import low_latency_entry
from ulna.engine.signatures import MATRIX, NUMBERS, WHOLE


@low_latency_entry((MATRIX, WHOLE, NUMBERS, MATRIX))
def idle_forward(chain, n_dof, q, out):  # noqa: ARG001 -- only the cost of passing them is of interest
    """As ``forward_one``, with nothing to do."""
    return True


@low_latency_entry((MATRIX, WHOLE, WHOLE, NUMBERS, MATRIX))
def idle_jacobian(chain, expressed_in, n_dof, q, out):  # noqa: ARG001 -- only the cost of passing them is of interest
    """As ``jacobian_one``, with nothing to do."""
    return True
