"""Names what the objective of a tick and its steady motion are made of."""

from typing import NamedTuple

from numpy.typing import NDArray


class Objective(NamedTuple):
    """An objective, and what it is made of."""

    h_rows: NDArray
    """n_dof n_dof numbers."""
    f_rows: NDArray
    jacobian_rows: NDArray
    """Of the hands, each times the square root of its weight, 6 n_dof numbers a hand: six of a joint after the other."""
    desired_rows: NDArray
    """The twists of the hands, likewise; or the velocities of the joints."""
    system_rows: NDArray
    """Room for the damped system (``damped_system``)."""
    pace_rows: NDArray
    """Which share of its twist is asked of each hand."""
    slowing_rows: NDArray
    """What slows each hand: the joint whose acceleration does, or a negative number of ``pace``."""


class Steady(NamedTuple):
    """Room for the steady motion."""

    h_rows: NDArray
    """H, and then its factor."""
    f_rows: NDArray
    jacobian_rows: NDArray
    """How J of each hand changes along the steady motion, as those of ``Objective``."""
    x_rows: NDArray
    """The steady motion X."""
    part_rows: NDArray
    """What of it is due to the twist of one hand."""
    kept_rows: NDArray
    """y."""
    lost_rows: NDArray
    """z."""
    ahead_rows: NDArray
    """Where the arm is a little ahead; then room."""
    turn_rows: NDArray
    """How the gradients of active rows change along the steady motion, n_dof numbers a row."""
    value_rows: NDArray
    """For each active row one."""
    bound_rows: NDArray
    """Of the rows of the quadratic program."""
    active_rows: NDArray
    multiplier_rows: NDArray
