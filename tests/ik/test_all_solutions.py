"""``robot.all_solutions``: shapes, limits, whole turns, seven joints, worlds and ranks, by forward kinematics and by counting."""

import copy
import dataclasses
import itertools
import pickle

import numpy as np
import pytest

import robots
import ulna
from closed_form_arms import arm_of_axes
from ik_methods import valid_solutions
from ulna import InputError, Robot, UnknownNameError
from ulna.description.robot_description import Body

TURN = 2 * np.pi
Q = np.array([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])


def ur5(limit=np.pi):
    return Robot.from_dh(robots.UR5, convention="standard", limits=[(-limit, limit)] * 6)


@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 5), (0,)])
def test_batch_axes_lead(shape):
    robot = ur5()
    T = robot.forward_kinematics(np.random.default_rng(1).uniform(-3, 3, (*shape, 6)))
    found = robot.all_solutions(T)
    assert found.q.shape == (*shape, 8, 6)
    assert found.valid.shape == found.real.shape == (*shape, 8)
    assert np.shape(found.proof) == shape
    assert (found.valid <= found.real).all()
    assert (np.isnan(found.q).any(axis=-1) == ~found.real).all()
    assert found.proof == "complete" if shape == () else (found.proof == "complete").all()


def test_solutions_cannot_be_changed_and_may_be_pickled():
    found = ur5().all_solutions(np.stack([ur5().forward_kinematics(Q)] * 2))
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.q = None  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        found.q[0] = 0
    assert pickle.loads(pickle.dumps(found)).proof.tolist() == ["complete"] * 2  # noqa: S301
    assert "8 solutions" in str(found)


def test_the_proof_of_a_batch_is_made_once_and_is_the_same_in_copies():
    robot = ur5()
    T = robot.forward_kinematics(np.stack([Q, Q, Q * [1, 1, 1, 1, 0, 1]]).reshape(3, 1, 6))
    for read_first in (False, True):
        found = robot.all_solutions(T)
        if read_first:
            assert found.proof is found.proof
        for each in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found), dataclasses.replace(found), found):  # noqa: S301
            assert each.proof.tolist() == [["complete"], ["complete"], ["continuum"]]
            assert each.q.tobytes() == found.q.tobytes()
            assert "(2 complete, 1 continuum)" in repr(each)
            with pytest.raises(ValueError, match="read-only"):
                each.proof[0] = "searched"
        with pytest.raises(dataclasses.FrozenInstanceError):
            found.proof = None  # type: ignore[misc]
    with pytest.raises(AttributeError, match="has no attribute 'proofs'"):
        _ = found.proofs  # type: ignore[attr-defined]


def test_limits_make_solutions_invalid_and_leave_them_real():
    robot = Robot.from_dh(robots.UR5, convention="standard", limits=[(-np.pi, np.pi)] * 2 + [(0, np.pi)] + [(-np.pi, np.pi)] * 3)
    found = robot.all_solutions(robot.forward_kinematics(Q))
    assert (found.real.sum(), found.valid.sum(), found.proof) == (8, 4, "complete")
    assert (found.q[found.valid][:, 2] >= 0).all()
    assert (found.q[~found.valid][:, 2] < 0).all()


def test_branches_that_coincide_are_listed_each():
    robot = ur5()
    T = robot.forward_kinematics([0.3, -1.2, 0.0, -0.7, 1.1, 0.4])  # a stretched elbow is both elbows
    found = robot.all_solutions(T)
    assert found.proof == "complete but for coinciding branches"
    stretched = found.q[found.valid & (np.abs(found.q[:, 2]) < 1e-6)]
    assert len(stretched) >= 2
    assert np.abs(stretched[0] - stretched[1]).max() < 1e-6


