"""Selects the solutions of one target within the limits and clear of the world."""


def valid_solutions(robot, T, **named):
    """Those of ``all_solutions`` of one target within the limits, and clear of the world if one is given: (n, n_dof)."""
    found = robot.all_solutions(T, **named)
    return found.q[found.valid]
