"""Budgets that end every search, starts that are left, slides without limits, and arguments that cannot be taken."""

import _thread
import threading
import time

import numpy as np
import pytest

import ulna
from ulna.collision.allowed import AllowedCollisions
from ulna.errors import InputError, UnknownNameError
from ulna.planning.motion import Motion
from ulna.planning.space import make_space

GANTRY = """<robot name="gantry"><link name="base"/>{links}{joints}</robot>"""
CUBE = '<collision name="cube"><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'


def gantry(limit):
    """A cube of 0.1 m on two slides, x and y."""
    links = f'<link name="car"/><link name="cube">{CUBE}</link>'
    joints = "".join(
        f'<joint name="{axis}" type="prismatic"><parent link="{parent}"/><child link="{child}"/><axis xyz="{xyz}"/>'
        f'<limit lower="{-limit}" upper="{limit}" velocity="1" effort="1"/></joint>'
        for axis, parent, child, xyz in (("x", "base", "car", "1 0 0"), ("y", "car", "cube", "0 1 0"))
    )
    return ulna.load(GANTRY.format(links=links, joints=joints))


def snake(n, shape="box", limit=6.28):
    """An arm of n links of 0.3 m, whose links may touch each other."""
    boxes = '<geometry><box size="0.2 0.05 0.05"/></geometry>', '<geometry><cylinder radius="0.03" length="0.25"/></geometry>'
    turned = 'rpy="0 1.5707963 0"' if shape == "cylinder" else ""
    body = f'<collision><origin xyz="0.15 0 0" {turned}/>{boxes[shape == "cylinder"]}</collision>'
    links = "".join(f'<link name="l{k}">{body if k else ""}</link>' for k in range(n + 1))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/><origin xyz="{0.3 * (k > 1)} 0 0"/>'
        f'<axis xyz="{"0 0 1" if k % 2 else "0 1 0"}"/><limit lower="{-limit}" upper="{limit}" velocity="1" effort="1"/></joint>'
        for k in range(1, n + 1)
    )
    robot = ulna.load(f'<robot name="snake">{links}{joints}</robot>')
    return robot.with_allowed_collisions([(a, b) for i, a in enumerate(robot.link_names) for b in robot.link_names[:i]])


def shut_in(robot, n):
    """Slabs all along the stretched arm, and a free configuration outside them."""
    world = ulna.World()
    for name, extents, xyz in (
        ("left", (0.3 * n + 0.3, 0.01, 0.2), (0.15 * n, 0.05, 0)),
        ("right", (0.3 * n + 0.3, 0.01, 0.2), (0.15 * n, -0.05, 0)),
        ("above", (0.3 * n + 0.3, 0.2, 0.01), (0.15 * n, 0, 0.06)),
        ("below", (0.3 * n + 0.3, 0.2, 0.01), (0.15 * n, 0, -0.06)),
    ):
        world.add(name, ulna.Box(extents), ulna.pose(xyz))
    return world, next(q for q in robot.random(20_000, seed=1) if not robot.in_collision(q, world))


@pytest.mark.parametrize("n", [7, 12])
def test_a_search_that_gets_nowhere_ends_with_its_budget(n):
    robot = snake(n)
    world, outside = shut_in(robot, n)
    plan = robot.plan(np.zeros(n), outside, world, max_checks=3000)
    assert plan.status == "budget spent"
    assert plan.checks <= 3000 + 1


def test_a_search_with_no_joint_to_move_ends_with_its_budget():
    world = ulna.World()
    world.add("wall", ulna.Box((1, 1, 1)), ulna.pose((0.55 + 3e-12, 0, 0)))  # not in contact, but no certificate is that exact
    robot = gantry(1.0)
    assert not robot.in_collision([0, 0], world)
    assert robot.plan([0, 0], [0, 0], world, held=["x", "y"], max_checks=1000).status == "budget spent"


@pytest.mark.slow
def test_one_step_of_a_tree_keeps_within_the_budget_and_within_memory():
    world = ulna.World()
    world.add("wall", ulna.Box((0.01, 9e5, 1)))
    plan = gantry(9e5).plan([-1, 0], [8e5, 3.0], world, max_checks=2000)
    assert plan.checks <= 2001


