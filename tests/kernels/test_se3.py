"""Poses obey the axioms of a group and agree with 4x4 matrices."""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
from assertions import assert_close
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect


def random_poses(rng, n):
    return np.array(
        [formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3)), rng.normal(size=3)) for _ in range(n)]
    )


def rows(T):
    return T[:, :3].reshape(len(T), 12).T


def matrices(pose_rows):
    T = np.tile(np.eye(4), (pose_rows.shape[1], 1, 1))
    T[:, :3] = pose_rows.T.reshape(-1, 3, 4)
    return T


def compose(run, A, B):
    return matrices(run(probes.product, np.vstack([rows(A), rows(B)]), 12))


def test_the_product_is_that_of_the_matrices(run, rng):
    A, B = random_poses(rng, 50), random_poses(rng, 50)
    assert_close(compose(run, A, B), A @ B, atol=1e-15 * 8)


def test_the_product_is_associative(run, rng):
    A, B, C = (random_poses(rng, 50) for _ in range(3))
    assert_close(compose(run, compose(run, A, B), C), compose(run, A, compose(run, B, C)), atol=1e-14)


def test_a_pose_times_its_inverse_is_the_identity_on_both_sides(run, rng):
    A = random_poses(rng, 50)
    inverse, identity = np.linalg.inv(A), np.tile(np.eye(4), (50, 1, 1))
    assert_close(compose(run, A, inverse), identity, atol=1e-14)
    assert_close(compose(run, inverse, A), identity, atol=1e-14)


def test_the_identity_changes_nothing(run, rng):
    A, identity = random_poses(rng, 50), np.tile(np.eye(4), (50, 1, 1))
    assert np.array_equal(compose(run, A, identity), A)
    assert np.array_equal(compose(run, identity, A), A)


def test_turning_and_sliding_are_products_by_a_joint(run, rng):
    A, x = random_poses(rng, 60), rng.uniform(-7, 7, 60)
    both = run(probes.turn_and_slide, np.vstack([rows(A), x]), 24)
    Z = np.array([0.0, 0.0, 1.0])
    turned = [T @ formulas.transform(formulas.rotation(Z, s)) for T, s in zip(A, x, strict=True)]
    slid = [T @ formulas.transform(p=Z * s) for T, s in zip(A, x, strict=True)]
    assert_close(matrices(both[:12]), turned, atol=2e-15)
    assert_close(matrices(both[12:]), slid, atol=4e-15)


def test_turning_twice_adds_the_angles(run, rng):
    A, x, y = random_poses(rng, 50), rng.uniform(-3, 3, 50), rng.uniform(-3, 3, 50)
    once = run(probes.turn_and_slide, np.vstack([rows(A), x]), 24)[:12]
    twice = run(probes.turn_and_slide, np.vstack([once, y]), 24)[:12]
    assert_close(twice, run(probes.turn_and_slide, np.vstack([rows(A), x + y]), 24)[:12], atol=4e-15)


def test_a_constant_pose_is_in_its_row(run, rng):
    table = rng.normal(size=(3, 17))
    assert np.array_equal(run(probes.constant, np.zeros((1, 9)), 12, table), np.tile(table[1, :12], (9, 1)).T)


def test_the_pose_of_a_matrix_is_its_upper_rows(rng):
    T = random_poses(rng, 1)[0]
    assert np.array_equal(matrix_pose(T), T[:3].ravel())


def test_a_rigid_motion_has_no_defect(rng):
    assert max(rigidity_defect(T) for T in random_poses(rng, 100)) < 2e-15


@pytest.mark.parametrize("fault", [1e-3, 1e-5, 1e-9])
@pytest.mark.parametrize("entry", [(r, c) for r in range(4) for c in range(4) if (r, c) not in {(0, 3), (1, 3), (2, 3)}])
def test_a_fault_in_any_entry_is_seen_in_its_size(entry, fault):
    T = np.eye(4)
    T[entry] += fault
    assert 0.99 * fault < rigidity_defect(T) < 4 * fault


def test_a_reflection_is_not_rigid(rng):
    for mirror in (np.diag([1.0, 1, -1, 1]), np.diag([-1.0, -1, -1, 1])):
        assert all(rigidity_defect(T @ mirror) > 1 for T in random_poses(rng, 20))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_not_rigid(bad):
    taken_as_rigid = []
    for entry in np.ndindex(4, 4):
        T = np.eye(4)
        T[entry] = bad
        with np.errstate(invalid="ignore"):
            if rigidity_defect(T) <= LARGEST_DEFECT:
                taken_as_rigid.append(entry)
    assert taken_as_rigid == []
