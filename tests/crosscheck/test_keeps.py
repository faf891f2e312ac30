"""Plans that keep a constraint, judged by Pinocchio's kinematics at 64 times as many samples as a planner would test."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import Peer

_APART = 1 / 32 / 64  # [rad]


@pytest.fixture(scope="module")
def peer(panda):
    return Peer(panda, pin.buildModelFromXML(panda.to_urdf()))


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [0.5, 5.0, 15.0])
def test_no_plan_tilts_more_than_it_may_nor_leaves_its_box(panda, peer, degrees):
    world, rng = ulna.World(), np.random.default_rng(7)
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    tip, keep = (
        panda.link_names.index("panda_ee"),
        ulna.Keep.upright(within=np.radians(degrees), axis=(0, 0, 1), along=(0, 0, -1)),
    )
    inside = ulna.Keep.inside((1.4, 1.4, 0.6), ulna.pose((0, 0, 0.45)))
    poses = [ulna.pose((0.5 * np.cos(a), 0.5 * np.sin(a), 0.45), rpy=(np.pi, 0, rng.uniform(-3, 3))) for a in (-1.2, 1.2, 0.8)]
    starts = [panda.inverse_kinematics(T, panda.home, world=world).q for T in poses]
    n_solved = 0
    for q_a, q_b in zip(starts, starts[1:] + starts[:1], strict=True):
        plan = panda.plan(q_a, q_b, world, keep=(keep, inside))
        n_solved += bool(plan)
        for a, b in zip(plan.path[:-1], plan.path[1:], strict=True):
            n = int(np.ceil(np.abs(b - a).max() / _APART)) + 1
            for q in a + np.linspace(0, 1, n)[:, None] * (b - a):
                T = peer.link_poses(q)[tip]
                assert np.hypot(T[0, 2], T[1, 2]) <= np.sin(np.radians(degrees))
                assert T[2, 2] < 0
                assert (np.abs(T[:3, 3] - (0, 0, 0.45)) <= (0.7, 0.7, 0.3)).all()
    assert n_solved == len(starts)
