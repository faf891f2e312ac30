"""Options of a search besides the task: joints that are held, a largest step; and options that cannot be taken."""

import inspect

import numpy as np
import pytest

from ulna import InputError, UnknownNameError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import Options
from ulna.robot import Robot

N = 200
HELD = ("panda_joint2", "panda_joint5")
COLUMNS = [1, 4]


@pytest.fixture(scope="module")
def q(panda):
    return np.random.default_rng(31).uniform(panda.lower, panda.upper, (N, 7))


@pytest.fixture(scope="module")
def targets(panda, q):
    return panda.forward_kinematics(q)


def near(panda, q, width):
    return np.clip(q + np.random.default_rng(32).uniform(-width, width, q.shape), panda.lower, panda.upper)


def assert_reached(panda, result, targets):
    reached = panda.forward_kinematics(result.q)[result.success]
    np.testing.assert_allclose(reached, targets[result.success], rtol=0, atol=2.1e-5)


# ---- held joints and largest steps


def test_joints_that_are_held_do_not_move_by_a_bit(panda, q, targets):
    seeds = near(panda, q, 0.2)
    seeds[:, COLUMNS] = q[:, COLUMNS]
    for held in (HELD, list(HELD), np.array(HELD), iter(HELD)):
        result = panda.inverse_kinematics(targets, q_seed=seeds, held=held, max_iterations=100)
        assert np.array_equal(result.q[:, COLUMNS], seeds[:, COLUMNS])
        assert_reached(panda, result, targets)
        assert result.success.mean() > 0.5


def test_joints_that_are_held_elsewhere_are_named(panda, q, targets):
    """Five joints are left: with two held a little aside, hardly a target can be met."""
    seeds = q.copy()
    seeds[:, COLUMNS] = np.clip(q[:, COLUMNS] - 0.05, panda.lower[COLUMNS], panda.upper[COLUMNS])
    result = panda.inverse_kinematics(targets[:40], q_seed=seeds[:40], held=HELD)
    failed = result.status == "held joints"
    assert failed.mean() > 0.5
    others = np.delete(np.arange(7), COLUMNS)
    assert not result.limit_excess[failed][:, others].any()
    assert (result.limit_excess[failed][:, COLUMNS].max(axis=1) > 0).all()
    one = panda.inverse_kinematics(targets[np.flatnonzero(failed)[0]], q_seed=seeds[np.flatnonzero(failed)[0]], held=HELD)
    assert "only with held joints moved: panda_joint" in str(one)


@pytest.mark.parametrize("max_step", [0.02, 0.1, 0.5])
def test_no_joint_passes_the_largest_step_and_the_error_says_by_how_much(panda, q, targets, max_step):
    seeds = near(panda, q, 0.2)
    result = panda.inverse_kinematics(targets, q_seed=seeds, max_step=max_step)
    assert np.abs(result.q - seeds).max() <= max_step + 1e-15
    assert_reached(panda, result, targets)
    refused = result.status == "beyond max_step"
    assert (refused | result.success).mean() > 0.95
    if max_step < 0.2:
        assert refused.mean() > 0.3
        assert (result.limit_excess[refused].max(axis=1) > 0).all()
        assert np.median(result.limit_excess[refused].max(axis=1)) < 0.2, "the known solution is no further away"
    else:
        assert result.success.all()


def test_a_seed_further_beyond_its_limits_than_it_may_move_is_refused(panda):
    T = panda.forward_kinematics(panda.upper)
    with pytest.raises(InputError, match=r"^q_seed: a joint is further beyond its limits"):
        panda.inverse_kinematics(T, q_seed=panda.upper + 1, max_step=0.1)
    with pytest.raises(InputError, match=r"^q_seed: a joint that is held is further beyond"):
        panda.inverse_kinematics(T, q_seed=panda.upper + 1, held="panda_joint3")
    back = panda.inverse_kinematics(T, q_seed=panda.upper + 0.05, max_step=0.1)
    assert np.abs(back.q - panda.upper - 0.05).max() <= 0.1 + 1e-15


