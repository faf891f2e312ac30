"""The geometric Jacobian of a chain's end: the velocity of the end for a unit rate of each entry of q, linear part first.

Source: Lynch and Park, Modern Robotics (2017), chapter 5; Siciliano et al., Robotics (2009), section 3.1.
"""

import numpy as np

from ulna.kernels.block import all_in_range, gather
from ulna.kernels.compile import entry, kernel
from ulna.kernels.joint import joint_pose
from ulna.kernels.lanes import WIDTH, load, splat, store
from ulna.kernels.layout import COLUMN, FIXED, KIND, PRISMATIC, RATIO
from ulna.kernels.se3 import compose
from ulna.kernels.vectors import cross, turn_into

BASE, LINK, SPATIAL = 0, 1, 2  # the frame in which a Jacobian is expressed


@kernel
def chain_jacobian(chain, q_rows, expressed_in, axis_rows, jacobian_rows):
    """Write J, six rows an entry of q (v_x v_y v_z w_x w_y w_z), and return the end's pose.

    1. Walk the chain; note where each joint's axis z_i and origin p_i stand (axis_rows, six rows a joint).
    2. A revolute joint moves the point p_o with v = z_i x (p_o - p_i) and turns with w = z_i; a prismatic one moves it
       with v = z_i. The point p_o is the end's origin, or for SPATIAL the one that passes the base's origin.
    3. For LINK, turn both into the end's axes. Add them, times the joint's ratio, to the column of the entry of q that
       drives the joint: mimic joints share one.
    """
    zero = splat(0.0, load(q_rows, 0))
    end = joint_pose(chain, 0, q_rows)
    for i in range(chain.shape[0]):
        if i > 0:
            end = compose(end, joint_pose(chain, i, q_rows))
        for k in range(3):
            store(axis_rows, 6 * i + k, end[4 * k + 2])
            store(axis_rows, 6 * i + 3 + k, end[4 * k + 3])
    for k in range(jacobian_rows.shape[0]):
        store(jacobian_rows, k, zero)
    for i in range(chain.shape[0]):
        kind = int(chain[i, KIND])
        if kind == FIXED:
            continue
        z = load(axis_rows, 6 * i), load(axis_rows, 6 * i + 1), load(axis_rows, 6 * i + 2)
        if kind == PRISMATIC:
            v, w = z, (zero, zero, zero)
        else:
            p = load(axis_rows, 6 * i + 3), load(axis_rows, 6 * i + 4), load(axis_rows, 6 * i + 5)
            o = (zero, zero, zero) if expressed_in == SPATIAL else (end[3], end[7], end[11])
            v, w = cross(z, (o[0] - p[0], o[1] - p[1], o[2] - p[2])), z
        if expressed_in == LINK:
            v, w = turn_into(end, v), turn_into(end, w)
        row, ratio = 6 * int(chain[i, COLUMN]), chain[i, RATIO]
        for k in range(3):
            store(jacobian_rows, row + k, load(jacobian_rows, row + k) + v[k] * ratio)
            store(jacobian_rows, row + 3 + k, load(jacobian_rows, row + 3 + k) + w[k] * ratio)
    return end


@entry
def jacobian_one(chain, expressed_in, q, out):
    """Write J to out, shape (6, n_dof), for one q. False if an entry of q is out of range."""
    axis_rows, jacobian_rows = np.empty(6 * chain.shape[0]), np.empty(6 * out.shape[1])
    chain_jacobian(chain, q, expressed_in, axis_rows, jacobian_rows)
    for j in range(out.shape[1]):
        for k in range(6):
            out[k, j] = jacobian_rows[6 * j + k]
    return all_in_range(q)


@entry
def jacobian_batch(chain, expressed_in, q, out):
    """The same for q of shape (n, n_dof), out of shape (n, 6, n_dof): eight rows at a time."""
    n, n_dof = q.shape
    q_rows = np.zeros((max(1, n_dof), WIDTH))
    axis_rows, jacobian_rows = np.empty((6 * chain.shape[0], WIDTH)), np.empty((6 * n_dof, WIDTH))
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        chain_jacobian(chain, q_rows, expressed_in, axis_rows, jacobian_rows)
        for lane in range(WIDTH):
            i = min(start + lane, n - 1)
            for j in range(n_dof):
                for k in range(6):
                    out[i, k, j] = jacobian_rows[6 * j + k, lane]
    return good
