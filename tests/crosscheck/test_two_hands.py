"""Baxter carries a tray with both hands: judged by Pinocchio at 64 times as many samples as a planner would test."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import Peer
from robot_files import load_baxter

HANDS = "left_gripper_base_link", "right_gripper_base_link"
_APART = 1 / 32 / 64  # [rad]


@pytest.fixture(scope="module")
def baxter():
    return load_baxter()


def hands(x, y, z, yaw=0.0):
    """The hands at both ends of a tray 40 cm wide, fingers towards each other."""
    tray = ulna.pose((x, y, z), rpy=(0, 0, yaw))
    ends = (ulna.pose((0, side, 0), rpy=(np.copysign(np.pi / 2, side), 0, 0)) for side in (0.2, -0.2))
    return {hand: tray @ end for hand, end in zip(HANDS, ends, strict=True)}


@pytest.mark.slow
def test_the_hands_never_leave_the_tray_by_more_than_the_tolerance(baxter):
    peer = Peer(baxter, pin.buildModelFromXML(baxter.to_urdf()))
    left, right = (baxter.link_names.index(hand) for hand in HANDS)
    world = ulna.World()
    world.add("post", ulna.Box((0.08, 0.08, 0.3)), ulna.pose((0.65, 0, -0.25)))
    start = baxter.plan(baxter.home, hands(0.65, 0, 0.2), world).path[-1]
    keep = (ulna.Keep.together(*HANDS), ulna.Keep.upright(np.radians(15), link=HANDS[0]))
    T_0 = baxter.forward_kinematics(start, link=HANDS[0])
    held = np.linalg.inv(T_0) @ baxter.forward_kinematics(start, link=HANDS[1])
    both = hands(0.65, -0.1, 0.3, 0.2)
    for goal, link in (
        (hands(0.7, 0, 0.3), None),
        (hands(0.6, 0.1, 0.4), None),
        (both[HANDS[0]], HANDS[0]),
        (both[HANDS[1]], HANDS[1]),
    ):
        plan = baxter.plan(start, goal, world, link=link, keep=keep)
        assert plan, str(plan)
        assert plan.certified
        if link is not None:
            assert all(np.allclose(baxter.forward_kinematics(plan.path[-1], link=hand), T, atol=2e-4) for hand, T in both.items())
        assert not baxter.in_collision(plan.at(np.linspace(0, 1, 5001)), world).any()
        for a, b in zip(plan.path[:-1], plan.path[1:], strict=True):
            n = int(np.ceil(np.abs(b - a).max() / _APART)) + 1
            for q in a + np.linspace(0, 1, n)[:, None] * (b - a):
                poses = peer.link_poses(q)
                off = np.linalg.inv(held) @ np.linalg.inv(poses[left]) @ poses[right]
                assert (np.abs(off[:3, 3]) <= 1e-4).all()
                assert np.linalg.norm(pin.log3(off[:3, :3])) <= 1e-3
                up = T_0[:3, :3].T[:, 2]
                assert poses[left][2, :3] @ up >= np.cos(np.radians(15))
