"""Computes the bounds of the joint velocities of one control step.

The bounds of entry j are the velocity limits, and what reaches the position limit at the end of the step: (limit - q) / dt. An
entry beyond a limit returns at no more than its velocity limit.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, store
from ulna.kernels.spatial.elementary import maximum, minimum


@kernel
def velocity_bounds(limits, velocity_limits, dt, q_rows, bound_rows):
    """Write the lower and then the upper bounds of the joint velocities."""
    n_dof = velocity_limits.shape[0]
    for j in range(n_dof):
        q = load(q_rows, j)
        fast = splat(velocity_limits[j], q)
        store(bound_rows, j, minimum(maximum((limits[0, j] - q) / dt, -fast), fast))
        store(bound_rows, n_dof + j, minimum(maximum((limits[1, j] - q) / dt, -fast), fast))
