"""``plan.improve``: shorter paths, as certified as the plan's, with the same bits whenever it is asked for."""

import pickle

import numpy as np
import pytest

import ulna
from ulna.engine.lanes import WIDTH
from ulna.errors import InputError
from ulna.ik.time_limit import TimeLimit
from ulna.planning.entries.search_records import AORRTC
from ulna.planning.search import Search

SEEDS = range(12)
# An arm that turns without end on a slide.
TURNER = """<robot name="turner"><link name="rail"/><link name="car"/><link name="arm">
  <collision name="arm"><origin xyz="0.3 0 0"/><geometry><box size="0.5 0.05 0.05"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="car"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="car"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def ends(panda):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1, -1
    return left, right


@pytest.fixture(scope="module")
def plans(panda, world, ends):
    return [panda.plan(*ends, world, seed=seed) for seed in SEEDS]


def test_paths_become_shorter_and_stay_free(panda, world, ends, plans):
    improved = [plan.improve(1000) for plan in plans]
    for plan, better in zip(plans, improved, strict=True):
        assert better.length <= plan.length
        assert better.certified
        assert np.array_equal(better.path[[0, -1]], ends)
        assert plan.checks < better.checks
        assert not panda.in_collision(better.at(np.linspace(0, 1, 4001)), world).any()
    lengths = [plan.length for plan in plans]
    assert np.median([plan.length for plan in improved]) < 0.8 * np.median(lengths)
    assert min(plan.length for plan in improved) < min(lengths)
    assert all(better.length > np.linalg.norm(ends[1] - ends[0]) for better in improved)


def test_more_checks_never_make_a_path_longer_and_it_goes_on_from_where_it_was(plans):
    plan = plans[0]
    lengths = [plan.length]
    for _ in range(4):
        plan = plan.improve(400)
        lengths.append(plan.length)
    assert lengths == sorted(lengths, reverse=True)
    assert plan.checks <= plans[0].checks + 4 * 400 + 4 * 200  # shortening of the last path found may exceed a budget


def test_the_same_calls_give_the_same_bits(panda, world, ends, plans):
    again = panda.plan(*ends, world, seed=3).improve(100).improve(100)
    assert np.array_equal(again.path, plans[3].improve(100).improve(100).path)
    copied = pickle.loads(pickle.dumps(plans[3]))  # noqa: S301 - our own bytes
    assert np.array_equal(copied.improve(100).improve(100).path, again.path)


def test_a_straight_path_is_the_shortest(panda):
    plan = panda.plan(panda.home, panda.home + 0.1, ulna.World())
    better = plan.improve(100_000)
    assert np.array_equal(better.path, plan.path)
    assert better.checks == plan.checks


def test_a_nearer_goal_may_be_chosen(panda, world, ends):
    """Of two goals the plan may reach the far one first; what is improved may end at the other."""
    left, right = ends
    far = right.copy()
    far[5] += 1.0
    found = [panda.plan(left, [far, right], world, seed=seed).improve(2000) for seed in SEEDS]
    for plan in found:
        assert np.array_equal(plan.path[-1], (far, right)[plan.goal])
    assert {plan.goal for plan in found} == {1}


def test_the_edge_that_leads_out_of_a_contact_stays(panda, world, ends):
    touching = np.array([0.63, *panda.home[1:]])
    touching[0] = next(x for x in np.arange(1.0, 0.0, -1e-3) if panda.in_collision([x, *panda.home[1:]], world))
    plan = panda.plan(touching, ends[0] + [0, 0.5, 0, 0.5, 0, 0, 0], world, escape=True)
    assert plan.escape > 0
    better = plan.improve(500)
    assert np.array_equal(better.path[:2], plan.path[:2])
    assert better.escape == plan.escape
    assert better.length <= plan.length


def test_joints_that_turn_for_ever_may_end_whole_turns_away(rng):
    arm = ulna.load(TURNER)
    world = ulna.World()
    world.add("bar", ulna.Box((0.3, 0.02, 0.3)), ulna.pose((-0.5, 0, 0)))
    for seed in range(8):
        start, goal = rng.uniform(1.5, 2.5), -rng.uniform(1.5, 2.5)  # the short way is barred
        plan = arm.plan([0, start], [0, goal], world, seed=seed)
        better = plan.improve(300)
        assert plan
        assert better.length <= plan.length
        assert not arm.in_collision(better.at(np.linspace(0, 1, 4001)), world).any()
        turns = (better.path[-1, 1] - goal) / (2 * np.pi)
        assert abs(turns - round(turns)) < 1e-12


def test_no_path_no_budget_or_no_time_are_refused(panda, plans):
    blocked = ulna.World()
    blocked.add("ball", ulna.Sphere(3.0))
    with pytest.raises(InputError, match="plan: there is no path: start in collision"):
        panda.plan(panda.home, panda.home + 0.1, blocked).improve(10)
    for wrong in (0, -1, 1.5, True, None):
        with pytest.raises(InputError, match="max_checks"):
            plans[0].improve(wrong)
    with pytest.raises(InputError, match="time_limit"):
        plans[0].improve(10, time_limit=0)


def test_the_goal_that_is_reached_is_kept_apart_from_the_number_of_the_next_sample(panda, world, ends, plans):
    edges, goals = plans[0]._searched.motion.edges(certify=True), np.stack([ends[1], ends[1] + 0.01])
    search = Search(edges, ends[0], goals, (0, 1), skip_direct=True)
    assert search.finish(1, TimeLimit(None), shorten=False) is None
    assert search.goal == -1
    before = search.state.sample
    found = search.finish(20_000, TimeLimit(None), shorten=False)
    assert np.array_equal(found.path[-1], goals[search.goal])
    assert search.state.sample - search.state.first_sample >= search.effort.iterations > before
    assert search.state.goal == search.goal


def test_nodes_cost_what_their_way_is_long_and_a_found_path_less_than_the_bound(panda, world, ends, plans):
    searched = plans[0]._searched
    motion = searched.motion
    edges = motion.edges(certify=True)
    bound = 0.9 * plans[0].length
    below = edges.with_bound(bound, ends[0], searched.goals)
    search = Search(below, ends[0], searched.goals, (0, 1), AORRTC, skip_direct=True)
    path = search.finish(20_000, TimeLimit(None), shorten=False).path
    assert search.edges.settings[0].bound == bound
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length < bound
    for tree in (0, 1):
        n = int(search.state.nodes[tree])
        costs = search.trees.costs[tree].reshape(-1)
        nodes = search.trees.rows[tree].reshape(-1, 7, WIDTH).swapaxes(1, 2).reshape(-1, 7)
        q = nodes[:n]
        for node in range(n):
            branch = nodes[branch_of(search, tree, node)]
            assert np.isclose(costs[node], np.linalg.norm(np.diff(branch, axis=0), axis=1).sum(), atol=1e-12)
        others = ends[1 - tree]
        assert (costs[:n] + np.linalg.norm(q - others, axis=1) < bound).all()
        assert np.isinf(costs[n:]).all()


def branch_of(search, tree, node):
    """The nodes from one to its root."""
    nodes = []
    while node >= 0:
        nodes.append(node)
        node = int(search.trees.parents[tree, node])
    return nodes


def test_all_that_is_within_the_ellipsoid_is_within_the_limits_of_the_samples(plans, rng):
    space, start, goals = plans[0]._searched.motion.space, *(plans[0]._searched.start, plans[0]._searched.goals)
    distance = np.linalg.norm(goals[0] - start)
    within = space.with_bound(1.3 * distance, start, goals)
    q = rng.uniform(space.table["low"], space.table["high"], (400_000, 7))
    q = 0.5 * (start + goals[0]) + 0.3 * (q - 0.5 * (start + goals[0]))
    inside = np.linalg.norm(q - start, axis=1) + np.linalg.norm(q - goals[0], axis=1) < 1.3 * distance
    inside &= ((q >= space.table["low"]) & (q <= space.table["high"])).all(axis=1)
    assert inside.sum() > 100
    assert ((q[inside] >= within.table["low"]) & (q[inside] <= within.table["high"])).all()
    assert (within.table["high"] - within.table["low"] < space.table["high"] - space.table["low"] + 1e-15).all()
