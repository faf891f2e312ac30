"""Pick and place: the Panda takes a part from one side of a wall and puts it down on the other, and touches nothing on the way.

With ``--view`` it does so again and again on a page, and you drag the wall: choose it in the tab Obstacles. Ctrl-C ends.
"""

import sys
import time
from itertools import pairwise

import numpy as np

import ulna

PART = ulna.Box(extents=(0.04, 0.04, 0.1))
TABLE, T_TABLE = ulna.Box(extents=(0.7, 1.2, 0.05)), ulna.pose(xyz=(0.6, 0.0, 0.075))
HAND = ("panda_link7",)  # carries the boxes of the hand and the fingers
T_EE_PART = ulna.pose(xyz=(0.0, 0.0, 0.03))  # the fingers hold it near its top
# On the table; upside down, as the hand is that takes it.
LEFT, RIGHT = (ulna.pose(xyz=(0.45, y, 0.15), rpy=(np.pi, 0.0, 0.0)) for y in (-0.25, 0.25))
ABOVE = 0.12  # m
FRAME_S, SPEED = 1 / 30, 0.8  # s; rad/s of the joint that moves most

robot, rng = ulna.load("panda"), np.random.default_rng(0)
holding = robot.with_attached("part", PART, T_EE_PART, touch_links=HAND)


def around(world, arm, *, on_table):
    """The obstacles of an arm. A part that it holds is none, and may touch the table only where it is taken or put down."""
    if not arm.attached:
        return world
    seen = world.copy()
    seen.remove("part")
    seen.remove("table")
    seen.add("table", TABLE, T_TABLE, touch_links=["part"] if on_table else [])
    return seen


def plan(arm, world, q, T_part):
    """The way from q to where the part is at a pose between the fingers: straight, or through one of 500 random configurations.

    ``edge_in_collision`` certifies whole edges, all of them in one call. An empty list if there is none that is free.
    """
    found = arm.inverse_kinematics(T_part @ np.linalg.inv(T_EE_PART), q, world=world, rank="nearest")
    if not found.success:
        return []
    if not arm.edge_in_collision(q, found.q, world):
        return [q, found.q]
    vias = np.clip((q + found.q) / 2 + rng.normal(scale=0.5, size=(500, arm.n_dof)), arm.lower, arm.upper)
    blocked = arm.edge_in_collision(q, vias, world).in_collision | arm.edge_in_collision(vias, found.q, world).in_collision
    lengths = np.where(blocked, np.inf, np.linalg.norm(vias - q, axis=1) + np.linalg.norm(vias - found.q, axis=1))
    return [] if blocked.all() else [q, vias[lengths.argmin()], found.q]


def frames(way):
    """Configurations along a way, one a frame."""
    for a, b in pairwise(way):
        n = int(np.ceil(np.abs(b - a).max() / SPEED / FRAME_S))
        yield from a + np.linspace(0, 1, n + 1)[1:, None] * (b - a)


def pick_and_place(world, q, T_from, T_to):
    """Frame by frame the arm (bare, or holding the part), its q, and whether it moves: it stands while nothing leads on."""
    up = ulna.pose(xyz=(0.0, 0.0, ABOVE))
    for arm, T_part, on_table in (
        (robot, up @ T_from, False),
        (robot, T_from, False),
        (holding, up @ T_from, True),
        (holding, up @ T_to, False),
        (holding, T_to, True),
        (robot, up @ T_to, False),
    ):
        while not (way := plan(arm, around(world, arm, on_table=on_table), q, T_part)):
            yield arm, q, False
        for ahead in frames(way):
            while arm.in_collision(ahead, around(world, arm, on_table=on_table)):  # something was put in the way
                yield arm, q, False
            q = ahead
            yield arm, q, True
            if arm.attached:
                world.move("part", robot.forward_kinematics(q) @ T_EE_PART)


def show(world):
    """There and back again on a page, until Ctrl-C."""
    T_from, T_to = LEFT, RIGHT
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: choose the wall in the tab Obstacles and drag it; Ctrl-C ends", flush=True)
        try:
            while True:
                for _, q, moves in pick_and_place(world, view.q, T_from, T_to):
                    if moves:
                        view.q = q
                    time.sleep(FRAME_S)
                print("the part is put down", flush=True)
                T_from, T_to = T_to, T_from
        except KeyboardInterrupt:
            pass


world = ulna.World()
world.add("table", TABLE, T_TABLE)
world.add("wall", ulna.Box(extents=(0.3, 0.02, 0.3)), ulna.pose(xyz=(0.5, 0.0, 0.25)))
world.add("part", PART, LEFT, touch_links=HAND)

if "--view" in sys.argv:
    show(world)
else:
    left, right = (robot.inverse_kinematics(T @ np.linalg.inv(T_EE_PART), robot.home, rank="nearest").q for T in (LEFT, RIGHT))
    straight = robot.edge_in_collision(left, right, world)
    print(f"straight from one place to the other: {straight}")
    assert straight.in_collision
    path = list(pick_and_place(world, robot.home, LEFT, RIGHT))
    assert all(moves for _, _, moves in path)
    carried = sum(arm is holding for arm, _, _ in path)
    print(f"{len(path)} free frames lead there, {carried} of them with the part")
    assert np.allclose(world.pose("part"), RIGHT, atol=1e-4)
