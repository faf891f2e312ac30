"""Computes distance, witness points, normal and distance gradient of one pair.

A pair is a body of the robot and another, or an object of the world, numbered from the last body on.
"""

from ulna.engine.decorators import kernel
from ulna.kernels.collision.collision_layout import DISTANCE, NORMAL, WITNESS_A, WITNESS_B
from ulna.kernels.collision.posed_pair import rows_contact, solid_at
from ulna.kernels.layout import COLUMN, JOINT, KIND, PARENT, PRISMATIC, RATIO
from ulna.kernels.spatial.se3 import load_pose
from ulna.kernels.spatial.vectors import cross, dot, minus, origin, z_axis


@kernel
def write_contact(scene, body_rows, i, j, scratch, out, row):
    """Write the contact of a pair, in plain numbers, to a row of out."""
    bodies, vertices, a = scene.bodies, scene.vertices, load_pose(body_rows, i)
    n = bodies.shape[0]
    if j < n:
        distance, p, q, normal = rows_contact(bodies, vertices, i, a, bodies, vertices, j, load_pose(body_rows, j), scratch)
    else:
        solid, b = solid_at(scene, j - n, 0.0)
        distance, p, q, normal = rows_contact(bodies, vertices, i, a, scene.objects, scene.points, solid, b, scratch)
    out[row, DISTANCE] = distance
    out[row, WITNESS_A], out[row, WITNESS_A + 1], out[row, WITNESS_A + 2] = p
    out[row, WITNESS_B], out[row, WITNESS_B + 1], out[row, WITNESS_B + 2] = q
    out[row, NORMAL], out[row, NORMAL + 1], out[row, NORMAL + 2] = normal


@kernel
def write_gradient(scene, joint_rows, i, j, contacts, out, row):
    """Write the gradient of the distance of a pair to a row of out."""
    for k in range(out.shape[1]):
        out[row, k] = 0.0
    if i >= 0:
        add_speeds(scene.joints, joint_rows, int(scene.bodies[i, JOINT]), contacts, row, WITNESS_A, -1.0, out)
        if j < scene.bodies.shape[0]:
            add_speeds(scene.joints, joint_rows, int(scene.bodies[j, JOINT]), contacts, row, WITNESS_B, 1.0, out)


@kernel
def add_speeds(joints, joint_rows, joint, contacts, row, witness, sign, out):
    """Add to a row of out, for each entry of q, sign times the speed along the normal of a witness point moved by a joint."""
    point = contacts[row, witness], contacts[row, witness + 1], contacts[row, witness + 2]
    normal = contacts[row, NORMAL], contacts[row, NORMAL + 1], contacts[row, NORMAL + 2]
    while joint >= 0:
        pose = load_pose(joint_rows, joint)
        z = z_axis(pose)
        if int(joints[joint, KIND]) != PRISMATIC:
            z = cross(z, minus(point, origin(pose)))
        out[row, int(joints[joint, COLUMN])] += sign * joints[joint, RATIO] * dot(normal, z)
        joint = int(joints[joint, PARENT])
