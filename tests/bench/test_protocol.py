"""Protocols and verdicts: errors judged by Pinocchio's logarithm, and solvers that lie found out."""

import numpy as np
import pinocchio as pin
import pytest

import formulas
from ulna.bench.arms import path_positions, random_positions
from ulna.bench.protocol import (
    PROTOCOLS,
    STEP_BOUND,
    Solver,
    follow_path,
    judge,
    pose_errors,
    run_protocol,
    ulna_solver,
    within_limits,
)


def turned(axis, angle, xyz=(0, 0, 0)):
    axis = np.array(axis, dtype=float)
    return formulas.transform(formulas.rotation(axis / np.linalg.norm(axis), angle), xyz)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-5, 0.3, 3.0, np.pi - 1e-6, np.pi])
def test_errors_are_the_way_and_the_rotation_vector_to_the_target(angle):
    T, target = turned((1, 2, 3), 0.7, (0.1, 0.2, 0.3)), turned((1, 2, 3), 0.7, (0.4, 0.1, 0.3))
    target[:3, :3] = turned((2, -1, 0.5), angle)[:3, :3] @ T[:3, :3]
    (error,) = pose_errors(T[None], target[None])
    np.testing.assert_allclose(T[:3, :3] @ error[:3], (0.3, -0.1, 0.0), atol=1e-15)
    expected = pin.log3(T[:3, :3].T @ target[:3, :3])
    assert np.linalg.norm(error[3:]) == pytest.approx(angle, abs=1e-8)
    if angle < 3.1:  # at a half turn the axis is lost in rounding, and only the angle is judged
        np.testing.assert_allclose(error[3:], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "within", "beyond"),
    [
        ("reachable", (1e-5, 0, 0, 0, 0, 1e-5), (0.8e-5, 0.8e-5, 0, 0, 0, 0)),
        ("A", (1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5), (0, 0, 1.1e-5, 0, 0, 0)),
        ("B", (1.4e-3, 0, 0, 0, 0, 0), (1.1e-3, 0, 0, 1e-3, 0, 0)),
    ],
)
def test_each_protocol_draws_its_own_border(name, within, beyond):
    assert PROTOCOLS[name].reached(np.array([within, beyond])).tolist() == [True, False]


def test_limits_are_kept_to_a_millionth(panda):
    q = np.array([panda.upper, panda.upper + 1e-7, panda.upper + 1e-5, panda.lower - 1e-5])
    assert within_limits(panda, q).tolist() == [True, True, False, False]


@pytest.mark.parametrize("name", ["reachable", "A", "B"])
def test_ulna_solves_the_targets_of_each_protocol(panda, name):
    row = run_protocol(ulna_solver(panda, PROTOCOLS[name]), panda, name, 50, panda.forward_kinematics, passes=1)
    assert (row["targets"], row["solved_percent"], row["said_solved_but_not"]) == (50, 100.0, 0)
    assert 0 < row["median_us"] <= row["p99_us"]


def test_nothing_out_of_reach_is_called_solved(panda):
    row = run_protocol(ulna_solver(panda, PROTOCOLS["unreachable"]), panda, "unreachable", 3, panda.forward_kinematics, passes=1)
    assert (row["solved_percent"], row["said_solved_but_not"]) == (0.0, 0)


def test_a_solver_that_lies_is_found_out(panda):
    liar = Solver("liar", lambda *_: panda.home, lambda q: q)
    outside = Solver("outside", lambda T, _: panda.inverse_kinematics(T).q + 2 * np.pi * np.eye(7)[0], lambda q: q)
    for solver in (liar, outside):
        row = run_protocol(solver, panda, "reachable", 20, panda.forward_kinematics, passes=1)
        assert (row["solved_percent"], row["said_solved_but_not"]) == (0.0, 20)


def test_a_solver_that_gives_up_is_counted_as_failed_not_as_wrong(panda):
    silent = Solver("silent", lambda *_: None, lambda q: q)
    targets = panda.forward_kinematics(random_positions(panda, 5, 0))
    claimed, good = judge(silent, panda, PROTOCOLS["reachable"], targets, panda.forward_kinematics)
    assert not claimed.any()
    assert not good.any()


def test_what_is_prepared_is_what_is_solved(panda):
    seen = []
    solver = Solver("counting", lambda T, _: seen.append(T), lambda _: None, lambda _: "prepared")
    run_protocol(solver, panda, "reachable", 4, panda.forward_kinematics, passes=1)
    assert set(seen) == {"prepared"}


def test_a_path_that_is_followed_has_the_steps_of_the_path(panda):
    path = path_positions(panda, 100, 1)
    answers = iter([*path, *path])
    knowing = Solver("knowing", lambda *_: next(answers, path[0]), lambda q: q)
    row = follow_path(knowing, panda, 100, panda.forward_kinematics)
    assert row["largest_step"] == pytest.approx(np.abs(np.diff(path, axis=0)).max())
    assert (row["solved_percent"], row["lost"]) == (100.0, 0)


def test_a_step_above_the_bound_is_counted(panda):
    path = path_positions(panda, 1000, 1)
    path[20] += 2 * STEP_BOUND
    answers = iter([*path, *path])
    jumping = Solver("jumping", lambda *_: next(answers, path[0]), lambda q: q)
    row = follow_path(jumping, panda, 1000, panda.forward_kinematics)
    assert row["steps_above_bound"] == 2  # there and back
    assert row["solved_percent"] == pytest.approx(99.9)