def test_every_whole_turn_within_the_limits_is_listed_on_request():
    """With a turn either way each joint of each of eight branches has two places: 8 * 2^6."""
    robot = ur5(TURN)
    T = robot.forward_kinematics(Q)
    found = robot.all_solutions(T, whole_turns=True)
    listed = found.q[found.valid]
    assert len(listed) == 8 * 2**6
    assert (np.abs(listed) <= TURN).all()
    np.testing.assert_allclose(robot.forward_kinematics(listed), np.broadcast_to(T, (len(listed), 4, 4)), atol=1e-12)
    places = [{x, x - TURN * np.sign(x)} for x in Q]
    for q in itertools.product(*places):
        assert np.abs(listed - q).max(axis=1).min() < 1e-9


@pytest.mark.parametrize("joint", [None, "panda_joint7", "panda_joint6"])
def test_seven_joints_have_branches_at_each_sample_of_the_one_that_is_held(panda, joint):
    T = panda.forward_kinematics(np.random.default_rng(3).uniform(panda.lower, panda.upper, (4, 7)))
    found = panda.all_solutions(T, redundancy=joint, n_samples=24)
    assert found.q.shape == (4, 8 * 24, 7)
    held = panda.joint_names.index(joint or "panda_joint7")
    assert len(np.unique(found.q[found.real][:, held].round(9))) <= 24
    assert found.real.any(axis=1).all()
    assert (found.proof == "continuum").all()
    solutions = found.q[found.valid]
    reached = panda.forward_kinematics(solutions)
    assert np.abs(reached - np.repeat(T, found.valid.sum(axis=1), axis=0)).max() < 1e-9
    assert ((solutions >= panda.lower) & (solutions <= panda.upper)).all()


def test_a_redundant_arm_out_of_reach_has_none_and_that_is_not_proved(panda):
    found = panda.all_solutions(ulna.pose((3.0, 0, 0)))
    assert (found.real.sum(), found.proof) == (0, "searched")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"T": np.eye(3)}, InputError, "T: shape"),
        ({"T": np.full((4, 4), np.nan)}, InputError, "T"),
        ({"T": np.eye(4), "redundancy": "panda_joint9"}, UnknownNameError, "panda_joint9"),
        ({"T": np.eye(4), "redundancy": ["panda_joint4"]}, InputError, "redundancy: .* the name of a joint"),
        ({"T": np.eye(4), "redundancy": "panda_joint1"}, InputError, "there is one with panda_joint4"),
        ({"T": np.eye(4), "n_samples": 0}, InputError, "n_samples"),
        ({"T": np.eye(4), "link": "nowhere"}, UnknownNameError, "nowhere"),
    ],
)
def test_what_cannot_be_is_refused_by_name(panda, arguments, error, message):
    with pytest.raises(error, match=message):
        panda.all_solutions(**arguments)


def test_a_joint_of_six_is_not_redundant():
    with pytest.raises(InputError, match="redundancy"):
        ur5().all_solutions(np.eye(4), redundancy="joint1")


def test_a_link_within_a_longer_chain_has_its_own_form(panda):
    assert panda.all_solutions(panda.forward_kinematics(panda.home, link="panda_link7"), link="panda_link7").q.shape == (128, 7)


# ---- a world, a rank


def armed(limit=np.pi):
    """A UR5 with a ball about each wrist."""
    description = ur5(limit).description
    links = tuple(
        dataclasses.replace(link, collisions=(Body(f"ball {link.name}", ulna.Sphere(0.02), np.eye(4)),))
        if link.name in {"link2", "link5"}
        else link
        for link in description.links
    )
    return Robot(dataclasses.replace(description, links=links))


@pytest.fixture(scope="module")
def blocked():
    """A robot, a target, and a world in which its elbow may not be where the first solution has it."""
    robot = armed()
    T = robot.forward_kinematics(Q)
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.05), robot.forward_kinematics(Q, link="link2"))
    return robot, T, world


def test_solutions_that_collide_are_left_out(blocked):
    robot, T, world = blocked
    every, clear = valid_solutions(robot, T), valid_solutions(robot, T, world=world)
    hits = robot.in_collision(every, world)
    assert 0 < hits.sum() < 8
    np.testing.assert_array_equal(clear, every[~hits])


