"""Names the parts of the objective of a tick, and of its steady motion."""

from typing import NamedTuple

from numpy.typing import NDArray


class Objective(NamedTuple):
    """An objective and its parts."""

    h_rows: NDArray
    """n_dof n_dof numbers."""
    f_rows: NDArray
    jacobian_rows: NDArray
    """Jacobians of the hands, each times the square root of its weight. A hand has 6 n_dof numbers: joint by joint, six each."""
    desired_rows: NDArray
    """The twists of the hands, likewise; or the velocities of the joints."""
    system_rows: NDArray
    """Room for the damped system (``damped_system``)."""
    free_rows: NDArray
    """Jacobian of one hand, without the joints that are left out; 6 n_dof numbers."""
    pace_rows: NDArray
    """Share of its twist that is asked of each hand."""
    worth_rows: NDArray
    """Share to which each hand is followed along its line: 0 where the arm is stretched, and rests."""
    slowing_rows: NDArray
    """Reason why each hand is slowed: the joint whose acceleration limits it, or a negative code of ``pace``."""


class Program(NamedTuple):
    """Constraints of the quadratic program, and room to solve it."""

    box_rows: NDArray
    """Lower and then upper bounds of the velocities, 2 n_dof numbers."""
    normal_rows: NDArray
    """Gradients of the constraints, n_dof numbers a constraint."""
    bound_rows: NDArray
    """Their bounds."""
    active_rows: NDArray
    """The active constraints."""
    multiplier_rows: NDArray
    """Their multipliers."""
    work_rows: NDArray
    """Room for 2 n_dof (n_dof + 1) numbers."""


class Steady(NamedTuple):
    """Room for the steady motion."""

    h_rows: NDArray
    """H, and then its factor."""
    f_rows: NDArray
    jacobian_rows: NDArray
    """Derivative of each hand's Jacobian along the steady motion, in the order of ``Objective``."""
    x_rows: NDArray
    """The steady motion X."""
    part_rows: NDArray
    """Part of X that is due to the twist of one hand."""
    kept_rows: NDArray
    """y."""
    lost_rows: NDArray
    """z."""
    ahead_rows: NDArray
    """Configuration of the arm a little later; then room."""
    turn_rows: NDArray
    """Derivatives of the gradients of active constraints along the steady motion, n_dof numbers a constraint."""
    value_rows: NDArray
    """One value for each active constraint."""
    bound_rows: NDArray
    """Bounds of the constraints of the quadratic program."""
    active_rows: NDArray
    multiplier_rows: NDArray
