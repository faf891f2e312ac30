"""The geometric Jacobian against differences of the pose, in all three frames."""

import numpy as np
import pytest

import formulas
import kernel_modes
import kernel_probes as probes
import robots
from assertions import assert_close
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.layout import IN_BASE, IN_LINK, IN_SPATIAL
from ulna.kinematics.entries import jacobian
from ulna.kinematics.tree import build_tree

jacobian_batch = jacobian.jacobian_batch
FRAMES = {"base": IN_BASE, "link": IN_LINK, "spatial": IN_SPATIAL}
ROBOT = robots.every_joint()
LINKS = ["fingertip", "hand", "tray", "propeller", "rotor", "base"]
N = 3

of_no_columns = kernel_modes.compiled(lambda chain, q, rows: chain_jacobian(chain, q, IN_BASE, rows[:0], 6, 1))


def jacobians(run, tree, link, frame, q):
    chain = tree.chain(link)
    out = run(probes.jacobian_of_chain, q.T, 6 * tree.n_dof + 12, chain, FRAMES[frame], tree.n_dof)
    n = 6 * tree.n_dof
    return out[:n].T.reshape(len(q), tree.n_dof, 6).transpose(0, 2, 1), out[n : n + 12].T.reshape(len(q), 3, 4)


@pytest.mark.slow
@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("link", LINKS)
def test_columns_are_the_velocities_of_the_link(run, rng, link, frame):
    tree = build_tree(ROBOT)
    q = rng.uniform(-1.4, 1.4, (N, tree.n_dof))
    J, pose = jacobians(run, tree, link, frame, q)
    assert_close(J, [formulas.jacobian(ROBOT, x, link, frame) for x in q], atol=1e-10)
    assert_close(pose, [formulas.link_pose(ROBOT, x, link)[:3] for x in q], atol=2e-14)


def test_the_panda_too(run, rng, panda):
    q = rng.uniform(panda.lower, panda.upper, (N, 7))
    for frame in FRAMES:
        J, _ = jacobians(run, panda.tree, "panda_ee", frame, q)
        assert_close(J, [formulas.jacobian(panda.description, x, "panda_ee", frame) for x in q], atol=1e-10)


def test_a_prismatic_joint_turns_nothing(run, rng):
    tree = build_tree(ROBOT)
    (slide,) = (s.start for name, s in zip(tree.joint_names, tree.joint_slices, strict=True) if name == "slide")
    for frame in FRAMES:
        J, _ = jacobians(run, tree, "hand", frame, rng.normal(size=(N, tree.n_dof)))
        assert np.array_equal(J[:, 3:, slide], np.zeros((N, 3)))
        assert_close(np.linalg.norm(J[:, :3, slide], axis=1), 1, atol=1e-14)


def test_joints_that_do_not_carry_the_link_have_columns_of_zeros(run, rng):
    tree = build_tree(ROBOT)
    J, _ = jacobians(run, tree, "propeller", "base", rng.normal(size=(N, tree.n_dof)))
    carried_by = dict(zip(tree.joint_names, tree.joint_slices, strict=True))
    for name in ("shoulder", "table", "slide", "wheel"):
        assert not J[:, :, carried_by[name]].any()
    assert J[:, :, carried_by["float"]].any(axis=(0, 1)).all()


def test_a_mimic_joint_adds_to_the_column_of_its_leader(run):
    leader = robots.two_links("revolute", robots.Z).joints[0]
    follower = robots.Joint(
        "k",
        robots.JointType.REVOLUTE,
        "b",
        "c",
        formulas.transform(p=(1, 0, 0)),
        robots.Z,
        mimic=robots.Mimic("j", -2.0, 0.5),
    )
    description = robots.Description("two", tuple(map(robots.Link, "abc")), (leader, follower))
    J, _ = jacobians(run, build_tree(description), "c", "base", np.array([[0.3]]))
    assert_close(J[0, :, 0], [-np.sin(0.3), np.cos(0.3), 0, 0, 0, 1 - 2], atol=1e-15)


def test_the_frames_are_one_twist_seen_from_three_places(run, rng):
    tree = build_tree(ROBOT)
    q = rng.normal(size=(N, tree.n_dof))
    (base, pose), (link, _), (spatial, _) = (jacobians(run, tree, "fingertip", frame, q) for frame in FRAMES)
    for k in range(N):
        R, p = pose[k, :, :3], pose[k, :, 3]
        assert_close(link[k], np.vstack([R.T @ base[k, :3], R.T @ base[k, 3:]]), atol=1e-14)
        assert_close(spatial[k], np.vstack([base[k, :3] + formulas.skew(p) @ base[k, 3:], base[k, 3:]]), atol=1e-14)


@pytest.mark.parametrize("frame", FRAMES)
def test_the_entries_give_six_rows_a_configuration(rng, frame):
    tree = build_tree(ROBOT)
    q, chain = rng.uniform(-1.4, 1.4, (9, tree.n_dof)), tree.chain("hand")
    J, first = np.full((9, 6, tree.n_dof), np.nan), np.full((6, tree.n_dof), np.nan)
    assert jacobian_batch(chain, FRAMES[frame], q, J)
    assert jacobian.jacobian_one(chain.copy(), FRAMES[frame], tree.n_dof, q[0], first)
    assert_close(J, [formulas.jacobian(ROBOT, x, "hand", frame) for x in q], atol=1e-10)
    assert_close(first, J[0], atol=1e-14)


@pytest.mark.parametrize("n_dof", range(1, 10))
def test_every_row_of_a_batch_is_written_whatever_its_length(rng, n_dof):
    kinds = (["revolute", "revolute", "prismatic"] * 3)[:n_dof]
    description = robots.of_chain(*kinds, axis=(0.6, 0.0, 0.8), origin=robots.place(1))
    tree, link = build_tree(description), f"l{n_dof}"
    for n in (1, 7, 8, 9, 17):
        q, J = rng.uniform(-1, 1, (n, tree.n_dof)), np.full((n, 6, tree.n_dof), np.nan)
        assert jacobian_batch(tree.chain(link), IN_BASE, q, J)
        assert_close(J, [formulas.jacobian(description, x, link, "base") for x in q], atol=1e-9)


def test_the_entries_report_an_entry_out_of_range(rng):
    tree = build_tree(ROBOT)
    q, chain = rng.normal(size=(9, tree.n_dof)), tree.chain("hand")
    q[8, 2] = np.nan
    assert not jacobian_batch(chain, IN_BASE, q, np.empty((9, 6, tree.n_dof)))
    assert not jacobian.jacobian_one(chain.copy(), IN_BASE, tree.n_dof, q[8], np.empty((6, tree.n_dof)))


def test_a_joint_that_nothing_drives_writes_no_column():
    fixed, ahead = robots.two_links("fixed", robots.Z).joints[0], formulas.transform(p=(1, 0, 0))
    follower = robots.Joint("k", robots.JointType.REVOLUTE, "b", "c", np.eye(4), robots.Z, mimic=robots.Mimic("j", 2.0, 0.5))
    tip = robots.Joint("l", robots.JointType.FIXED, "c", "d", ahead, robots.Z)
    tree = build_tree(robots.Description("no dof", tuple(map(robots.Link, "abcd")), (fixed, follower, tip)))
    rows_behind = np.full(6, 7.0)  # the Jacobian has no rows: what is written anywhere is written here
    chain = tree.chain("d")
    of_no_columns(chain, np.full(1, np.nan), rows_behind)
    assert np.array_equal(rows_behind, np.full(6, 7.0))
