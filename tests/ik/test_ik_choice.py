"""The best of several solutions: nearest, in the middle of the ranges, free to move, and clear of what stands in the way."""

from dataclasses import replace

import numpy as np
import pytest

import robots
import ulna
from ulna import InputError, Robot
from ulna.collision.allowed import AllowedCollisions
from ulna.description.robot_description import Body
from ulna.ik.search.ranking import CollisionFilter

N = 200


@pytest.fixture(scope="module")
def targets(panda):
    return panda.forward_kinematics(np.random.default_rng(31).uniform(panda.lower, panda.upper, (N, 7)))


def from_mid_range(panda, q):
    return (((q - (panda.lower + panda.upper) / 2) / (panda.upper - panda.lower)) ** 2).mean(axis=1)


def volume(panda, q):
    return np.sqrt([max(np.linalg.det(J @ J.T), 0) for J in panda.jacobian(q)])


MEASURES = {
    "nearest": lambda panda, q: np.abs(q - panda.home).max(axis=1),
    "mid_range": from_mid_range,
    "manipulability": lambda panda, q: -volume(panda, q),
}


@pytest.mark.parametrize("rank", MEASURES)
def test_the_first_in_rank_is_no_worse_than_any_and_mostly_better(panda, targets, rank):
    ranked, plain = panda.inverse_kinematics(targets, rank=rank), panda.inverse_kinematics(targets)
    assert ranked.success.all()
    np.testing.assert_allclose(panda.forward_kinematics(ranked.q), targets, rtol=0, atol=2.1e-5)
    gain = MEASURES[rank](panda, plain.q) - MEASURES[rank](panda, ranked.q)
    assert (gain > -1e-9).mean() > 0.97
    assert (gain > 1e-3).mean() > (0.15 if rank == "nearest" else 0.4)


@pytest.mark.parametrize("rank", MEASURES)
def test_of_two_elbows_the_better_is_taken(rank):
    """A planar arm has just two: brute force is to look at both."""
    arm = Robot.from_dh(
        [(0, 0, 0, 0), (1.0, 0, 0, 0), (0.6, 0, 0, 0)],
        joint_types=["revolute", "revolute", "fixed"],
        limits=[(-2.5, 1.5), (-2.9, 2.0)],
    )
    rng, both = np.random.default_rng(5), 0
    for _ in range(60):
        q = rng.uniform(arm.lower, arm.upper)
        along = np.arctan2(0.6 * np.sin(q[1]), 1 + 0.6 * np.cos(q[1]))
        elbows = np.array([q, [q[0] + 2 * along, -q[1]]])
        elbows = elbows[((elbows >= arm.lower) & (elbows <= arm.upper)).all(axis=1)]
        cost = {
            "nearest": np.abs(elbows).max(axis=1),
            "mid_range": from_mid_range(arm, elbows),
            "manipulability": np.zeros(len(elbows)),  # the same for both
        }[rank]
        result = arm.inverse_kinematics(arm.forward_kinematics(q), q_seed=np.zeros(2), task="position", rank=rank)
        assert result.success
        best = cost[np.abs(elbows - result.q).max(axis=1).argmin()]
        assert best <= cost.min() + 1e-4
        both += len(elbows)
    assert both > 90, "mostly there were two"


# ---- obstacles


