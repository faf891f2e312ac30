"""Chooses the configuration in which a view begins: home, unless the arm is stretched there; and one near by that is free."""

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.description.robot_description import JointType
from ulna.errors import GeometryError
from ulna.robot import Robot
from ulna.robot.hand_link import hand_link
from ulna.viewer.session.ellipsoid import driven_columns

NAME = "where the arm begins"
_STRETCHED = 0.1  # of the largest manipulability of the candidates: home is kept above it
_ENOUGH = 0.5  # of the largest, for a candidate
_MAX_BENT = 7  # joints that are tried, those nearest to the hand: 3^7 candidates
_BEND = np.pi / 2
_NEAR_BY = np.repeat(np.geomspace(0.03, 1.5, 12), 24)  # [rad or m] how far away configurations are tried
_TRIES = 40
_ROUNDING = 1e-9  # of the largest singular value: a smaller one is 0 but for rounding
Array = NDArray[np.float64]


def configurations_of(robot: Robot) -> dict[str, Array]:
    """Home and the SRDF's configurations of all joints, by name, shape (n_dof,) each; ``home`` is the SRDF's if it has one."""
    named = {name: q for name, q in robot.named_configurations.items() if np.shape(q) == (robot.n_dof,)}
    return {"home": robot.home, **named}


def beginning(robot: Robot, world: World) -> Array:
    """Home; or, if the hand is nearly singular there, a configuration in which it is not, shape (n_dof,).

    The SRDF's configurations come first: the first that is not nearly singular and touches nothing is taken. Else, if most joints
    move the hand, these are bent: each revolute one between the first and the last stays as at home, or turns by a quarter to
    either side, within its limits. Of the results that touch nothing and have at least half of the largest manipulability, the
    one with the fewest bent joints is taken, and of equals the one with the highest hand. If no result does, it is home.
    """
    link, known = hand_link(robot), np.array(list(configurations_of(robot).values()))
    driven, bent = driven_columns(robot, link), _bent(robot, known[0], link)
    both = np.concatenate([known, bent])
    sizes = np.linalg.svd(robot.jacobian(both, link=link)[..., driven], compute_uv=False)
    rank = (sizes > _ROUNDING * sizes.max()).sum(axis=-1).max()  # a planar arm moves its hand in three directions
    values = sizes[:, :rank].prod(axis=-1)
    if values[0] >= _STRETCHED * values.max():
        return known[0]
    free = ~_touching(robot, both, world)
    given = known[(free & (values >= _STRETCHED * values.max()))[: len(known)]]
    good = bent[(free & (values >= _ENOUGH * values.max()))[len(known) :]]
    if len(given) or not len(good) or 2 * len(driven) <= robot.n_dof:
        return given[0] if len(given) else known[0]
    n_bent = np.count_nonzero(good != known[0], axis=1)
    heights = robot.forward_kinematics(good, link=link)[:, 2, 3].round(6)
    return good[np.lexsort((-heights, n_bent))[0]]


def free_near(robot: Robot, world: World, q: Array, is_good: Callable[[Array], bool]) -> Array | None:
    """A configuration near q, shape (n_dof,), that touches nothing and is good; None if none is found. The same in every run."""
    away = _NEAR_BY[:, None] * np.random.default_rng(0).normal(size=(len(_NEAR_BY), robot.n_dof))
    tried = np.clip(np.concatenate([q + away, list(configurations_of(robot).values())]), robot.lower, robot.upper)
    tried = tried[np.argsort(np.abs(tried - q).max(axis=1), kind="stable")]
    free = tried[~_touching(robot, tried, world)]
    return next((one for one in free[:_TRIES] if is_good(one)), None)


def _bent(robot: Robot, home: Array, link: str) -> Array:
    """Configurations with joints that are bent from home, shape (n, n_dof)."""
    types = {joint.name: joint.type for joint in robot.description.joints}
    turning = [
        place.start
        for name, place in zip(robot.joint_names, robot.joint_slices, strict=True)
        if types[name] in (JointType.REVOLUTE, JointType.CONTINUOUS)
    ]
    columns = [column for column in driven_columns(robot, link)[1:-1] if column in turning][-_MAX_BENT:]
    q = np.repeat(home[None], 3 ** len(columns), axis=0)
    q[:, columns] += _BEND * np.array(list(product((0.0, 1.0, -1.0), repeat=len(columns))))
    return q[((q >= robot.lower) & (q <= robot.upper)).all(axis=1)]


def _touching(robot: Robot, q: Array, world: World) -> NDArray[np.bool_]:
    """Which configurations (n, n_dof) touch anything; none of a robot whose shapes cannot be checked."""
    try:
        return np.asarray(robot.in_collision(q, world))
    except GeometryError:
        return np.zeros(len(q), dtype=bool)
