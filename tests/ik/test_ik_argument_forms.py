"""The result does not depend on the form of the arguments: any kind of array, alone, in threads, and after a pickle."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import robots
import ulna
from invalid_poses import INVALID_POSES
from ulna import InputError, Robot, Task
from ulna.ik.entries import multi_start

search_jobs = multi_start.search_jobs


def read_only(a):
    a = a.copy()
    a.setflags(write=False)
    return a


FORMS = {
    "Fortran order": np.asfortranarray,
    "read-only": read_only,
    "nested lists": lambda a: a.tolist(),
    "every second": lambda a: np.repeat(a, 2, axis=-1)[..., ::2],
    "big-endian": lambda a: a.astype(">f8"),
    "longdouble": np.longdouble,
}
# A default may be passed or left out; strings may be made at run time, numbers be NumPy's.
SAID = {
    "max_iterations": {"max_iterations": 16_000},
    "held": {"held": []},
    "task": {"task": Task.pose()},
    "task by a word": {"task": str(np.array("pose"))},
    "seed": {"seed": np.int64(0)},
    "tolerance": {"position_tolerance": np.float64(1e-5)},
    "time_limit": {"time_limit": 1e6},
    "trace": {"trace": True},
    "link": {"link": "panda_ee"},
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seeded", [False, True], ids=["from home", "from a seed"])
def test_one_target_has_one_result_in_every_form(panda, targets, q, form, seeded):
    for T, x in zip(targets, q + 0.1, strict=True):
        plain = panda.inverse_kinematics(T, x if seeded else None)
        other = panda.inverse_kinematics(FORMS[form](T), FORMS[form](x) if seeded else None)
        assert np.array_equal(other.q, plain.q)
        assert (other.iterations, other.starts, other.status) == (plain.iterations, plain.starts, plain.status)


@pytest.mark.parametrize("name", SAID)
def test_a_default_that_is_passed_changes_nothing(panda, targets, name):
    for T in targets:
        assert np.array_equal(panda.inverse_kinematics(T, **SAID[name]).q, panda.inverse_kinematics(T).q)


def test_rounded_to_float32_a_target_is_met_to_its_own_precision(panda, targets):
    for T in targets[:10]:
        assert panda.inverse_kinematics(T.astype(np.float32)).success


NO_SEEDS = {
    "NaN": np.array([0, 0, 0, -1, np.nan, 1, 0.0]),
    "infinite": np.array([0, 0, 0, -1, np.inf, 1, 0.0]),
    "too large": np.array([0, 0, 0, -1, 2e6, 1, 0.0]),
    "short": np.zeros(6),
    "a batch": np.zeros((2, 6)),
}


def refusal(call):
    with pytest.raises(InputError) as caught:
        call()
    return str(caught.value)


@pytest.mark.parametrize("name", NO_SEEDS)
def test_the_fast_path_and_the_general_one_refuse_the_same_seeds_in_the_same_words(panda, targets, name):
    seed = NO_SEEDS[name]
    short = refusal(lambda: panda.inverse_kinematics(targets[0], seed))
    assert short == refusal(lambda: panda.inverse_kinematics(targets[0], seed, time_limit=10))
    assert short == refusal(lambda: panda.inverse_kinematics(targets[0].tolist(), seed.tolist()))
    assert short.startswith("q_seed")


@pytest.mark.parametrize("name", INVALID_POSES)
def test_the_fast_path_and_the_general_one_refuse_the_same_targets_in_the_same_words(panda, name):
    T, _ = INVALID_POSES[name]
    short = refusal(lambda: panda.inverse_kinematics(T))
    assert short == refusal(lambda: panda.inverse_kinematics(T.tolist(), max_iterations=7))
    assert short.startswith("T: ")


@pytest.mark.compiler
@pytest.mark.skipif(not hasattr(search_jobs, "signatures"), reason="without the compiler there is no machine code")
def test_no_form_of_input_is_compiled_for_anew(panda, targets, q):
    """Each signature costs a compilation of ten seconds, once."""
    panda.inverse_kinematics(targets)
    before = len(search_jobs.signatures)
    for change in (np.asfortranarray, read_only, np.ndarray.tolist, lambda a: a[::-1]):
        for options in (
            {},
            {"q_seed": change(q)},
            {"q_seed": change(q[:1])},
            {"posture": change(q)[0]},
            {"held": "panda_joint2"},
        ):
            panda.inverse_kinematics(change(targets), max_iterations=30, **options)
        panda.inverse_kinematics(change(targets), q_seed=change(q), max_step=0.3, max_iterations=30)
        panda.inverse_kinematics(change(targets), task=Task.pointing((1, 0, 0)), rank="nearest", max_iterations=30)
    assert len(search_jobs.signatures) == before


# ---- threads and pickles


def test_threads_that_share_a_robot_get_the_bits_of_one(panda, targets, q):
    def in_two_threads(T):
        with ulna.threads(2):
            return panda.inverse_kinematics(T)

    ways = [
        lambda k: panda.inverse_kinematics(targets[k]),
        lambda k: panda.inverse_kinematics(targets[k], q_seed=q[(k + 1) % 40]),
        lambda k: in_two_threads(targets[: k + 1]),
        lambda k: panda.inverse_kinematics(targets[k], task="position", rank="nearest"),
        lambda k: panda.inverse_kinematics(targets[k], seed=k, position_tolerance=1e-6 * (k + 1)),
    ]

    def ask(k):
        result = ways[k % len(ways)](k % 40)
        return result.q.tobytes(), np.asarray(result.status).tobytes(), np.asarray(result.residual).tobytes()

    alone = [ask(k) for k in range(240)]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(ask, range(240))) == alone


NAMES = ("q", "success", "status", "position_error", "rotation_error", "residual", "iterations", "starts", "reach_excess")


def test_every_kind_of_result_can_be_pickled(panda, targets):
    far = targets[0].copy()
    far[0, 3] += 3
    mixed = np.array([targets[0], far])
    results = [
        panda.inverse_kinematics(targets[0]),
        panda.inverse_kinematics(far),
        panda.inverse_kinematics(mixed),
        panda.inverse_kinematics(targets[0], q_seed=panda.home, max_step=0.01),
        panda.inverse_kinematics(targets[0], trace=True),
    ]
    for result in results:
        back = pickle.loads(pickle.dumps(result))  # noqa: S301
        assert str(back) == str(result)
        for name in (*NAMES, "limit_excess", "collisions", "tolerances"):
            assert np.array_equal(getattr(back, name), getattr(result, name)), name
    assert np.array_equal(pickle.loads(pickle.dumps(results[-1])).trace, results[-1].trace)  # noqa: S301


def test_a_result_cannot_be_changed(panda, targets):
    result = panda.inverse_kinematics(targets[0])
    for name in ("q", "success", "status", "trace", "color"):
        with pytest.raises(AttributeError):
            setattr(result, name, None)


@pytest.mark.parametrize("options", [{}, {"rank": "mid_range"}, {"posture": "mid_range"}])
@pytest.mark.parametrize("name", ["panda", "UR5"])
def test_one_target_may_have_many_seeds(name, options, panda, rng):
    robot = panda if name == "panda" else Robot.from_dh(robots.UR5, convention="standard", limits=[(-3, 3)] * 6)
    T, seeds = robot.forward_kinematics(robot.home + 0.1), rng.uniform(-0.3, 0.3, (2, 3, robot.n_dof)) + robot.home
    found = robot.inverse_kinematics(T, seeds, **options)
    assert found.q.shape == seeds.shape
    repeated = robot.inverse_kinematics(np.broadcast_to(T, (2, 3, 4, 4)), seeds, **options)
    assert np.array_equal(found.q, repeated.q)
    assert np.array_equal(found.status, repeated.status)
