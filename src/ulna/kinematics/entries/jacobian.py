"""Runs the geometric Jacobian over one configuration or a batch."""

import numpy as np

from ulna.engine.decorators import entry, low_latency_entry
from ulna.engine.lanes import WIDTH, zero_rows
from ulna.engine.signatures import MATRICES, MATRIX, NUMBERS, TABLE, WHOLE
from ulna.kernels.chain.jacobian import chain_jacobian, first_joints, turned_chain_jacobian
from ulna.kernels.chain.poses import joint_turns
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kinematics.entries.batch import gather, scatter_rows, share_no_memory


@low_latency_entry((MATRIX, WHOLE, WHOLE, NUMBERS, MATRIX))
def jacobian_one(chain, expressed_in, n_dof, q, out):
    """Write J to out, shape (6, n_dof), for one q.

    Returns False, and writes nothing, unless q is n_dof numbers in range, and out has its shape and shares no memory with q.
    """
    if q.shape[0] != n_dof or out.shape != (6, n_dof) or not (all_in_range(q) and share_no_memory(q, out)):
        return False
    chain_jacobian(chain, q, expressed_in, out.reshape(out.size), 1, n_dof)
    return True


@entry((TABLE, WHOLE, MATRIX, MATRICES))
def jacobian_batch(chain, expressed_in, q, out):
    """Write J to out, shape (n, 6, n_dof), for q of shape (n, n_dof), eight rows at a time.

    Returns False if q is out of range.
    """
    n_dof = q.shape[1]
    q_rows, jacobian_rows = zero_rows(max(1, n_dof)), zero_rows(6 * n_dof)
    turn_rows, is_first = zero_rows(2 * chain.shape[0]), np.empty(chain.shape[0], np.int64)
    first_joints(chain, is_first)
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        joint_turns(chain, q_rows, turn_rows)
        turned_chain_jacobian(chain, is_first, turn_rows, expressed_in, jacobian_rows, 1, n_dof)
        scatter_rows(jacobian_rows, 6 * n_dof, out, start)
    return good
