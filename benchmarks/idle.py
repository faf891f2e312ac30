"""Defines entries that take the arguments of a pose and of a Jacobian and do nothing."""

from ulna.engine.decorators import low_latency_entry
from ulna.engine.signatures import MATRIX, NUMBERS, WHOLE


@low_latency_entry((MATRIX, WHOLE, NUMBERS, MATRIX))
def idle_forward(chain, n_dof, q, out):  # noqa: ARG001 -- only the cost of passing them matters
    """Take the arguments of ``forward_one``, and do nothing."""
    return True


@low_latency_entry((MATRIX, WHOLE, WHOLE, NUMBERS, MATRIX))
def idle_jacobian(chain, expressed_in, n_dof, q, out):  # noqa: ARG001 -- only the cost of passing them matters
    """Take the arguments of ``jacobian_one``, and do nothing."""
    return True
