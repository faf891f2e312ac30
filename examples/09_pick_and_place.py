"""Picks a part on one side of a wall and places it on the other, without collisions.

``robot.plan`` plans each move, and ``plan.trajectory`` gives it a time parameterization. With ``--view`` the arm works on a page,
again and again, while you drag the wall: choose it in the tab Obstacles. Every frame certifies the rest of the motion. If the
wall is in the way, the arm plans again. Ctrl-C ends.
"""

import sys
import time

import numpy as np

import ulna

PART = ulna.Box(extents=(0.04, 0.04, 0.1))
HAND = ("panda_link7",)  # has the collision boxes of the hand and the fingers
T_EE_PART = ulna.pose(xyz=(0.0, 0.0, 0.03))  # the fingers hold the part near its top
# The part stands 1 mm above the table, since contact counts as a collision. Its frame is upside down, as the hand's is.
LEFT, RIGHT = (ulna.pose(xyz=(0.45, y, 0.151), rpy=(np.pi, 0.0, 0.0)) for y in (-0.25, 0.25))
UP = ulna.pose(xyz=(0.0, 0.0, 0.12))
FRAME_S = 1 / 30

robot = ulna.load("panda")
holding = robot.with_attached("part", PART, T_EE_PART, touch_links=HAND)


def obstacles(arm, world):
    """The world without the part, if the arm holds it."""
    if not arm.attached:
        return world
    rest = world.copy()
    rest.remove("part")
    return rest


def move(arm, q, T_part, world):
    """Move the arm so that its fingers are at the pose of the part. Yields q frame by frame.

    The arm stands still while there is no path.
    """
    goal = T_part @ np.linalg.inv(T_EE_PART)
    while True:
        plan = arm.plan(q, goal, obstacles(arm, world))
        if not plan:
            yield q
            continue
        motion = plan.improve(500).trajectory(acceleration=3.0)  # 500 more edges, about 10 ms, for a shorter path
        for t in np.arange(FRAME_S, motion.duration + FRAME_S, FRAME_S):
            if not motion.is_free(obstacles(arm, world), since=t - FRAME_S):  # the wall was moved
                break
            q = motion.at(t).q
            yield q
        else:
            return


def pick_and_place(world, q, T_from, T_to):
    """Carry the part from one pose to another. Yields the arm (bare or holding) and q of each frame."""
    for arm, T_part in (
        (robot, UP @ T_from),
        (robot, T_from),
        (holding, UP @ T_from),
        (holding, UP @ T_to),
        (holding, T_to),
        (robot, UP @ T_to),
    ):
        for q_next in move(arm, q, T_part, world):
            q = q_next
            if arm.attached:
                world.move("part", arm.forward_kinematics(q) @ T_EE_PART)
            yield arm, q


def show(world):
    """Carry the part there and back on a page, until Ctrl-C."""
    T_from, T_to = LEFT, RIGHT
    with ulna.view(robot, world, open_browser=True) as view:
        print(f"{view.url}: choose the wall in the tab Obstacles and drag it; Ctrl-C ends", flush=True)
        try:
            while True:
                for _, q in pick_and_place(world, view.q, T_from, T_to):
                    view.q = q
                    time.sleep(FRAME_S)
                print("the part is put down", flush=True)
                T_from, T_to = T_to, T_from
        except KeyboardInterrupt:
            pass


world = ulna.World()
world.add("table", ulna.Box(extents=(0.7, 1.2, 0.05)), ulna.pose(xyz=(0.6, 0.0, 0.075)))
world.add("wall", ulna.Box(extents=(0.3, 0.02, 0.4)), ulna.pose(xyz=(0.5, 0.0, 0.3)))
world.add("part", PART, LEFT, touch_links=HAND)

if "--view" in sys.argv:
    show(world)
else:
    frames = list(pick_and_place(world, robot.home, LEFT, RIGHT))
    print(f"{len(frames) * FRAME_S:.1f} s until the part is at {world.pose('part')[:3, 3].round(3)} m")
    assert np.allclose(world.pose("part"), RIGHT, atol=1e-4)
    carried, around = np.array([q for arm, q in frames if arm is holding]), obstacles(holding, world)
    clearance = holding.signed_distance(carried, around).min()
    print(f"the arm carries it for {len(carried) * FRAME_S:.1f} s, with a clearance of at least {1e3 * clearance:.1f} mm")
    assert clearance > 0
    straight = holding.edge_in_collision(carried[0], carried[-1], around)
    pair = holding.check_collision(straight.q, around, max_distance=1e-3).pairs[0]
    print(f"on a straight line in joint space, {pair.name_a} touches {pair.name_b} after {straight.free_until:.0%} of the path")
    assert straight.in_collision
