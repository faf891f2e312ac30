"""Chooses the configuration in which a view begins, and finds nearby collision-free configurations.

A view begins at home, unless the arm is stretched there.
"""

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

NAME = "the first configuration"
_STRETCHED = 0.1  # share of the largest manipulability of all candidates, below which a configuration is nearly singular
_MIN_SHARE = 0.5  # share of the largest manipulability that a bent candidate needs
_MAX_BENT = 7  # joints that are bent, those nearest to the hand: 3^7 candidates
_BEND = np.pi / 2
_DEVIATIONS = np.repeat(np.geomspace(0.03, 1.5, 12), 24)  # [rad or m] standard deviations of the sampled configurations
_TRIES = 40  # calls of ``is_good``
_ROUNDING = 1e-9  # share of the largest singular value, below which a singular value counts as zero
Array = NDArray[np.float64]


def configurations_of(robot: Robot) -> dict[str, Array]:
    """Home and the SRDF's configurations of all joints, by name, shape (n_dof,) each.

    ``home`` is the SRDF's if it has one.
    """
    named = {name: q for name, q in robot.named_configurations.items() if np.shape(q) == (robot.n_dof,)}
    return {"home": robot.home, **named}


def first_configuration(robot: Robot, world: World) -> Array:
    """Choose home; or, if the hand is nearly singular there, another configuration, shape (n_dof,).

    1. The first of the SRDF's configurations that is collision-free and not nearly singular.
    2. Otherwise, if most joints move the hand, a bent configuration. Each revolute joint between the first and the last stays as
       at home, or turns by 90 degrees to either side, within its limits. A candidate has to be collision-free, with at least half
       of the largest manipulability. The candidate with the fewest bent joints is taken; among equals, the one with the highest
       hand.
    3. Otherwise home.
    """
    link, known = hand_link(robot), np.array(list(configurations_of(robot).values()))
    driven, bent = driven_columns(robot, link), _bent_configurations(robot, known[0], link)
    both = np.concatenate([known, bent])
    sizes = np.linalg.svd(robot.jacobian(both, link=link)[..., driven], compute_uv=False)
    rank = (sizes > _ROUNDING * sizes.max()).sum(axis=-1).max()  # a planar arm moves its hand in three directions
    values = sizes[:, :rank].prod(axis=-1)
    if values[0] >= _STRETCHED * values.max():
        return known[0]
    free = ~_in_collision(robot, both, world)
    given = known[(free & (values >= _STRETCHED * values.max()))[: len(known)]]
    good = bent[(free & (values >= _MIN_SHARE * values.max()))[len(known) :]]
    if len(given) or not len(good) or 2 * len(driven) <= robot.n_dof:
        return given[0] if len(given) else known[0]
    n_bent = np.count_nonzero(good != known[0], axis=1)
    heights = robot.forward_kinematics(good, link=link)[:, 2, 3].round(6)
    return good[np.lexsort((-heights, n_bent))[0]]


def free_configuration_near(robot: Robot, world: World, q: Array, is_good: Callable[[Array], bool]) -> Array | None:
    """Find a collision-free configuration near q, shape (n_dof,), that ``is_good`` accepts; None if there is none.

    The result is the same in every run.
    """
    away = _DEVIATIONS[:, None] * np.random.default_rng(0).normal(size=(len(_DEVIATIONS), robot.n_dof))
    tried = np.clip(np.concatenate([q + away, list(configurations_of(robot).values())]), robot.lower, robot.upper)
    tried = tried[np.argsort(np.abs(tried - q).max(axis=1), kind="stable")]
    free = tried[~_in_collision(robot, tried, world)]
    return next((one for one in free[:_TRIES] if is_good(one)), None)


def _bent_configurations(robot: Robot, home: Array, link: str) -> Array:
    """Configurations with joints bent from home, shape (n, n_dof)."""
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


def _in_collision(robot: Robot, q: Array, world: World) -> NDArray[np.bool_]:
    """Whether each configuration (n, n_dof) is in collision; False if the robot's shapes cannot be checked."""
    try:
        return np.asarray(robot.in_collision(q, world))
    except GeometryError:
        return np.zeros(len(q), dtype=bool)