@pytest.mark.parametrize("limit", [5.0, 1e5, 1e16])
def test_slides_without_limits_go_round_an_obstacle(limit):
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 0.3, 1)))
    plan = gantry(limit).plan([-0.5, 0], [0.5, 0], world, max_checks=5000)
    assert plan.certified
    assert len(plan.path) > 2


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_the_plans_of_all_threads():
    robot = snake(6, limit=3.0)
    world, outside = shut_in(robot, 6)
    pressed = []

    def press():
        pressed.append(time.perf_counter())
        _thread.interrupt_main()

    timer = threading.Timer(0.3, press)
    timer.start()
    with pytest.raises(KeyboardInterrupt), ulna.threads(2):
        robot.plan_many(np.zeros(6), np.tile(outside, (4, 1)), world, max_checks=10**9)
    timer.join()
    assert pressed  # with a thread that goes on, this would take hours


def test_held_joints_may_come_from_an_iterator(panda):
    goals = panda.home + np.array([[0, 0, 0, 0.1, 0, 0, 0], [0.5, 0, 0, 0.1, 0, 0, 0]])
    with pytest.raises(InputError, match="row 1: goal"):
        panda.plan_many(panda.home, goals, held=iter(["panda_joint1"]))


# ---- a start that touches ---------------------------------------------------------------------------------------------------


def test_a_start_in_exact_contact_is_left_by_an_edge_of_its_own():
    robot, world = gantry(2.0), ulna.World()
    world.add("wall", ulna.Box((1, 1, 1)), ulna.pose((0.55, 0, 0)))
    assert robot.in_collision([0, 0], world)
    plan = robot.plan([0, 0], [-1, 0], world, escape=True)
    assert plan.escaped
    assert plan.escape == 0.0
    assert np.array_equal(plan.path[0], [0, 0])
    assert not plan.trajectory(acceleration=1.0).certified


def test_a_way_out_that_touches_something_else_is_not_taken():
    robot, world = gantry(2.0), ulna.World()
    world.add("wall", ulna.Box((1, 1, 1)), ulna.pose((0.5495, 0, 0)))  # 0.5 mm deep
    world.add("foil", ulna.Box((1e-4, 1, 1)), ulna.pose((-0.0502, 0, 0)))  # behind the cube
    assert robot.plan([0, 0], [-1, 0], world, escape=True).status == "start in collision"


def test_the_depth_counts_the_clearance_to_the_world_and_contact_within_the_robot():
    links = f'<link name="car"/><link name="cube">{CUBE}</link>'
    block = '<collision name="block"><origin xyz="-0.03 0.1025 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    joints = "".join(
        f'<joint name="{axis}" type="prismatic"><parent link="{parent}"/><child link="{child}"/><axis xyz="{xyz}"/>'
        '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
        for axis, parent, child, xyz in (("x", "base", "car", "1 0 0"), ("y", "car", "cube", "0 1 0"))
    )
    text = GANTRY.format(links=links, joints=joints).replace('<link name="base"/>', f'<link name="base">{block}</link>')
    robot = ulna.load(text).with_allowed_collisions(AllowedCollisions(()))
    world = ulna.World()
    world.add("wall", ulna.Box((1, 1, 1)), ulna.pose((0.55 + 0.019, 0, 0)))
    plan = robot.plan([0, 0], [-1, 0], world, clearance=0.02, escape=True)
    assert plan.escaped
    assert plan.escape == pytest.approx(1e-3)
    assert plan.path[1, 0] < -1e-3


# ---- edges ------------------------------------------------------------------------------------------------------------------


def test_edges_that_are_clear_by_centimeters_are_not_refused(rng):
    """Cylinders, whose distance is searched for: a crude bound of it must not be taken for contact."""
    robot, refused, looked_at = snake(6, "cylinder", 2.5), 0, 0
    for _ in range(30):
        world = ulna.World()
        for k in range(10):
            T = ulna.pose(rng.normal(size=3) * 0.8, rng.uniform(-3, 3, 3))
            world.add(f"rod {k}", ulna.Cylinder(0.06, 0.5), T)
        starts = robot.random(200, seed=int(rng.integers(1000)))
        starts = starts[~robot.in_collision(starts, world)][:12]
        ends = np.clip(starts + rng.normal(size=starts.shape) * 0.4, -2.5, 2.5)
        for a, b in zip(starts, ends, strict=True):
            along = a + np.linspace(0, 1, 200)[:, None] * (b - a)
            if robot.signed_distance(along, world).min() < 0.02:
                continue
            looked_at += 1
            space = make_space(robot.tree, np.vstack([a, b]), np.zeros(6, dtype=bool))
            refused += not Motion(space, robot._checker, world, 0.0).is_free(np.vstack([a, b]), np.zeros((1, 6)))
    assert looked_at > 100
    assert refused == 0