def test_without_a_bound_a_path_is_followed_and_with_one_it_is_followed_alike(panda):
    q = bounded = panda.home
    for angle in np.linspace(0, 2 * np.pi, 100):
        T = panda.forward_kinematics(panda.home)
        T[:3, 3] += 0.1 * np.array([np.cos(angle) - 1, np.sin(angle), 0])
        result, with_bound = panda.inverse_kinematics(T, q_seed=q), panda.inverse_kinematics(T, q_seed=bounded, max_step=0.05)
        assert result.success
        assert with_bound.success
        assert np.abs(result.q - q).max() < 0.05
        np.testing.assert_allclose(with_bound.q, result.q, rtol=0, atol=1e-6)
        q, bounded = result.q, with_bound.q


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"held": ["panda_joint0"]}, UnknownNameError, "no joint is called 'panda_joint0'; did you mean"),
        ({"held": [3]}, UnknownNameError, "no joint is called '3'"),
        ({"held": 3}, InputError, "held: "),
        ({"held": np.array("panda_joint1")}, InputError, "held: "),
        ({"trace": np.zeros(2)}, InputError, "trace: "),
        ({"position_tolerance": 10**400}, InputError, "position_tolerance: "),
        ({"time_limit": 10**400}, InputError, "time_limit: "),
        ({"seed": True}, InputError, "seed: "),
        ({"rank": np.zeros(2)}, InputError, "rank: "),
        ({"max_step": 0.1, "q_seed": None}, InputError, "max_step: .*q_seed is needed too"),
        ({"max_step": 0.0}, InputError, "max_step: "),
        ({"max_step": -1}, InputError, "max_step: "),
        ({"max_step": np.nan}, InputError, "max_step: "),
        ({"max_step": "far"}, InputError, "max_step: "),
        ({"rank": "neerest"}, InputError, "rank: 'neerest' is not a rank; did you mean 'nearest'"),
        ({"rank": 1}, InputError, "rank: "),
        ({"rank": "clearance"}, InputError, "rank: .*world= is needed too"),
        ({"world": "crate"}, InputError, "world: "),
        ({"posture": "home"}, InputError, "posture: 'home'; a configuration or 'mid_range' is expected"),
        ({"task": "positon"}, InputError, "task: 'positon' is not a task; did you mean 'position'"),
        ({"task": 3}, InputError, "task: "),
        ({"task": np.zeros(6)}, InputError, "task: "),
        ({"time_limit": -1}, InputError, "time_limit: "),
        ({"time_limit": np.nan}, InputError, "time_limit: "),
        ({"time_limit": "long"}, InputError, "time_limit: "),
        ({"link": ["panda_ee"]}, UnknownNameError, "no link is called"),
    ],
    ids=str,
)
@pytest.mark.parametrize("batch", [False, True], ids=["one", "batch"])
def test_an_invalid_option_is_refused_by_its_name(panda, options, error, message, batch):
    T = panda.forward_kinematics(panda.home + 0.01)
    with pytest.raises(error, match=f"^{message}"):
        panda.inverse_kinematics(T[None] if batch else T, **{"q_seed": panda.home, **options})


@pytest.mark.parametrize("method", ["inverse_kinematics", "all_solutions"])
def test_each_option_is_passed_as_itself(panda, monkeypatch, method):
    """``Robot`` passes them in their order, not by name."""
    called = inspect.signature(getattr(Robot, method)).parameters
    given = {name: object() for name in Options._fields if name in called}
    passed = []
    monkeypatch.setattr(InverseKinematics, method, lambda _, *arguments, **__: passed.extend(arguments))
    getattr(panda, method)(np.eye(4), **given)
    options = passed[0].options
    assert {name: value for name, value in options._asdict().items() if name in given} == given
    assert all(value == getattr(Options(), name) for name, value in options._asdict().items() if name not in given)
    assert len(given) == {"inverse_kinematics": len(Options._fields), "all_solutions": 5}[method]
