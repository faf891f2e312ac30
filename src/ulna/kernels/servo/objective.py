"""Defines the arrays of a tick's quadratic program and of its steady motion.

The *steady motion* is the joint velocities that follow the twists of all hands in full, without limits of velocity and
acceleration (``pace``).
"""

from typing import NamedTuple

from numpy.typing import NDArray


class Objective(NamedTuple):
    """Objective of the quadratic program, and its parts."""

    h_rows: NDArray
    """n_dof n_dof numbers."""
    f_rows: NDArray
    jacobian_rows: NDArray
    """Jacobians of the hands, each times the square root of its weight. A hand has 6 n_dof numbers: joint by joint, six each."""
    desired_rows: NDArray
    """The twists of the hands, likewise; or the velocities of the joints."""
    system_rows: NDArray
    """Scratch for the damped system (``damped_system``)."""
    free_rows: NDArray
    """Jacobian of one hand, without the joints that are left out; 6 n_dof numbers."""
    pace_rows: NDArray
    """Pace of each hand: the share of its twist that is asked of it."""
    progress_rows: NDArray
    """Share, 0 to 1, to which each hand is moved along its line: 0 where the arm is stretched and rests."""
    slowing_rows: NDArray
    """Reason why each hand is slowed: the joint whose acceleration limits it, or a negative code of ``pace``."""


class Program(NamedTuple):
    """Constraints of the quadratic program, and scratch to solve it."""

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
    """Scratch for 2 n_dof (n_dof + 1) numbers."""


class Steady(NamedTuple):
    """Scratch for the steady motion (``pace``)."""

    h_rows: NDArray
    """H, and then its factor."""
    f_rows: NDArray
    jacobian_rows: NDArray
    """Derivative of each hand's Jacobian along the steady motion, in the order of ``Objective``."""
    x_rows: NDArray
    """Steady motion X."""
    part_rows: NDArray
    """Part of X that the twist of one hand causes."""
    growth_rows: NDArray
    """y of ``pace``."""
    damping_rows: NDArray
    """z of ``pace``."""
    ahead_rows: NDArray
    """Configuration of the arm a little later; scratch afterwards."""
    turn_rows: NDArray
    """Derivatives of the gradients of active constraints along the steady motion, n_dof numbers a constraint."""
    value_rows: NDArray
    """One value for each active constraint."""
    bound_rows: NDArray
    """Bounds of the constraints of the quadratic program."""
    active_rows: NDArray
    multiplier_rows: NDArray
