"""Computes the derivatives of the torques with respect to q and its rates.

Source: Carpentier and Mansard, Analytical derivatives of rigid body dynamics algorithms (RSS 2018). The closed form is by Singh,
Russo and Wensing, Efficient analytical derivatives of rigid-body dynamics using spatial vector algebra (IEEE RA-L 2022).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat
from ulna.kernels.chain.jacobian import clear
from ulna.kernels.dynamics.composite import add_to, gather_inertias, pose_bodies
from ulna.kernels.dynamics.rigid_body import (
    add_pair,
    load_inertia,
    load_pair,
    momentum,
    motion_cross,
    pair_dot,
    pair_plus,
    pair_scaled,
    store_pair,
    symmetric_times,
    wrench_cross,
)
from ulna.kernels.layout import COLUMN, PARENT
from ulna.kernels.spatial.vectors import cross, dot, minus, plus, scaled


@kernel
def torque_derivatives(mechanism, gravity, state, n_dof, work, derivative_rows):
    """Write the derivatives of the torques with respect to q and its rates.

    Entry (r, c) is written to row n_dof * r + c. Let S be the twist of a joint, v and a the motion and the acceleration of its
    body, and p its parent.

    1. The rate of a twist is S' = v_p x S; its second rate is S'' = a_p x S + v_p x S'.
    2. For each body compute the inertia I, the momentum I v, and the wrench f = I a + v x* I v. Also compute the Coriolis
       matrix B (``coriolis_of``). Each is summed over the subtree of a joint.
    3. For joint i, and j between it and the base or i itself:
       d tau_j / d q_i = S_j . (2 B_i S'_i + I_i S''_i + S_i x* f_i)    d tau_j / d q'_i = S_j . (2 B_i S_i + 2 I_i S'_i)
       d tau_i / d q_j = S_i . (2 B_i S'_j + I_i S''_j)                 d tau_i / d q'_j = S_i . (2 B_i S_j + 2 I_i S'_j)

    Args:
        mechanism: The robot.
        gravity: The gravitational acceleration [m/s^2] in the axes of the base: three plain numbers.
        state: ``State``.
        n_dof: The number of entries of q.
        work: ``BodyRows`` and ``RateRows``.
        derivative_rows: n_dof^2 rows for the derivatives with respect to q, and n_dof^2 rows for its rates.
    """
    joints, (bodies, rates) = mechanism.joints, work
    pose_bodies(mechanism, state.turns, bodies)
    for i in range(joints.shape[0]):
        move_body(joints, gravity, i, state, work)
    gather_inertias(joints, bodies.inertias)
    for k in range(joints.shape[0] - 1):
        i = joints.shape[0] - 1 - k
        parent = int(joints[i, PARENT])
        if parent >= 0:
            for kept in (rates.momenta, rates.wrenches, rates.coriolis):
                v, w = load_pair(kept, i)
                add_pair(kept, parent, v, w)
    for derivative in derivative_rows:
        clear(derivative, load(state.turns, 0))
    for i in range(joints.shape[0]):
        write_pairs(joints, i, n_dof, work, derivative_rows)


@kernel
def move_body(joints, gravity, i, state, work):
    """Perform steps 1 and 2 for one joint."""
    bodies, rates = work
    twist, parent = load_pair(bodies.twists, i), int(joints[i, PARENT])
    zero = splat(0.0, twist[0][0])
    v = (zero, zero, zero), (zero, zero, zero)
    a = (splat(-gravity[0], zero), splat(-gravity[1], zero), splat(-gravity[2], zero)), v[1]
    if parent >= 0:
        v, a = load_pair(rates.motions, parent), load_pair(rates.accelerations, parent)
    twist_rate = motion_cross(v, twist)
    twist_acceleration = pair_plus(motion_cross(a, twist), motion_cross(v, twist_rate))
    rate, acceleration = load(state.rates, int(joints[i, COLUMN])), load(state.accelerations, int(joints[i, COLUMN]))
    v = pair_plus(v, pair_scaled(twist, rate))
    a = pair_plus(a, pair_plus(pair_scaled(twist, acceleration), pair_scaled(twist_rate, rate)))
    inertia = load_inertia(bodies.inertias, i)
    moving = momentum(inertia, v[0], v[1])
    wrench = pair_plus(momentum(inertia, a[0], a[1]), wrench_cross(v, moving))
    store_pair(rates.motions, i, v[0], v[1])
    store_pair(rates.accelerations, i, a[0], a[1])
    store_pair(rates.twist_rates, i, twist_rate[0], twist_rate[1])
    store_pair(rates.twist_accelerations, i, twist_acceleration[0], twist_acceleration[1])
    store_pair(rates.momenta, i, moving[0], moving[1])
    store_pair(rates.wrenches, i, wrench[0], wrench[1])
    coriolis = coriolis_of(inertia, v)
    store_pair(rates.coriolis, i, coriolis[:3], coriolis[3:])


@kernel
def coriolis_of(inertia, v):
    """The symmetric part C of the Coriolis matrix of a body: xx, xy, xz, yy, yz, zz.

    Twice the Coriolis matrix is v x* I - I v x + (I v) x*; the last term is an operator on its other factor. Let (p, L) be the
    momentum, h the moment and T the tensor. The upper blocks are 0 and -2 [p], the lower blocks 0 and C - [L]. Here
    C = [w] T + ([w] T)' - h v' - v h' + 2 (v . h) 1.
    """
    _, h, t = inertia
    u, w = v
    x, y, z = cross(w, (t[0], t[1], t[2])), cross(w, (t[1], t[3], t[4])), cross(w, (t[2], t[4], t[5]))  # columns of [w] T
    along = 2.0 * dot(u, h)
    return (
        2.0 * (x[0] - h[0] * u[0]) + along, x[1] + y[0] - h[0] * u[1] - h[1] * u[0], x[2] + z[0] - h[0] * u[2] - h[2] * u[0],
        2.0 * (y[1] - h[1] * u[1]) + along, y[2] + z[1] - h[1] * u[2] - h[2] * u[1], 2.0 * (z[2] - h[2] * u[2]) + along,
    )  # fmt: skip


@kernel
def write_pairs(joints, i, n_dof, work, derivative_rows):
    """Perform step 3 for one joint."""
    bodies, rates = work
    by_q, by_rate = derivative_rows
    column = int(joints[i, COLUMN])
    inertia, twist, twist_rate = load_inertia(bodies.inertias, i), load_pair(bodies.twists, i), load_pair(rates.twist_rates, i)
    (p, angular), (first, last) = load_pair(rates.momenta, i), load_pair(rates.coriolis, i)
    c = first + last
    acceleration = load_pair(rates.twist_accelerations, i)
    turned = pair_plus(momentum(inertia, acceleration[0], acceleration[1]), wrench_cross(twist, load_pair(rates.wrenches, i)))
    by_own_q = pair_plus(turned, coriolis_times(p, angular, c, twist_rate))
    of_rate = momentum(inertia, twist_rate[0], twist_rate[1])
    by_own_rate = pair_plus(pair_scaled(of_rate, 2.0), coriolis_times(p, angular, c, twist))
    carried = momentum(inertia, twist[0], twist[1])
    turning = plus(scaled(cross(p, twist[0]), 2.0), plus(symmetric_times(c, twist[1]), cross(angular, twist[1])))  # 2 B' S
    add_to(by_q, n_dof * column + column, pair_dot(twist, by_own_q))
    add_to(by_rate, n_dof * column + column, pair_dot(twist, by_own_rate))
    j = int(joints[i, PARENT])
    while j >= 0:
        row, other, other_rate = int(joints[j, COLUMN]), load_pair(bodies.twists, j), load_pair(rates.twist_rates, j)
        add_to(by_q, n_dof * row + column, pair_dot(other, by_own_q))
        add_to(by_rate, n_dof * row + column, pair_dot(other, by_own_rate))
        of_other = dot(turning, other_rate[1]) + pair_dot(carried, load_pair(rates.twist_accelerations, j))
        add_to(by_q, n_dof * column + row, of_other)
        add_to(by_rate, n_dof * column + row, dot(turning, other[1]) + 2.0 * pair_dot(carried, other_rate))
        j = int(joints[j, PARENT])


@kernel
def coriolis_times(p, angular, c, motion):
    """Twice the Coriolis matrix of ``coriolis_of`` times a motion, with the momentum (p, L)."""
    w = motion[1]
    return scaled(cross(p, w), -2.0), minus(symmetric_times(c, w), cross(angular, w))
