"""``robot.on_gpu().plan_many`` against the CPU, field by field: on a GPU, or with simulated threads."""

import os
from unittest import mock

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import robots
import ulna

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"
BUDGET = {"max_checks": 3 if SIMULATED else 10_000}  # beside the simulator the CPU plans in plain Python
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)


@pytest.fixture(scope="module")
def world():
    return beside_a_post(0.35)


def beside_a_post(x):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.2)), ulna.pose((x, 0.0, 0.6)))
    return world


def turned(panda, by):
    """The home configuration beside the post, and with every joint moved a little more."""
    q = panda.home + 0.01
    q[0] += by
    return q


def same_plans(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        for name in ("status", "certified", "effort", "escaped", "escape", "goal", "moved", "length", "clearance"):
            assert getattr(one, name) == getattr(other, name), name
        assert str(one) == str(other)
        assert (one.path.tobytes(), one.path.shape) == (other.path.tobytes(), other.path.shape)
        assert not one.path.flags.writeable
        assert (one._searched is None) == (other._searched is None)
        if one:
            same_problems(one._searched, other._searched)


def same_problems(one, other):
    for name in ("start", "goals", "goal_index"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), strict=True)
    assert (one.certify, one.seed, one.n_searches) == (other.certify, other.seed, other.n_searches)
    (space, *rest), (expected, *others) = one.motion, other.motion
    assert space.table.tobytes() == expected.table.tobytes()
    assert (space.moving == expected.moving).all()
    assert rest[0] is others[0]
    assert all(each is None or each.names == others[1].names for each in rest[1:2])
    assert rest[2:] == others[2:]


def planned(panda, *given, **options):
    """The plans of both, and the problems that the CPU planned for the GPU, in any order."""
    on_gpu, plan, asked = panda.on_gpu(), type(panda).plan, []

    def counted(robot, q_start, goal, *rest, **named):
        asked.append((*q_start, *goal))
        return plan(robot, q_start, goal, *rest, **named)

    with mock.patch.object(type(panda), "plan", counted):
        found = on_gpu.plan_many(*given, **options)
    same_plans(found, panda.plan_many(*given, **options))
    return found, asked


def test_free_and_blocked_pairs_and_bad_ends_in_one_batch(panda, world):
    left, right, touching, beyond = (turned(panda, by) for by in (0.8, -0.8, 0.0, 0.8))
    beyond[1] = 5.0
    one_joint = left.copy()
    one_joint[3] += 0.1
    starts = np.array([left, left, touching, right, beyond, left, left])
    goals = np.array([left + 0.05, right, right, right - 0.05, left + 0.05, one_joint, left])
    assert panda.in_collision(touching, world)
    found, asked = planned(panda, starts, goals, world, seed=3, **BUDGET)
    assert [each.status for each in found][2:5] == ["start in collision", "solved", "start beyond limits"]
    problems = np.hstack([starts, goals])
    assert sorted(asked) == sorted(map(tuple, problems[[1, 2, 4, 5, 6]])), "the GPU planned rows 0 and 3"


def test_the_clearance_of_an_edge_is_certified(panda):
    world = beside_a_post(0.5)
    start, goal = turned(panda, 0.3), turned(panda, -0.3) + 0.01
    near = float(panda.signed_distance(0.5 * (start + goal), world, self_collision=False))
    ends = panda.signed_distance(np.array([start, goal]), world, self_collision=False)
    assert ends.min() > near + 0.003
    for clearance, by_cpu in ((near - 0.003, 0), (near + 0.002, 1)):
        found, asked = planned(panda, start, goal[None], world, clearance=clearance, max_checks=1)
        assert (bool(found[0]), len(asked)) == (not by_cpu, by_cpu)


def test_a_plan_goes_on_as_the_cpus(panda, world):
    start, goal = turned(panda, 0.8), turned(panda, 0.8) + 0.02
    (found,), asked = planned(panda, start, goal[None], world)
    assert asked == []
    (expected,) = panda.plan_many(start, goal[None], world)
    motion, other = (each.trajectory(acceleration=5.0) for each in (found, expected))
    assert motion.duration == other.duration
    np.testing.assert_array_equal(motion.q, other.q)


@pytest.mark.parametrize("options", [{"held": ["panda_joint1"]}, {"escape": True}, {"certify": False}, {"group": None}], ids=str)
def test_other_options_leave_all_to_the_cpu(panda, options):
    start = turned(panda, 0.8)
    goal = start + 0.02
    if "held" in options:
        goal[0] = start[0]
    assert len(planned(panda, start, goal[None], **options)[1]) == 1


def test_poses_and_many_worlds_are_left_to_the_cpu(panda, world):
    start = turned(panda, 0.8)
    with mock.patch.object(type(panda), "plan", lambda *given, **_: given):
        T = panda.forward_kinematics(start)
        assert len(panda.on_gpu().plan_many(start, T[None], world)) == 1
        assert len(panda.on_gpu().plan_many(start, [start + 0.1, start + 0.2], [world, None])) == 2
    assert panda.on_gpu().plan_many(start, np.empty((0, 7)), world) == ()


def test_joints_without_limits_are_left_to_the_cpu():
    ur5 = ulna.Robot.from_dh(robots.UR5, convention="standard")
    with mock.patch.object(type(ur5), "plan", lambda *given, **_: given):
        assert len(ur5.on_gpu().plan_many(ur5.home, ur5.home[None] + 0.1)) == 1


def test_progress_and_errors_name_the_rows_of_the_input(panda):
    start, told = turned(panda, 0.8), []
    goals = np.array([start + 0.01, start + 0.02])
    panda.on_gpu().plan_many(start, goals, progress=lambda done, total: told.append((done, total)))
    assert sorted(told) == [(1, 2), (2, 2)]
    goals[1, 3] = 9.0
    with pytest.raises(ulna.InputError, match="row 1: goal"):
        panda.on_gpu().plan_many(start, goals)
    with pytest.raises(ulna.InputError, match="clearance"):
        panda.on_gpu().plan_many(start, goals, clearance=-1.0)
