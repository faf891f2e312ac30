"""Computes the geometric Jacobian of a chain's end, linear part first.

Column j is the velocity of the end for a unit rate of entry j of q.

Source: Lynch and Park, Modern Robotics (2017), chapter 5; Siciliano et al., Robotics (2009), section 3.1.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, store
from ulna.kernels.chain.poses import joint_pose, turned_joint_pose
from ulna.kernels.layout import COLUMN, FIXED, IN_LINK, IN_SPATIAL, KIND, PRISMATIC, RATIO
from ulna.kernels.spatial.se3 import compose
from ulna.kernels.spatial.vectors import cross, origin, plus, rotate_inverse, scaled, z_axis


@kernel
def chain_jacobian(chain, q_rows, expressed_in, jacobian_rows, across, down):
    """Write J, entry (k, j) to row ``across * j + down * k``, and return the end's pose.

    The rows of J are v_x, v_y, v_z, w_x, w_y, w_z.

    1. Walk the chain and add the twist of each joint. This is J for IN_SPATIAL.
    2. The end's origin o moves with v + w x o. This is J for IN_BASE.
    3. For IN_LINK, rotate both parts into the end's axes.
    """
    clear(jacobian_rows, load(q_rows, 0))
    end = joint_pose(chain, 0, q_rows)
    add_joint(chain, 0, end, jacobian_rows, across, down)
    for i in range(1, chain.shape[0]):
        end = compose(end, joint_pose(chain, i, q_rows))
        add_joint(chain, i, end, jacobian_rows, across, down)
    express(end, expressed_in, jacobian_rows, across, down)
    return end


@kernel
def turned_chain_jacobian(chain, is_first, turn_rows, expressed_in, jacobian_rows, across, down):
    """``chain_jacobian`` from the output of ``joint_turns``.

    A joint adds to its column, or writes it if it is the chain's first joint with its entry of q (``is_first``, from
    ``first_joints``). So the rows need no clearing, but rows of entries without a joint in the chain must be zero.
    """
    end = turned_joint_pose(chain, 0, turn_rows)
    write_joint(chain, 0, is_first, end, jacobian_rows, across, down)
    for i in range(1, chain.shape[0]):
        end = compose(end, turned_joint_pose(chain, i, turn_rows))
        write_joint(chain, i, is_first, end, jacobian_rows, across, down)
    express(end, expressed_in, jacobian_rows, across, down)
    return end


@kernel
def first_joints(chain, is_first):
    """Write 1 for each moving joint of a chain that is the first with its entry of q, else 0."""
    for i in range(chain.shape[0]):
        is_first[i] = 1 if chain[i, KIND] != FIXED else 0
        for k in range(i):
            if chain[k, KIND] != FIXED and chain[k, COLUMN] == chain[i, COLUMN]:
                is_first[i] = 0


@kernel
def clear(jacobian_rows, like):
    """Write zeros."""
    zero = splat(0.0, like)
    for k in range(jacobian_rows.shape[0]):
        store(jacobian_rows, k, zero)


@kernel
def add_joint(chain, i, end, jacobian_rows, across, down):
    """Add the twist of joint i, with the pose ``end``, to its column; mimic joints share a column."""
    if int(chain[i, KIND]) != FIXED:
        v, w = joint_twist(chain, i, end)
        add_twist(jacobian_rows, across * int(chain[i, COLUMN]), down, v, w)


@kernel
def write_joint(chain, i, is_first, end, jacobian_rows, across, down):
    """Write or add the twist of joint i to the column of its entry of q: write it if ``is_first``."""
    if int(chain[i, KIND]) != FIXED:
        v, w = joint_twist(chain, i, end)
        row = across * int(chain[i, COLUMN])
        if is_first[i] == 1:
            store_column(jacobian_rows, row, down, v, w)
        else:
            add_twist(jacobian_rows, row, down, v, w)


@kernel
def joint_twist(chain, i, end):
    """The twist of joint i for a unit rate of its entry of q.

    It is the velocity of the point at the base's origin, and the angular velocity.

    A joint along or about z, with its frame's origin at p, moves that point. A revolute joint gives v = p x z and w = z, a
    prismatic joint v = z, times the joint's ratio.
    """
    z = z_axis(end)
    if int(chain[i, KIND]) == PRISMATIC:
        zero = splat(0.0, z[0])
        v, w = z, (zero, zero, zero)
    else:
        v, w = cross(origin(end), z), z
    return scaled(v, chain[i, RATIO]), scaled(w, chain[i, RATIO])


@kernel
def express(end, expressed_in, jacobian_rows, across, down):
    """Steps 2 and 3."""
    if expressed_in != IN_SPATIAL:
        for j in range(jacobian_rows.shape[0] // 6):
            move_column(jacobian_rows, across * j, down, end, expressed_in)


@kernel
def column(jacobian_rows, row, down):
    """The linear and the angular part of the column that begins at a row."""
    v = load(jacobian_rows, row), load(jacobian_rows, row + down), load(jacobian_rows, row + 2 * down)
    w = load(jacobian_rows, row + 3 * down), load(jacobian_rows, row + 4 * down), load(jacobian_rows, row + 5 * down)
    return v, w


@kernel
def store_column(jacobian_rows, row, down, v, w):
    """Write both parts of a column."""
    store_part(jacobian_rows, row, down, v)
    store_part(jacobian_rows, row + 3 * down, down, w)


@kernel
def store_part(jacobian_rows, row, down, v):
    """Write the three numbers of one part, the first to the given row."""
    for k in range(3):
        store(jacobian_rows, row + down * k, v[k])


@kernel
def add_twist(jacobian_rows, row, down, v, w):
    """Add to both parts of a column."""
    v_before, w_before = column(jacobian_rows, row, down)
    store_column(jacobian_rows, row, down, plus(v_before, v), plus(w_before, w))


@kernel
def move_column(jacobian_rows, row, down, end, expressed_in):
    """Steps 2 and 3 for one column."""
    v, w = column(jacobian_rows, row, down)
    v = plus(v, cross(w, origin(end)))
    if expressed_in != IN_LINK:
        store_part(jacobian_rows, row, down, v)
        return
    store_column(jacobian_rows, row, down, rotate_inverse(end, v), rotate_inverse(end, w))
