"""Robots for tests as plain descriptions: one with every type of joint, and small ones with one type."""

import numpy as np

import formulas
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link, Mimic

X, Y, Z = np.eye(3)
# Universal Robots, "DH parameters for calculations of kinematics and dynamics" (standard): a, d, alpha, theta.
UR5 = [
    (0, 0.089159, np.pi / 2, 0),
    (-0.425, 0, 0, 0),
    (-0.39225, 0, 0, 0),
    (0, 0.10915, np.pi / 2, 0),
    (0, 0.09465, -np.pi / 2, 0),
    (0, 0.0823, 0, 0),
]
UR5E = [
    (0, 0.1625, np.pi / 2, 0),
    (-0.425, 0, 0, 0),
    (-0.3922, 0, 0, 0),
    (0, 0.1333, np.pi / 2, 0),
    (0, 0.0997, -np.pi / 2, 0),
    (0, 0.0996, 0, 0),
]
PUMA = [  # 560, standard
    (0, 0.6718, np.pi / 2, 0),
    (0.4318, 0, 0, 0),
    (0.0203, 0.15005, -np.pi / 2, 0),
    (0, 0.4318, np.pi / 2, 0),
    (0, 0, -np.pi / 2, 0),
    (0, 0, 0, 0),
]
_PLACES = [((0.1, -0.2, 0.3), (0.3, -0.5, 1.2)), ((0.0, 0.25, 0.1), (-1.1, 0.4, 0.2)), ((-0.3, 0.1, 0.05), (0.0, 0.0, 2.5))]


def unit(*axis):
    return np.array(axis) / np.linalg.norm(axis)


def place(k):
    """One of a few skew origins."""
    return formulas.from_rpy(*_PLACES[k % len(_PLACES)])


def two_links(kind, axis, *, origin=None, **other):
    """One joint between ``a`` and ``b``."""
    joint = Joint("j", JointType(kind), "a", "b", np.eye(4) if origin is None else origin, axis, **other)
    return Description("two links", (Link("a"), Link("b")), (joint,))


def of_chain(*kinds, axis=Z, origin=None):
    """A serial chain of joints ``j1``, ``j2``, ... between links ``l0``, ``l1``, ..."""
    links = tuple(Link(f"l{k}") for k in range(len(kinds) + 1))
    origin = np.eye(4) if origin is None else origin
    joints = tuple(Joint(f"j{k + 1}", JointType(kind), f"l{k}", f"l{k + 1}", origin, axis) for k, kind in enumerate(kinds))
    return Description("chain", links, joints)


def every_joint():
    """A tree with every type of joint, mimics of mimics, skew axes, and children that stand before their parents in the file."""
    turn, slide = Limits(-2.0, 2.5, 1.5), Limits(-0.2, 0.4, 0.3)
    joints = (
        Joint("wrist", JointType.REVOLUTE, "fixture", "hand", place(0), unit(1, 2, -3), turn, Mimic("shoulder", -0.5, 0.3)),
        Joint("shoulder", JointType.REVOLUTE, "base", "arm", place(1), unit(0.2, -1, 0.4), turn),
        Joint("table", JointType.PLANAR, "arm", "tray", place(2), unit(0.5, 0.5, 1)),
        Joint("slide", JointType.PRISMATIC, "arm", "rail", place(0), unit(-1, 1, 0.5), slide),
        Joint("wheel", JointType.CONTINUOUS, "rail", "rotor", place(1), -Z),
        Joint("weld", JointType.FIXED, "rotor", "fixture", place(2), X),
        Joint("finger", JointType.PRISMATIC, "hand", "fingertip", place(1), Y, slide, Mimic("wrist", 0.25, -0.05)),
        Joint("float", JointType.FLOATING, "base", "drone", place(0), Z),
        Joint("rotor joint", JointType.REVOLUTE, "drone", "propeller", place(1), X, turn),
    )
    names = ("fingertip", "base", "arm", "hand", "fixture", "tray", "rail", "rotor", "drone", "propeller")
    return Description("every joint", tuple(Link(name) for name in names), joints)
