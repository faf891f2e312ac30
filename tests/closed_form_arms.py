"""Arms of every family of closed forms, with random geometry; and the arms of makers, by their DH tables."""

import numpy as np

import formulas
import robots
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link
from ulna.kernels.chain import closed_form_layout as layout
from ulna.robot import Robot

FAMILIES = (
    layout.THREE_PARALLEL, layout.PARALLEL_23, layout.INTERSECTING_12, layout.PARALLEL_12, layout.INTERSECTING_23,
    layout.OFFSET_HAND, layout.ANY_THREE_AXES,
)  # fmt: skip
QUARTIC = FAMILIES[-2:]
HALF_TURN = Limits(-np.pi, np.pi)


def direction(rng):
    return robots.unit(*rng.normal(size=3))


def family_axes(family, rng):
    """Six directions and points (6, 3) of a family; parallel axes are antiparallel as often."""
    h, c = np.array([direction(rng) for _ in range(6)]), rng.uniform(-0.4, 0.4, (6, 3))
    opposite = rng.choice([-1.0, 1.0], size=6)
    if family == layout.THREE_PARALLEL:
        h[2], h[3], c[5] = opposite[2] * h[1], opposite[3] * h[1], c[4]
        return h, c
    if family == layout.OFFSET_HAND:
        h[2], h[3] = opposite[2] * h[1], opposite[3] * h[1]
        return h, c
    c[4] = c[5] = c[3]
    if family == layout.PARALLEL_23:
        h[2] = opposite[2] * h[1]
    elif family == layout.PARALLEL_12:
        h[1] = opposite[1] * h[0]
    elif family == layout.INTERSECTING_12:
        c[1] = c[0]
    elif family == layout.INTERSECTING_23:
        c[2] = c[1]
    return h, c


def arm_of_axes(h, c, rng, *, limits=HALF_TURN, name="arm"):
    """An arm whose links' frames are all turned like the base where q = 0; a tool stands askew at its end."""
    n = len(h)
    links = tuple(Link(f"l{k}") for k in range(n + 2))
    steps = np.diff(np.vstack([np.zeros(3), c]), axis=0)
    joints = [
        Joint(f"j{k + 1}", JointType.REVOLUTE, f"l{k}", f"l{k + 1}", formulas.transform(np.eye(3), step), axis, limits)
        for k, (step, axis) in enumerate(zip(steps, h, strict=True))
    ]
    tool = formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3)), rng.uniform(-0.2, 0.2, 3))
    joints.append(Joint("tool", JointType.FIXED, f"l{n}", f"l{n + 1}", tool, np.array([0.0, 0.0, 1.0])))
    return Robot(Description(name, links, tuple(joints)))


def arm_of(family, rng, *, from_end=False, right_angles=False):
    """An arm of a family, or one that is of it seen from its end."""
    h, c = family_axes(family, rng)
    if right_angles:
        h, c = right_angled(family, rng)
    return arm_of_axes(h[::-1], c[::-1], rng) if from_end else arm_of_axes(h, c, rng)


def right_angled(family, rng):
    """The same with axes along x, y and z, as makers build them."""
    x, y, z = np.eye(3)
    _, c = family_axes(family, rng)
    h = {
        layout.THREE_PARALLEL: (z, y, y, y, z, y),
        layout.PARALLEL_23: (z, y, y, x, y, x),
        layout.INTERSECTING_12: (z, y, x, y, z, y),
        layout.PARALLEL_12: (z, z, y, z, y, z),
        layout.INTERSECTING_23: (z, y, x, z, y, z),
        layout.OFFSET_HAND: (z, y, y, y, z, y),
        layout.ANY_THREE_AXES: (z, y, x, z, y, z),
    }[family]
    return np.array(h), c
