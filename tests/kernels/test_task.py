"""What a task counts of a pose error: the swing of an axis judged by Rodrigues' formula, the slack by its own words."""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
from assertions import assert_close
from ulna.kernels.ik.search_layout import POINTING, WITH_SLACK
from ulna.kernels.ik.search_records import SearchSettings

N = 24


def random_rotations(rng, n):
    return np.array([formulas.rotation(rng.normal(size=3), rng.uniform(-np.pi, np.pi)) for _ in range(n)])


def swings(run, R_pose, R_target):
    rows = [[formulas.transform(R)[:3].ravel() for R in rotations] for rotations in (R_pose, R_target)]
    return run(probes.swing_of_axes, np.hstack(rows).T, 3).T


def test_the_swing_brings_one_axis_onto_the_other_by_the_shortest_turn(run, rng):
    pose, target = random_rotations(rng, N), random_rotations(rng, N)
    for v, a, b in zip(swings(run, pose, target), pose[:, :, 2], target[:, :, 2], strict=True):
        assert_close(formulas.rotation(v, np.linalg.norm(v)) @ a, b, atol=1e-14)
        assert abs(v @ a) < 1e-14
        assert np.linalg.norm(v) == pytest.approx(np.arccos(a @ b), abs=1e-7)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-13, 0.9e-12, 1.1e-12, 1e-9, 1e-4, 1.5, np.pi / 2, np.pi - 1e-3, np.pi - 1e-9])
def test_the_size_of_the_swing_is_right_from_no_turn_to_nearly_a_half(run, angle):
    for axis in ((1.0, 0, 0), (0, 1.0, 0), (0.6, 0.8, 0)):
        turned = formulas.rotation(axis, angle)
        v = swings(run, [np.eye(3)], [turned])[0]
        assert_close(v, angle * np.array(axis), atol=1e-16 + 1e-15 * angle + (1e-7 if angle > 3.14 else 0))


@pytest.mark.parametrize("off", [0.0, 1e-13, 0.9e-12, 1.1e-12, 1e-9])
def test_opposite_axes_swing_by_a_half_turn_about_some_axis_square_to_them(run, rng, off):
    targets = random_rotations(rng, N)
    poses = np.array(
        [R @ formulas.rotation((1, 0, 0), np.pi - off) @ formulas.rotation((0, 0, 1), rng.uniform(-3, 3)) for R in targets]
    )
    for v, a, b in zip(swings(run, poses, targets), poses[:, :, 2], targets[:, :, 2], strict=True):
        rounding = 1e-11 + (1e-14 / off if off > 1e-12 else 0)  # of the axis: of its cross product few digits are left
        assert np.linalg.norm(v) == pytest.approx(np.pi, abs=1e-8)
        assert abs(v @ b) < rounding
        assert_close(formulas.rotation(v, np.linalg.norm(v)) @ a, b, atol=rounding)


# ---- slack


def counted(run, rng, task, slack, e):
    """The error that is counted, the rows of J, and both given, in the target's axes."""
    n = len(e)
    pose, target, J = random_rotations(rng, n), random_rotations(rng, n), rng.normal(size=(n, 6, 7))
    settings = SearchSettings.records()
    settings[0].task, settings[0].slack[:] = task, slack
    turn = np.array([np.kron(np.eye(2), R) for R in target])  # of both halves, from the target's axes into the base's
    poses = [[formulas.transform(R)[:3].ravel() for R in rotations] for rotations in (pose, target)]
    in_base = np.einsum("nij,nj->ni", turn, e)
    rows = np.vstack([np.hstack(poses).T, in_base.T, J.transpose(2, 1, 0).reshape(42, n)])
    out = run(probes.error_of_task, rows, 6 + 42, settings, 7)
    return out[:6].T, out[6:].reshape(7, 6, n).transpose(2, 1, 0), np.einsum("nji,njk->nik", turn, J), pose, target


def test_a_component_within_its_slack_costs_nothing_and_beyond_it_only_what_is_beyond(run, rng):
    slack = np.array([0.1, 0.0, 0.5, 0.2, 0.0, 0.3])
    e = rng.uniform(-0.8, 0.8, (N, 6))
    error, rows, J, _, _ = counted(run, rng, WITH_SLACK, slack, e)
    assert_close(error, np.sign(e) * np.maximum(abs(e) - slack, 0.0), atol=1e-15)
    free = (abs(e) <= slack) & (slack > 0)
    assert free.any()
    assert not free.all()
    assert_close(rows, np.where(free[:, :, None], 0.0, J), atol=1e-14)


def test_a_component_that_is_free_is_never_counted(run, rng):
    slack = [0.0, 0.0, np.inf, np.inf, np.inf, np.inf]
    e = rng.normal(size=(N, 6)) * 1e3
    error, rows, J, _, _ = counted(run, rng, WITH_SLACK, slack, e)
    assert_close(error[:, :2], e[:, :2], atol=1e-11)
    assert not error[:, 2:].any()
    assert not rows[:, 2:].any()
    assert_close(rows[:, :2], J[:, :2], atol=1e-14)


def test_an_error_of_nothing_keeps_every_row_that_has_no_slack(run, rng):
    error, rows, J, _, _ = counted(run, rng, WITH_SLACK, [0.0, 0.1, 0.0, 0.0, 0.0, np.inf], np.zeros((N, 6)))
    assert not error.any()
    assert_close(rows[:, [0, 2, 3, 4]], J[:, [0, 2, 3, 4]], atol=1e-14)
    assert not rows[:, [1, 5]].any()


def test_pointing_counts_the_swing_and_not_the_turn_about_the_axis(run, rng):
    e = rng.uniform(-0.8, 0.8, (N, 6))
    error, rows, J, pose, target = counted(run, rng, POINTING, [0, 0, 0, 0, 0, np.inf], e)
    assert_close(error[:, :3], e[:, :3], atol=1e-15)
    assert_close(error[:, 3:], np.einsum("nji,nj->ni", target, swings(run, pose, target)) * [1, 1, 0], atol=1e-13)
    assert not rows[:, 5].any()
    assert_close(rows[:, :5], J[:, :5], atol=1e-14)
