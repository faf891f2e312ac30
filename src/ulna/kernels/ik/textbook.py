"""Takes the step of a textbook method by its number, and measures steps and errors."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store
from ulna.kernels.ik.damped_least_squares import damped_step
from ulna.kernels.ik.damped_system import error_squares, pose_error
from ulna.kernels.ik.jacobian_transpose import transpose_step
from ulna.kernels.ik.pseudo_inverse import pseudo_inverse_step
from ulna.kernels.ik.search_layout import DAMPED_LEAST_SQUARES, JACOBIAN_TRANSPOSE, TASK, WHOLE_POSE
from ulna.kernels.ik.task import task_error
from ulna.kernels.spatial.elementary import maximum


@kernel
def take_step(method, jacobian_rows, n_dof, e, system_rows, error_rows, step_rows):
    """Write the step of the method, shape (n_dof,)."""
    if method == JACOBIAN_TRANSPOSE:
        transpose_step(jacobian_rows, n_dof, e, step_rows)
    elif method == DAMPED_LEAST_SQUARES:
        damped_step(jacobian_rows, n_dof, e, system_rows, step_rows)
    else:
        store(error_rows, 0, e[0])
        store(error_rows, 1, e[1])
        store(error_rows, 2, e[2])
        store(error_rows, 3, e[3])
        store(error_rows, 4, e[4])
        store(error_rows, 5, e[5])
        pseudo_inverse_step(jacobian_rows, n_dof, error_rows, step_rows)


@kernel
def task_squares(settings, pose, target, spare_rows):
    """The squares of the error that the task counts; spare_rows: a Jacobian that may be overwritten."""
    e = pose_error(pose, target)
    if int(settings[TASK]) != WHOLE_POSE:
        e = task_error(settings, pose, target, e, spare_rows)
    return error_squares(e)


@kernel
def largest_entry(step_rows):
    """The largest size of an entry of a step."""
    largest = abs(load(step_rows, 0))
    for j in range(1, step_rows.shape[0]):
        largest = maximum(largest, abs(load(step_rows, j)))
    return largest