def test_solutions_are_ordered_by_their_rank(blocked):
    robot, T, world = blocked
    by_clearance = valid_solutions(robot, T, world=world, rank="clearance")
    distances = robot.signed_distance(by_clearance, world, self_collision=False)
    assert (np.diff(distances) <= 0).all()
    assert len(by_clearance) == len(valid_solutions(robot, T, world=world))
    measure = robot.manipulability(valid_solutions(robot, T, rank="manipulability"))
    assert (np.diff(measure) <= 0).all()
    with pytest.raises(InputError, match="world= is needed"):
        valid_solutions(robot, T, rank="clearance")


@pytest.mark.parametrize("rank", [None, "nearest", "manipulability", "mid_range", "clearance"])
def test_the_solver_returns_the_first_in_rank_of_all_that_are_clear(blocked, rank):
    robot, T, world = blocked
    every = robot.all_solutions(T)
    clear = every.q[every.valid][~robot.in_collision(every.q[every.valid], world)]
    cost = {
        None: np.abs(clear - Q).max(axis=1),
        "nearest": np.abs(clear - Q).max(axis=1),
        "manipulability": -robot.manipulability(clear),
        "mid_range": (clear**2).mean(axis=1),
        "clearance": -robot.signed_distance(clear, world, self_collision=False),
    }[rank]
    result = robot.inverse_kinematics(T, Q, world=world, rank=rank)
    assert result.success
    assert not robot.in_collision(result.q, world)
    chosen = np.abs(clear - result.q).max(axis=1).argmin()
    assert np.abs(clear[chosen] - result.q).max() < 1e-9
    assert cost[chosen] <= cost.min() + 1e-9


def test_where_every_solution_collides_the_pairs_are_named(blocked):
    robot, T, _ = blocked
    world = ulna.World()
    world.add("wall", ulna.Sphere(2.0), ulna.pose((0, 0, 0)))
    result = robot.inverse_kinematics(T, world=world)
    assert result.status == "in collision"
    assert any("wall" in pair for pair in result.collisions)


# ---- seven joints: starts of the search


@pytest.mark.parametrize("joint", ["panda_joint7", "panda_joint4"])
def test_a_joint_held_at_an_end_moves_the_target_and_one_between_the_axes(panda, joint):
    """Either way the configuration that made a target, its held joint at one of the places, is among the solutions."""
    column, rng = panda.joint_names.index(joint), np.random.default_rng(3)
    places = panda.lower[column] + (np.arange(5) + 0.5) / 5 * (panda.upper[column] - panda.lower[column])
    q = rng.uniform(panda.lower, panda.upper, (15, 7))
    q[:, column] = np.repeat(places, 3)
    T = panda.forward_kinematics(q)
    found = panda.all_solutions(T, redundancy=joint, n_samples=5)
    held = found.q[..., column].reshape(15, 5, 8)
    assert (np.isnan(held) | np.isclose(held, places[None, :, None])).all()
    assert np.nanmin(np.abs(found.q - q[:, None]).max(axis=-1), axis=1).max() < 1e-7
    reached = panda.forward_kinematics(found.q[found.real])
    assert np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max() < 1e-9


def test_the_starts_of_an_arm_of_seven_are_solutions_within_the_limits(panda):
    from ulna.ik.options import Options
    from ulna.ik.problem import Query, make_problem
    from ulna.ik.search.starts import closed_form_starts

    rng = np.random.default_rng(3)
    q, seeds = (rng.uniform(panda.lower, panda.upper, (40, 7)) for _ in range(2))
    T = panda.forward_kinematics(q)
    problem = make_problem(Query(panda.tree, panda.home, panda._checker, panda.tip, Options()), T, seeds)
    order, starts = closed_form_starts(problem, np.arange(40))
    assert len(order) > 35, "eight places of the redundancy reach nearly every pose"
    assert ((starts >= panda.lower) & (starts <= panda.upper)).all()
    assert np.abs(panda.forward_kinematics(starts) - T[order][:, None]).max() < 1e-9
    far = np.abs(starts - seeds[order][:, None]).max(axis=-1)
    assert (np.diff(far, axis=1) >= -1e-12).all() or (far[:, 0] <= far.min(axis=1)).all()