@pytest.fixture(scope="module")
def world():
    world = ulna.World()
    world.add("crate", ulna.Box((0.4, 0.4, 0.4)), ulna.pose((0.4, 0, 0.5)))
    world.add("wall", ulna.Box((0.1, 2, 2)), ulna.pose((-0.5, 0, 0.5)))
    return world


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"rank": "mid_range"},
        {"task": "position"},
        {"rank": "clearance"},
    ],
    ids=str,
)
def test_what_is_found_in_a_world_hits_nothing_and_what_is_not_names_what_it_hits(panda, world, targets, options):
    free = panda.inverse_kinematics(targets, task=options.get("task", "pose"))
    result = panda.inverse_kinematics(targets, world=world, **options)
    assert panda.in_collision(free.q, world).any(), "otherwise nothing would be proved"
    assert not panda.in_collision(result.q[result.success], world).any()
    assert result.success.mean() > 0.3
    for k in np.flatnonzero(~result.success):
        assert result.status[k] == "in collision"
        assert panda.in_collision(result.q[k], world)
        report = panda.check_collision(result.q[k], world)
        assert set(result.collisions[k]) == {(pair.name_a, pair.name_b) for pair in report.pairs}
        position = np.linalg.norm((panda.forward_kinematics(result.q[k]) - targets[k])[:3, 3])
        assert result.position_error[k] == pytest.approx(position, abs=1e-12)
    assert not any(result.collisions[k] for k in np.flatnonzero(result.success))


def test_one_target_in_a_world_says_what_hits_what(panda, world):
    inside = ulna.pose((0.4, 0, 0.5), (np.pi, 0, 0))
    result = panda.inverse_kinematics(inside, world=world)
    assert result.status == "in collision"
    assert "hits crate" in str(result)
    assert "crate" in {name for _, name in result.collisions}


@pytest.mark.parametrize("side", [1, -1])
def test_the_elbow_with_the_greater_clearance_from_the_world_is_taken_however_near_the_arm_is_to_itself(side):
    """A post beside the arm, off the way of both elbows; the arm's own bars are nearer to each other."""
    bar = Body("bar", ulna.Capsule(0.02, 0.6), ulna.pose((0.5, 0, 0), (0, np.pi / 2, 0)))
    rows = [(0, 0, 0, 0), (1.0, 0, 0, 0), (1.0, 0, 0, 0)]
    plain = Robot.from_dh(rows, joint_types=["revolute", "revolute", "fixed"], limits=[(-3, 3)] * 2).description
    links = tuple(replace(link, collisions=(bar,)) if link.name in {"link1", "link2"} else link for link in plain.links)
    arm = Robot(replace(plain, links=links)).with_allowed_collisions(AllowedCollisions(()))
    world = ulna.World()
    world.add("post", ulna.Sphere(0.1), ulna.pose((0.7, 1.5 * side, 0)))
    elbows = np.array([[0.8, -1.6], [-0.8, 1.6]])
    clearance = arm.signed_distance(elbows, world, self_collision=False)
    assert (arm.signed_distance(elbows) < clearance).all(), "otherwise nothing would be proved"
    for seed in range(3):
        result = arm.inverse_kinematics(
            arm.forward_kinematics(elbows[0]), task="position", world=world, rank="clearance", seed=seed
        )
        np.testing.assert_allclose(result.q, elbows[clearance.argmax()], atol=1e-4)


def worlds_of_nothing(robot):
    """Worlds that hold nothing that the robot may not touch: no distance is finite."""
    empty, unseen, all_ignored = ulna.World(), ulna.World(), ulna.World()
    unseen.add("cloud", ulna.PointCloud(np.empty((0, 3)), radius=0.01))
    all_ignored.add("crate", ulna.Box((0.4, 0.4, 0.4)), ulna.pose((0.4, 0, 0.5)), touch_links=robot.link_names)
    return {"empty": empty, "a cloud without points": unseen, "all may touch": all_ignored}


@pytest.fixture(scope="module")
def arms(panda):
    """One of seven joints, one of six with a complete closed form: a UR5 with two balls."""
    balls = [Body("ball", ulna.Sphere(0.02), np.eye(4))]
    plain = Robot.from_dh(robots.UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6).description
    links = tuple(replace(link, collisions=tuple(balls)) if link.name in {"link3", "link6"} else link for link in plain.links)
    return {"panda": panda, "ur5": Robot(replace(plain, links=links))}


