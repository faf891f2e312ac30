"""All solutions: each is one, none stands twice, and none of those that a closed form or a brute force knows is missing."""

import numpy as np
import pytest

import formulas
import robots
import ulna
from ik_methods import valid_solutions
from ulna import InputError, Robot

LINKS = (1.0, 0.6)


@pytest.fixture(scope="module")
def planar():
    return Robot.from_dh([(0, 0, 0, 0), (LINKS[0], 0, 0, 0), (LINKS[1], 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])


@pytest.fixture(scope="module")
def ur5e():
    return Robot.from_dh(robots.UR5E, convention="standard", limits=[(-2 * np.pi, 2 * np.pi)] * 6)


def distinct(found):
    """The least difference of two rows, whole turns aside."""
    apart = np.abs(found[:, None] - found[None])
    apart = np.abs(apart - 2 * np.pi * np.rint(apart / (2 * np.pi))).max(axis=-1)
    return apart[~np.eye(len(found), dtype=bool)].min(initial=np.inf)


def elbows(x, y):
    """Both configurations of the planar arm, by the law of cosines (Lynch and Park, Modern Robotics, section 6.1.1)."""
    bend = np.arccos((x * x + y * y - LINKS[0] ** 2 - LINKS[1] ** 2) / (2 * LINKS[0] * LINKS[1]))
    for elbow in (bend, -bend):
        shoulder = np.arctan2(y, x) - np.arctan2(LINKS[1] * np.sin(elbow), LINKS[0] + LINKS[1] * np.cos(elbow))
        yield np.arctan2(np.sin(shoulder), np.cos(shoulder)), elbow


@pytest.mark.parametrize("place", [(1.2, 0.3), (-0.7, 0.2), (0.0, -0.5), (0.41, 0.0), (1.59, 0.0)])
def test_a_planar_arm_has_the_two_elbows_of_the_law_of_cosines(planar, place):
    found = valid_solutions(planar, ulna.pose((*place, 0)), task="position")
    known = np.array(sorted(elbows(*place)))
    order = np.lexsort(np.rint(found.T[::-1] * 1e6))
    np.testing.assert_allclose(found[order], known, atol=1e-6)


def test_a_target_at_the_end_of_the_reach_has_one_solution_and_beyond_it_none(planar):
    at_end = planar.all_solutions(ulna.pose((sum(LINKS), 0, 0)), task="position")
    assert at_end.proof == "complete but for coinciding branches"
    np.testing.assert_allclose(at_end.q[at_end.valid], 0.0, atol=1e-6)
    beyond = planar.all_solutions(ulna.pose((sum(LINKS) + 1e-3, 0, 0)), task="position")
    assert not beyond
    assert str(beyond.reason) == "the closed form proves that there is no solution"


def test_every_solution_of_a_ur5e_is_one_and_none_is_repeated(ur5e):
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (20, 6))
    for x, T in zip(q, ur5e.forward_kinematics(q), strict=True):
        found = valid_solutions(ur5e, T)
        assert len(found) in {2, 4, 6, 8}
        assert distinct(found) > 1e-3
        assert np.abs([formulas.link_pose(ur5e.description, y, "link6") - T for y in found]).max() < 1e-8
        turns = (found - x) / (2 * np.pi)
        assert (np.abs(turns - np.rint(turns)).max(axis=1) < 1e-6).any(), "the configuration that made the target is one"


def test_limits_leave_out_the_branches_beyond_them(ur5e):
    T = ur5e.forward_kinematics([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])
    everywhere = valid_solutions(ur5e, T)
    limits = np.column_stack([np.full(6, -np.pi), np.full(6, np.pi)])
    limits[2] = 0.0, np.pi
    narrow = valid_solutions(Robot.from_dh(robots.UR5E, convention="standard", limits=limits), T)
    elbow = everywhere[:, 2] - 2 * np.pi * np.rint(everywhere[:, 2] / (2 * np.pi))
    assert len(everywhere) == 8
    assert len(narrow) == np.count_nonzero(elbow >= 0) == 4
    assert (narrow[:, 2] >= 0).all()


def test_the_nearest_to_the_seed_comes_first(ur5e):
    T = ur5e.forward_kinematics([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])
    for seed in valid_solutions(ur5e, T):
        np.testing.assert_allclose(valid_solutions(ur5e, T, q_seed=seed, rank="nearest")[0], seed, atol=1e-6)


@pytest.mark.parametrize("n", [1, 5, 16])
def test_a_redundant_arm_gets_a_spread_of_as_many_as_are_asked_for(panda, n):
    T = panda.forward_kinematics(panda.home)
    found = valid_solutions(panda, T, task="position", n_samples=n)
    assert found.shape == (n, 7)
    np.testing.assert_allclose(panda.forward_kinematics(found)[:, :3, 3], np.broadcast_to(T[:3, 3], (n, 3)), atol=1e-8)
    assert ((found >= panda.lower) & (found <= panda.upper)).all()
    assert distinct(found) > 0.05


def test_the_same_seed_gives_the_same_bits(panda):
    T = panda.forward_kinematics(panda.home)
    first, again = (valid_solutions(panda, T, task="position", seed=4) for _ in range(2))
    assert first.tobytes() == again.tobytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"T": np.diag([1.0, 1.0, 2.0, 1.0])}, "T"),
        ({"T": np.eye(4), "q_seed": np.zeros((2, 7))}, "q_seed: shape"),
        ({"T": np.eye(4), "n_samples": -1}, "n_samples"),
        ({"T": np.eye(4), "task": "posed"}, "task"),
    ],
)
def test_what_cannot_be_is_refused_by_name(panda, arguments, message):
    with pytest.raises(InputError, match=message):
        valid_solutions(panda, **arguments)


@pytest.mark.parametrize("width", [0.05, 0.2, 1.0])
def test_a_joint_that_turns_about_the_point_asked_for_makes_a_continuum(width):
    """The last joint does not move the tip: the task asks three numbers of three joints, and two of them give these."""
    rows = [(0, 0.3, 0, 0), (0.4, 0, np.pi / 2, 0), (0.5, 0, 0, 0)]
    arm = Robot.from_dh(rows, limits=[(-3, 3), (-3, 3), (-width, width)])
    T = arm.forward_kinematics([0.3, 0.4, 0.01])
    for angle in (-0.9 * width, 0.0, 0.5 * width):
        found = arm.all_solutions(T, task="position", q_seed=[0.0, 0.0, angle])
        assert found.proof == "continuum"
        (q,) = found.q[found.valid]
        np.testing.assert_allclose(q, [0.3, 0.4, angle], atol=1e-8)
