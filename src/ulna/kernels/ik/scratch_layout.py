"""Sizes of the scratch arrays of inverse kinematics. Used by its kernels and drivers, and by ``ik.differential``."""

N_SYSTEM = 27  # rows: the lower triangle of a 6x6 matrix, then a vector of six
N_TURNED = 42  # rows: six of the error, then the six columns of a 6x6 matrix


def work_size(n_dof):
    """How many numbers ``differential_ik.differential_one`` needs to work on."""
    return 16 * n_dof + N_SYSTEM + N_TURNED
