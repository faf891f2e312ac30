"""Makes arms of every family of closed forms with random geometry, and arms of makers from their DH tables."""

import itertools

import numpy as np

import formulas
import robots
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link
from ulna.ik.closed_form.families import RULES
from ulna.robot import Robot

FAMILIES = tuple(rule.number for rule in RULES.values() if not any(rule.slides))
QUARTIC = tuple(family for family in FAMILIES if RULES[family].offset is not None)
NAMES = {family: RULES[family].name for family in FAMILIES}
HALF_TURN = Limits(-np.pi, np.pi)


def direction(rng):
    return robots.unit(*rng.normal(size=3))


def family_axes(family, rng):
    """Six directions and points (6, 3) of a family; parallel axes are antiparallel as often."""
    h, c = np.array([direction(rng) for _ in range(6)]), rng.uniform(-0.4, 0.4, (6, 3))
    opposite, rule = rng.choice([-1.0, 1.0], size=6), RULES[family]
    for i, j in rule.parallel:
        h[j] = opposite[j] * h[i]
    if rule.has_wrist:
        c[4] = c[5] = c[3]
    if rule.intersecting:
        i, j = rule.intersecting
        c[j] = c[i]
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
    """The same with axes along z, y and x, as makers build them: each across the one before it, unless the two are parallel."""
    parallel = {k for pair in RULES[family].parallel for k in pair}
    h = next(
        axes
        for axes in itertools.product(tuple(np.eye(3)[::-1]), repeat=6)
        if all((axes[k] is axes[k + 1]) == ({k, k + 1} <= parallel) for k in range(5))
    )
    _, c = family_axes(family, rng)
    return np.array(h), c
