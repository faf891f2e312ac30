"""Makes each kind of call of a page once, so that its kernels are compiled ahead."""

from collections.abc import Callable, Iterator

import numpy as np

from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import Sphere
from ulna.robot import Robot
from ulna.robot.hand_link import hand_link
from ulna.viewer.session.clearance import clearance
from ulna.viewer.session.ellipsoid import mobility
from ulna.viewer.session.hand import Hand

_FAR = 1e3  # [m] out of reach: finding the reason for that has kernels of its own


def rehearsals(robot: Robot, *, checked: bool) -> Iterator[tuple[str, Callable[[], object]]]:
    """The calls, each with a name that the page shows; those that are needed first come first.

    Args:
        robot: The robot of the page.
        checked: Whether its shapes can be checked for collisions.
    """
    world = World()
    world.add("ball", Sphere(1.0), pose((_FAR, 0.0, 0.0)))
    if robot.n_dof:
        yield "dragging the hand", lambda: _drag(robot, None)
        yield "the singular values of the hand", lambda: mobility(robot, robot.home, hand_link(robot))
    if checked:
        yield "the distance of any shapes", lambda: clearance(robot, robot.home, world)
    if checked and robot.n_dof:
        yield "dragging the hand round obstacles", lambda: _drag(robot, world)


def _drag(robot: Robot, world: World | None) -> None:
    """Drag the hand to its own pose, to one nearby, and to one out of reach."""
    hand = Hand(robot, hand_link(robot))
    for step in (0.0, 0.01, _FAR):
        T = robot.forward_kinematics(robot.home, link=hand.link).copy()
        T[:3, 3] += np.array((step, 0.0, 0.0))
        hand.follow(robot.home, T, world)