# ---- times ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.5, 0.5 * (1 - 1e-6), 0.5 * (1 - 1e-9), 0.5 * (1 - 1e-12)])
def test_roundings_that_meet_keep_within_the_acceleration(share):
    robot = gantry(5.0)
    world = ulna.World()
    plan = robot.plan([0, 0], [2, 1], world)
    object.__setattr__(plan, "path", np.array([[0, 0], [1, 0], [1, 1], [2, 1.0]]))
    plan.__dict__.pop("_lengths", None)
    edge = robot.plan([0, 0], [1, 0], world).length
    motion = plan.trajectory(acceleration=5.0, blend=share * edge)
    between = (motion.times[1:] + motion.times[:-1]) / 2
    assert np.abs(motion.at(np.concatenate([motion.times, between])).qdd).max() <= 5.0


def test_outside_its_times_a_motion_rests(panda):
    motion = panda.plan(panda.home, panda.home + 0.1).trajectory(acceleration=5.0)
    for t in (-1.0, motion.duration + 1.0):
        assert not motion.at(t).qd.any()
        assert not motion.at(t).qdd.any()


@pytest.mark.filterwarnings("error")
def test_a_jerk_limit_with_joints_that_rest_warns_of_nothing(panda):
    motion = panda.plan(panda.home, panda.home + np.eye(7)[0] * 0.3).trajectory(acceleration=5.0, jerk=50.0)
    assert np.isfinite(motion.q).all()


def test_infinite_limits_are_refused_but_for_the_velocity(panda):
    plan = panda.plan(panda.home, panda.home + 0.1)
    assert plan.trajectory(acceleration=5.0, velocity=np.inf).duration > 0
    for name, wrong in (("acceleration", {"acceleration": np.inf}), ("jerk", {"acceleration": 1.0, "jerk": np.inf})):
        with pytest.raises(InputError, match=f"{name}: inf"):
            plan.trajectory(**wrong)
    with pytest.raises(InputError, match="acceleration"):
        plan.trajectory(acceleration=1e300)


# ---- arguments --------------------------------------------------------------------------------------------------------------


def test_unknown_names_and_empty_goals_are_refused(panda, tmp_path):
    with pytest.raises(UnknownNameError, match="nope"):
        panda.plan(panda.home, panda.home + 0.1, link="nope")
    with pytest.raises(InputError, match="task"):
        panda.plan(panda.home, panda.home + 0.1, task="nope")
    with pytest.raises(InputError, match="goal"):
        panda.plan(panda.home, np.zeros((0, 4, 4)))
    motion = panda.plan(panda.home, panda.home + 0.1).trajectory(acceleration=5.0)
    with pytest.raises(InputError, match="period"):
        motion.to_csv(tmp_path / "a.csv", period="x")


def test_a_link_that_no_joint_moves_is_reached_or_not(panda):
    there = panda.forward_kinematics(panda.home, link=panda.base)
    assert panda.plan(panda.home, there, link=panda.base)
    assert panda.plan(panda.home, there @ ulna.pose((0.1, 0, 0)), link=panda.base).status == "goal unreachable"


@pytest.mark.parametrize("clearance", [0.1, 0.2])
def test_the_reason_of_a_start_too_near_names_the_object_first_by_its_distance_and_no_pair_of_the_robot(panda, clearance):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.05), ulna.pose((0.45, 0.0, 0.42)))
    distance = panda.signed_distance(panda.home, world, self_collision=False)
    assert 0 < distance < clearance
    plan = panda.plan(panda.home, panda.home + 0.1, world, clearance=clearance)
    assert plan.status == "start in collision"
    first = plan.reason.data.pairs[0]
    assert (first.name_b, first.signed_distance) == ("ball", pytest.approx(distance))
    assert {pair.name_b for pair in plan.reason.data.pairs} == {"ball"}
    assert f"is {distance * 1e3:.3g} mm from ball, nearer than {clearance * 1e3:.3g} mm" in str(plan)
    assert "deep" not in str(plan)