# ---- the angle of the elbow


def iiwa(rng=None):
    """An LBR iiwa 14 R820 by its lengths; or an arm with any spherical shoulder and wrist and any elbow."""
    half = np.pi / 2
    lengths = ((0, 0.36, -half), (0, 0, half), (0, 0.42, half), (0, 0, -half), (0, 0.4, -half), (0, 0, half), (0, 0.126, 0))
    if rng is None:
        rows = [(a, d, alpha, 0.0) for a, d, alpha in lengths]
        return Robot.from_dh(rows, convention="standard", limits=[(-2.9, 2.9)] * 7)
    h, c = np.array([robots.unit(*rng.normal(size=3)) for _ in range(7)]), rng.uniform(-0.4, 0.4, (7, 3))
    c[1] = c[2] = c[0]
    c[5] = c[6] = c[4]
    return arm_of_axes(h, c, rng)


@pytest.mark.parametrize("seed", [None, 1, 2, 3])
def test_at_any_angle_of_the_elbow_there_are_up_to_eight_branches_that_reach(seed):
    robot = iiwa(None if seed is None else np.random.default_rng(seed))
    T = robot.forward_kinematics(np.random.default_rng(4).uniform(robot.lower, robot.upper, (20, 7)))
    found = robot.all_solutions(T, redundancy="elbow", n_samples=32)
    assert found.q.shape == (20, 8 * 32, 7)
    assert found.real.any(axis=1).all()
    assert (found.proof == "continuum").all()
    per_angle = found.real.reshape(20, 32, 8).sum(axis=-1)
    assert (per_angle % 2 == 0).all()
    if seed is None:
        assert per_angle.max() == 8
    reached = robot.forward_kinematics(found.q[found.real])
    assert np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max() < 4e-9
    assert ((found.q[found.valid] >= robot.lower) & (found.q[found.valid] <= robot.upper)).all()


def test_every_configuration_is_near_a_branch_at_some_angle_of_the_elbow():
    """Between samples an eighth of a degree apart no joint is farther than the sample's step brings it."""
    robot = iiwa()
    q = np.random.default_rng(4).uniform(-1.2, 1.2, (6, 7))
    q[:, [1, 3, 5]] = np.sign(q[:, [1, 3, 5]]) * (0.5 + np.abs(q[:, [1, 3, 5]]) / 2)  # off the singularities
    found = robot.all_solutions(robot.forward_kinematics(q), redundancy="elbow", n_samples=2880)
    difference = np.abs((found.q - q[:, None] + np.pi) % TURN - np.pi).max(axis=-1)
    assert np.nanmin(difference, axis=1).max() < 0.02


def test_an_arm_without_an_elbow_is_refused(panda):
    for robot in (panda, ur5()):
        with pytest.raises(InputError, match="elbow"):
            robot.all_solutions(np.eye(4), redundancy="elbow")


# ---- forms that are nearly right


def calibrated(rng, size=1.0):
    """A UR5e as a factory calibrates it: rows off by some 0.3 mm and 0.5 mrad."""
    rows = np.array(robots.UR5E) + size * rng.normal(size=(6, 4)) * [1e-4, 1e-4, 2e-4, 2e-4]
    return Robot.from_dh([tuple(row) for row in rows], convention="standard", limits=[(-np.pi, np.pi)] * 6)