@pytest.mark.parametrize("what", ["empty", "a cloud without points", "all may touch"])
@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_the_clearance_from_nothing_rejects_no_solution(arms, name, what):
    robot = arms[name]
    world, begin = worlds_of_nothing(robot)[what], robot.home + 0.3
    assert robot.signed_distance(begin, world, self_collision=False) == np.inf, "otherwise nothing would be proved"
    T = robot.forward_kinematics(begin + np.linspace(0, 0.3, 5)[:, None])
    plain, ranked = (robot.all_solutions(T[2], world=world, rank=rank) for rank in (None, "clearance"))
    assert ranked.valid.sum() == plain.valid.sum() > 0
    assert not robot.in_collision(ranked.q[ranked.valid], world).any()
    for q_start in (None, begin):
        assert robot.follow(T, q_start, world=world, rank="clearance").success
    found = robot.inverse_kinematics(T, world=world, rank="clearance")
    assert found.success.all()
    np.testing.assert_allclose(robot.forward_kinematics(found.q), T, rtol=0, atol=2.1e-5)
    assert np.isfinite(found.q).all()


def test_only_what_solves_its_target_is_looked_at(panda, world, targets, monkeypatch):
    """What no kernel has written holds whatever was in the memory."""
    empty = np.empty
    monkeypatch.setattr(np, "empty", lambda shape, dtype=float: np.full(shape, 1e300) if dtype is float else empty(shape, dtype))
    with pytest.raises(InputError, match=r"^T: has an entry that is not finite"):
        panda.inverse_kinematics(np.full((4, 4), np.nan), world=world)
    asked = []
    monkeypatch.setattr(CollisionFilter, "collides", lambda self, q: asked.append(q) or panda.in_collision(q, self.world))
    result = panda.inverse_kinematics(targets[:20], world=world)
    known = panda.forward_kinematics(np.concatenate(asked))
    apart = np.abs(known[:, None] - targets[None, :20]).max(axis=(2, 3)).min(axis=1)
    assert result.success.any()
    assert apart.max() < 3e-5


@pytest.mark.parametrize("rank", [*MEASURES, "clearance", None])
def test_a_target_that_nothing_solves_has_nothing_to_rank(panda, world, rank):
    assert not panda.inverse_kinematics(ulna.pose((5.0, 0, 0)), world=world, rank=rank, max_iterations=200).success


# ---- postures


def test_the_middle_of_the_range_is_a_posture(panda, targets):
    middle = (panda.lower + panda.upper) / 2
    by_name, by_hand = (panda.inverse_kinematics(targets[:50], posture=p) for p in ("mid_range", middle))
    assert np.array_equal(by_name.q, by_hand.q)
    plain = panda.inverse_kinematics(targets[:50])
    assert by_name.success.all()
    assert (np.linalg.norm(by_name.q - middle, axis=1) < np.linalg.norm(plain.q - middle, axis=1) + 1e-6).mean() > 0.6


@pytest.mark.parametrize("options", [{}, {"max_step": 4.0}], ids=str)
def test_no_whole_turn_of_a_joint_brings_the_nearest_nearer(rng, options):
    robot = ulna.Robot.from_dh(robots.UR5, convention="standard", limits=[(-2 * np.pi, 2 * np.pi)] * 5 + [(-1.0, 12.0)])
    q, seeds = rng.uniform(-3, 3, (60, 6)), rng.uniform(-1, 3, (60, 6))
    T = robot.forward_kinematics(q)
    result = robot.inverse_kinematics(T, seeds, rank="nearest", **options)
    found = result.success
    assert found.sum() > (10 if options else 55)
    np.testing.assert_allclose(robot.forward_kinematics(result.q)[found], T[found], atol=1e-4)
    for turn in (-2 * np.pi, 2 * np.pi):
        turned = result.q + turn
        within = (robot.lower <= turned) & (turned <= robot.upper)
        nearer = np.abs(turned - seeds) < np.abs(result.q - seeds) - 1e-9
        assert not (within & nearer)[found].any()
    alone = robot.inverse_kinematics(T[3], seeds[3], rank="nearest", **options)
    assert alone.q.tobytes() == result.q[3].tobytes()
