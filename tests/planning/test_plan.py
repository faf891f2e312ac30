"""Plans: a path that is called certified touches nothing at any sample, and where there is none the reason is the right one."""

import _thread
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import ulna
from ulna.errors import InputError, UnknownNameError
from ulna.planning import search as of_search
from ulna.planning import slices

# A cube of 0.2 at the end of an arm of 0.5 that turns without end on a slide; what it holds turns the other way.
TURNER = """<robot name="turner">
  <link name="rail"/><link name="car"><collision name="car"><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="cube">
    <collision name="cube"><origin xyz="0.5 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="held">
    <collision name="tool"><origin xyz="0.2 0 0.5"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="car"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="car"/><child link="cube"/><axis xyz="0 0 1"/></joint>
  <joint name="follow" type="continuous"><parent link="cube"/><child link="held"/><axis xyz="0 0 1"/>
    <mimic joint="turn" multiplier="-1"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def turner():
    return ulna.load(TURNER)


@pytest.fixture(scope="module")
def post(world):
    """A post in front of the Panda, and a shelf above."""
    return world


def sides(panda, angle=1.0):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = angle, -angle
    return left, right


def samples_of(plan, n=20_001):
    return plan.at(np.linspace(0, 1, n))


def random_problems(robot, rng, n):
    """Worlds of boxes, with a free start and a free goal each."""
    for _ in range(n):
        world = ulna.World()
        for k in range(8):
            way = rng.normal(size=3)
            T = ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.5, 0.9), rng.uniform(-3, 3, 3))
            world.add(f"{k}", ulna.Box(rng.uniform(0.05, 0.25, 3)), T)
        q = robot.random(400, seed=rng)
        free = q[~robot.in_collision(q, world)]
        yield world, free[0], free[1]


@pytest.mark.parametrize("shorten", [True, False])
def test_no_sample_of_a_certified_path_touches(panda, rng, shorten):
    solved = 0
    for world, start, goal in random_problems(panda, rng, 12):
        plan = panda.plan(start, goal, world, shorten=shorten, max_checks=20_000)
        if plan:
            solved += 1
            assert plan.certified
            assert np.array_equal(plan.path[0], start)
            assert np.array_equal(plan.path[-1], goal)
            assert (plan.path >= panda.lower).all()
            assert (plan.path <= panda.upper).all()
            assert not panda.in_collision(samples_of(plan), world).any()
            assert not panda.edge_in_collision(plan.path[:-1], plan.path[1:], world).in_collision.any()
    assert solved >= 6


def test_shortening_makes_a_path_shorter_and_no_path_is_shorter_than_the_straight_line(panda, rng):
    lengths = []
    for world, start, goal in random_problems(panda, rng, 8):
        long, short = (panda.plan(start, goal, world, shorten=shorten, max_checks=20_000) for shorten in (False, True))
        if long:
            assert np.linalg.norm(goal - start) - 1e-9 <= short.length <= long.length + 1e-9
            lengths.append((long.length, short.length))
    assert np.mean(lengths, axis=0)[1] < 0.9 * np.mean(lengths, axis=0)[0]


def test_the_same_call_gives_the_same_bits_in_threads_and_in_slices(panda, rng, monkeypatch):
    world, start, goal = next(random_problems(panda, rng, 1))
    plan = panda.plan(start, goal, world, seed=3)
    with ThreadPoolExecutor(4) as pool:
        others = list(pool.map(lambda _: panda.plan(start, goal, world, seed=3), range(8)))
    monkeypatch.setattr(slices, "_FIRST_SLICE", 1)
    monkeypatch.setattr(slices, "_LONGEST_SLICE", -1.0)
    monkeypatch.setattr(of_search, "_FIRST_CAPACITY", 8)
    others.append(panda.plan(start, goal, world, seed=3))
    for other in others:
        assert np.array_equal(other.path, plan.path)
        assert other.effort == plan.effort
    assert not np.array_equal(panda.plan(start, goal, world, seed=4).path, plan.path)


def test_a_plan_survives_pickling(panda, post):
    plan = panda.plan(*sides(panda), post)
    other = pickle.loads(pickle.dumps(plan))  # noqa: S301
    assert np.array_equal(other.path, plan.path)
    assert not other.path.flags.writeable
    assert str(other) == str(plan)
    assert other.clearance == plan.clearance


def test_what_is_asked_of_a_plan_does_not_change_with_the_world(panda, post):
    world = post.copy()
    plan = panda.plan(*sides(panda), world)
    before = panda.signed_distance(plan.at(np.linspace(0, 1, 256)), post, self_collision=False).min()
    world.remove("post")
    assert plan.clearance == pytest.approx(before)


def test_places_along_a_plan_are_even_in_length(panda, post):
    plan = panda.plan(*sides(panda), post)
    q = plan.at(np.linspace(0, 1, 5001))
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    assert plan.length == pytest.approx(np.linalg.norm(np.diff(plan.path, axis=0), axis=1).sum())
    assert steps.max() <= plan.length / 5000 * (1 + 1e-9)
    assert np.array_equal(plan.at([0.0, 1.0]), plan.path[[0, -1]])
    with pytest.raises(InputError, match="from 0 to 1"):
        plan.at(1.1)


def test_the_goal_may_be_a_pose_or_several_and_all_branches_count(panda, post):
    left, right = sides(panda)
    T = panda.forward_kinematics(np.stack([right, left + 0.2]))
    one, two = panda.plan(left, T[0], post), panda.plan(left, T, post)
    assert one.goal == 0
    assert two.goal == 1  # the near one
    for plan, pose in ((one, T[0]), (two, T[1])):
        assert np.allclose(panda.forward_kinematics(plan.path[-1]), pose, atol=2e-5)
        assert not panda.in_collision(samples_of(plan), post).any()


def test_of_several_configurations_one_that_is_free_is_reached(panda, post):
    left, right = sides(panda)
    inside = sides(panda, 0.0)[0]
    assert panda.in_collision(inside, post)
    plan = panda.plan(left, [inside, right], post)
    assert plan.goal == 1
    assert np.array_equal(plan.path[-1], right)


def test_the_clearance_that_is_asked_for_is_kept(panda, post):
    plan = panda.plan(*sides(panda), post, clearance=0.03)
    assert plan.clearance > 0.03
    assert panda.signed_distance(samples_of(plan, 5001), post, self_collision=False).min() > 0.03


def test_a_continuous_joint_turns_the_short_way(turner):
    plan = turner.plan([0, 3.0], [0, -3.0])
    assert plan.length == pytest.approx(2 * np.pi - 6)
    assert plan.path[-1, 1] == pytest.approx(2 * np.pi - 3)


def test_where_the_short_way_is_barred_there_is_another(turner):
    world = ulna.World()
    world.add("bar", ulna.Box((20, 0.02, 0.1)), ulna.pose((-10.3, 0, 0)))  # behind the car
    assert turner.edge_in_collision([0, 2.5], [0, 2 * np.pi - 2.5], world)
    plan = turner.plan([0, 2.5], [0, -2.5], world)
    assert plan
    assert plan.path[-1] == pytest.approx([0, -2.5]) or plan.path[-1] == pytest.approx([0, 2 * np.pi - 2.5])
    assert not turner.in_collision(samples_of(plan), world).any()


def test_a_mimic_joint_and_what_is_attached_move_along(turner):
    robot = turner.with_attached("pole", ulna.Box((0.05, 0.05, 2.0)), ulna.pose((0.5, 0, 0)), link="cube")
    world = ulna.World()
    world.add("beam", ulna.Box((0.4, 0.1, 0.1)), ulna.pose((0.6, 0, -0.8)))  # in the way of the pole alone
    start, goal = [0, -0.8], [0, 0.8]
    assert not turner.edge_in_collision(start, goal, world)
    assert robot.edge_in_collision(start, goal, world)
    plan = robot.plan(start, goal, world)
    assert plan
    assert not robot.in_collision(samples_of(plan), world).any()


def test_joints_that_are_held_do_not_move(panda, post):
    left, right = sides(panda)
    plan = panda.plan(left, right, post, held=["panda_joint7", "panda_joint3"])
    assert plan
    assert (plan.path[:, [2, 6]] == left[[2, 6]]).all()
    with pytest.raises(InputError, match="held"):
        panda.plan(left, right, post, held=["panda_joint1"])
    with pytest.raises(UnknownNameError, match="joint"):
        panda.plan(left, right, post, held=["joint0"])


def test_a_link_may_touch_what_it_may_touch_and_no_other_link(panda):
    world = ulna.World()
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, 0.02)), touch_links=["panda_link0", "panda_link1"])
    left, right = sides(panda)
    assert panda.plan(left, right, world).certified
    low = right.copy()
    low[1:4] = 1.7, 0, -0.6
    assert panda.in_collision(low, world)
    plan = panda.plan(left, low, world)
    assert plan.status == "goal in collision"
    assert "floor" in str(plan)


def test_in_a_crowd_of_objects_the_tree_of_objects_is_searched(panda, rng):
    world = ulna.World()
    for k in range(100):
        way = rng.normal(size=3)
        world.add(f"{k}", ulna.Box(rng.uniform(0.01, 0.05, 3)), ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.5, 0.9)))
    q = panda.random(200, seed=1)
    start, goal = q[~panda.in_collision(q, world)][:2]
    plan = panda.plan(start, goal, world, max_checks=20_000)
    assert plan
    assert not panda.in_collision(samples_of(plan), world).any()


def test_samples_instead_of_a_certificate_are_said(panda, post):
    plan = panda.plan(*sides(panda), post, certify=False)
    assert not plan.certified
    assert "free at samples" in str(plan)


def test_the_way_out_of_a_shallow_contact_is_said_and_by_how_much(panda, post):
    left, right = sides(panda)
    t = panda.edge_in_collision(left, right, post).free_until
    touching = left + (t + 5e-3) * (right - left)
    assert panda.in_collision(touching, post)
    assert panda.plan(touching, left, post).status == "start in collision"
    plan = panda.plan(touching, left, post, escape=True)
    assert plan
    assert plan.escape == pytest.approx(-panda.signed_distance(touching, post))
    assert np.array_equal(plan.path[0], touching)
    assert not panda.edge_in_collision(plan.path[1:-1], plan.path[2:], post).in_collision.any()
    assert "touches by" in str(plan)


def test_a_start_that_touches_itself_says_what_to_do_and_that_helps(panda, post):
    folded = np.array([0.79, -0.81, -2.66, -3.02, 1.82, 3.42, 0.62])
    plan = panda.plan(folded, folded + 0.01)
    assert plan.status == "start in collision"
    assert str(plan).endswith("if these shapes touch in every configuration, allow the pairs (docs/self_collision.md)")
    assert panda.with_allowed_collisions(at=folded).plan(folded, folded + 0.01)
    inside, right = sides(panda, 0.0)[0], sides(panda)[1]
    assert "allow the pairs" not in str(panda.plan(inside, right, post))


def test_each_reason_is_the_right_one(panda, post):
    left, right = sides(panda)
    inside = sides(panda, 0.0)[0]
    beyond = left.copy()
    beyond[3] = 0.5
    plan = panda.plan(inside, right, post)
    assert (plan.status, bool(plan)) == ("start in collision", False)
    assert plan.reason.data.in_collision
    assert plan.path.shape == (0, 7)
    assert panda.plan(beyond, right, post).status == "start beyond limits"
    assert "panda_joint4" in str(panda.plan(beyond, right, post))
    assert panda.plan(left, inside, post).status == "goal in collision"
    far = panda.plan(left, ulna.pose((3, 0, 0)), post)
    assert far.status == "goal unreachable"
    assert far.reason.data.status == "unreachable"
    left, right = sides(panda, 2.0)
    T, world = panda.forward_kinematics(right), ulna.World()
    world.add("block", ulna.Box((0.2, 0.2, 0.2)), T)
    plan = panda.plan(left, T, world)
    assert plan.status == "goal in collision"
    assert "block" in str(plan)


def test_a_spent_budget_says_how_far_each_tree_came(turner):
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 20, 20)), ulna.pose((2, 0, 0)))
    plan = turner.plan([0, 0], [4, 0], world, max_checks=300)
    assert plan.status == "budget spent"
    assert plan.checks >= 300
    assert plan.effort.start_nodes > 1
    assert plan.effort.goal_nodes > 1
    assert f"{plan.effort.start_nodes} configurations were reached from the start" in str(plan)
    assert "impossible" not in str(plan)


def test_a_time_limit_ends_a_search_that_its_budget_would_not(turner):
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 20, 20)), ulna.pose((2, 0, 0)))
    assert turner.plan([0, 0], [4, 0], world, max_checks=10**15, time_limit=0.2).status == "budget spent"


@pytest.mark.usefixtures("interruptible")
def test_a_long_search_is_ended_by_an_interrupt(turner):
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 20, 20)), ulna.pose((2, 0, 0)))
    assert turner.plan([0, 0], [4, 0], world, max_checks=300).status == "budget spent"  # all is compiled or read before the timer
    timer = threading.Timer(0.3, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        turner.plan([0, 0], [4, 0], world, max_checks=10**15)
    timer.join()


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"max_checks": 0}, "max_checks"),
        ({"max_checks": 2.5}, "max_checks"),
        ({"clearance": -1e-3}, "clearance"),
        ({"clearance": np.nan}, "clearance"),
        ({"seed": -1}, "seed"),
        ({"certify": "yes"}, "certify"),
        ({"time_limit": 0}, "time_limit"),
        ({"world": "post"}, "world"),
    ],
)
def test_options_that_make_no_sense_are_refused_by_name(panda, options, argument):
    with pytest.raises(InputError, match=argument):
        panda.plan(*sides(panda), **options)


@pytest.mark.parametrize(
    ("start", "goal", "argument"),
    [
        (np.full(7, np.nan), np.zeros(7), "q_start"),
        (np.zeros((2, 7)), np.zeros(7), "q_start"),
        (None, np.full(7, np.nan), "goal"),
        (None, np.full(7, 10.0), "panda_joint1"),
        (None, np.zeros(6), "goal"),
        (None, np.zeros((0, 7)), "goal"),
        (None, np.diag([1.0, 1, 2, 1]), "T"),
    ],
)
def test_starts_and_goals_that_make_no_sense_are_refused_by_name(panda, start, goal, argument):
    with pytest.raises(InputError, match=argument):
        panda.plan(panda.home if start is None else start, goal)


def test_a_robot_without_shapes_or_joints_is_refused():
    planar = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0)])
    with pytest.raises(ulna.GeometryError, match="no collision shapes"):
        planar.plan([0, 0], [1, 1])
    shape = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    fixed = ulna.load(f'<robot name="fixed"><link name="a">{shape}</link></robot>')
    with pytest.raises(InputError, match="no moving joints"):
        fixed.plan([], [])


def test_a_start_that_is_the_goal_needs_no_motion(panda, post):
    left = sides(panda)[0]
    plan = panda.plan(left, left, post)
    assert plan.path.shape == (1, 7)
    assert plan.length == 0
    assert np.array_equal(plan.at([0.0, 0.5, 1.0]), np.stack([left] * 3))


def test_a_start_beyond_a_limit_by_rounding_is_brought_to_it(panda):
    """As a motion that ends at a limit may compute it."""
    start = panda.home.copy()
    start[0] = np.nextafter(panda.upper[0], np.inf)
    plan = panda.plan(start, panda.home)
    assert plan
    assert plan.path[0, 0] == panda.upper[0]
    start[0] += 1e-9
    assert panda.plan(start, panda.home).status == ulna.PlanStatus.START_BEYOND_LIMITS


def test_a_start_beyond_the_limits_is_led_back_within_them_by_a_free_edge(panda, post):
    start = panda.home.copy()
    start[3], start[0] = panda.upper[3] + 0.02, panda.upper[0] + 0.05
    refused = panda.plan(start, panda.home)
    assert refused.reason.data == pytest.approx({"panda_joint1": 0.05, "panda_joint4": 0.02})
    assert str(refused.reason).startswith("panda_joint1 by 0.05, panda_joint4 by 0.02; escape=True ")
    plan = panda.plan(start, panda.home, escape=True)
    assert plan.escaped
    assert plan.escape == 0.0
    assert np.array_equal(plan.path[0], start)
    assert ((plan.path[1:] >= panda.lower) & (plan.path[1:] <= panda.upper)).all()
    assert not np.any(panda.in_collision(plan.at(np.linspace(0, 1, 500))))
    assert "beyond the limits: panda_joint1 by 0.05, panda_joint4 by 0.02" in str(plan)
    better = plan.improve(200)
    assert np.array_equal(better.path[0], start)
    for limits in ({"acceleration": 4.0}, {"acceleration": 4.0, "jerk": 100.0}):
        motion = plan.trajectory(**limits)
        q = motion.at(np.linspace(0, motion.duration, 2000)).q
        excess = np.maximum(panda.lower - q, q - panda.upper).max(axis=1)
        assert excess.max() <= 0.05 + 1e-12
        assert (np.diff(np.maximum(excess, 0.0)) <= 1e-12).all()  # it only gets less


def test_a_start_beyond_the_limits_stays_refused_where_the_way_back_is_not_free(panda):
    start = panda.home.copy()
    start[0] = panda.upper[0] + 0.1
    inside = np.clip(start, panda.lower, panda.upper)
    world = ulna.World()
    world.add("wall", ulna.Box((0.02, 0.02, 0.02)), panda.forward_kinematics(0.5 * (start + inside)))
    plan = panda.plan(start, panda.home, world, escape=True)
    assert plan.status == ulna.PlanStatus.START_BEYOND_LIMITS
    assert "panda_joint1 by 0.1; the straight edge back within them is not free" in str(plan)
    held = panda.plan(start, panda.home, held=["panda_joint1"], escape=True)
    assert held.status == ulna.PlanStatus.START_BEYOND_LIMITS
    assert "panda_joint1 by 0.1, which is held" in str(held)