def test_a_calibrated_arm_has_a_near_form_which_proves_nothing_and_finds_the_nearest_branch():
    rng = np.random.default_rng(8)
    robot = calibrated(rng)
    form = robot.closed_form
    assert form is not None
    assert 1e-6 < form.miss < 1e-3
    assert not form.is_exact
    q = rng.uniform(-np.pi, np.pi, (60, 6))
    T = robot.forward_kinematics(q)
    result = robot.inverse_kinematics(T, q + 0.05)
    assert result.success.all()
    assert (np.abs(result.q - q).max(axis=1) < 1e-6).mean() > 0.9
    few = robot.all_solutions(T[:4])
    assert (few.proof == "searched").all()
    for target, row, valid in zip(T[:4], few.q, few.valid, strict=True):
        assert np.abs(robot.forward_kinematics(row[valid]) - target).max() < 1e-8
        known = valid_solutions(robot, target)
        assert len(known) == valid.sum()
    beyond = T[0].copy()
    beyond[:3, 3] *= 3.0
    assert robot.inverse_kinematics(beyond).status == "unreachable"


def test_every_redundant_joint_of_an_arm_of_seven_may_be_held_whatever_its_limits():
    half = np.pi / 2
    d = [0.36, 0, 0.42, 0, 0.4, 0, 0.126]
    rows = [(0, d[k], half * (-1, 1, 1, -1, -1, 1, 0)[k], 0) for k in range(7)]  # an iiwa 14
    robot = ulna.Robot.from_dh(rows, convention="standard", limits=[(-2.9, 2.9)] * 7)  # in the middle the axes 1 and 3 are one
    T = robot.forward_kinematics(np.full(7, 0.4))
    for k in (0, 1, 2, 4, 5, 6):
        found = robot.all_solutions(T, redundancy=f"joint{k + 1}", n_samples=8)
        assert found.q.shape == (64, 7)
        held = np.unique(found.q[found.real][:, k].round(9))
        assert found.proof == "continuum"
        assert 0 < len(held) <= 8
        assert np.abs(robot.forward_kinematics(found.q[found.real]) - T).max() < 1e-9


def test_a_joint_with_which_held_there_is_no_closed_form_is_refused(panda):
    with pytest.raises(InputError, match=r"no closed form with this joint held; there is one with .*panda_joint7"):
        panda.all_solutions(panda.forward_kinematics(panda.home), redundancy="panda_joint3")


def test_no_targets_have_a_sentence_of_their_own(panda):
    for redundancy in (None, "panda_joint4"):
        found = panda.all_solutions(np.zeros((0, 4, 4)), redundancy=redundancy, n_samples=3)
        assert found.q.shape == (0, 24, 7)
        assert str(found) == "no targets"


@pytest.mark.parametrize("limit", [TURN, np.pi])
def test_the_whole_turns_of_a_joint_at_its_limit_are_listed_whatever_its_rounding(limit):
    """One turn from a limit is the other, to rounding: which of the two is given makes no difference."""
    rng = np.random.default_rng(3)
    robot, turns = ur5(limit), round(limit / np.pi)
    for _ in range(20):
        q = rng.uniform(-3, 3, 6)
        at = rng.choice([0, 1, 3, 5])  # the others would be singular there
        q[at] = rng.choice([-limit, limit])
        listed = robot.all_solutions(robot.forward_kinematics(q), whole_turns=True)
        places = [x + TURN * np.arange(-4, 5) for x in q]
        places = [x[np.abs(x) <= limit + 1e-9] for x in places]
        assert len(places[at]) == turns + 1
        mine = listed.q[listed.valid]
        assert (np.abs(mine) <= limit).all()
        for twin in itertools.product(*places):
            assert (np.abs(mine - twin).max(axis=1) < 1e-7).sum() == 1


def test_more_whole_turns_than_memory_holds_are_refused():
    robot = ur5(limit=400.0)
    with pytest.raises(InputError, match=r"whole_turns: the limits allow .* turns of one solution"):
        robot.all_solutions(robot.forward_kinematics(Q), whole_turns=True)
