"""Forward kinematics, of a chain and of a whole tree, against 4x4 products along the description's joints."""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
import robots
from assertions import assert_close
from ulna.kinematics.entries import forward
from ulna.kinematics.tree import build_tree

forward_batch = forward.forward_batch
frames_batch = forward.frames_batch
frames_one = forward.frames_one
ROBOTS = {
    "every joint": robots.every_joint(),
    "sliders": robots.of_chain("prismatic", "revolute", "prismatic", axis=robots.unit(1, -2, 0.5), origin=robots.place(0)),
    "one fixed joint": robots.of_chain("fixed", origin=robots.place(1)),
    "planar": robots.of_chain("planar", "fixed", axis=robots.unit(1, 1, 1), origin=robots.place(2)),
    "floating": robots.of_chain("floating", "revolute", origin=robots.place(0)),
    "about -z": robots.of_chain("revolute", "prismatic", "planar", axis=-robots.Z),
    "about x and y": robots.two_links("revolute", robots.X),
}
N = 10


@pytest.fixture(params=ROBOTS)
def description(request):
    return ROBOTS[request.param]


@pytest.fixture
def tree(description):
    return build_tree(description)


@pytest.fixture
def q(tree, rng):
    return rng.uniform(-3, 3, (N, tree.n_dof))


def rows_of(q):
    """Columns are problems; a kernel of a robot without joints gets one row that it does not use."""
    return q.T if q.shape[1] else np.zeros((1, len(q)))


def test_every_link_is_where_the_products_put_it(run, description, tree, q):
    n_joints, n_links = len(tree.joints), len(tree.link_names)
    out = run(probes.frames_of_tree, rows_of(q), 12 * (n_joints + n_links), tree.joints, tree.link_frames)
    found = out[12 * n_joints :].T.reshape(N, n_links, 3, 4)
    assert_close(found, [formulas.link_poses(description, x)[:, :3] for x in q], atol=2e-14)


def test_the_end_of_every_chain_is_where_the_products_put_it(run, description, tree, q):
    expected = np.array([formulas.link_poses(description, x)[:, :3] for x in q])
    for k, link in enumerate(tree.link_names):
        found = run(probes.end_of_chain, rows_of(q), 12, tree.chain(link)).T.reshape(N, 3, 4)
        assert_close(found, expected[:, k], atol=2e-14)


def test_sines_first_and_poses_after_them_give_the_same_end(run, tree, q):
    chain = tree.chain(tree.link_names[-1])
    found = run(probes.end_of_chain_by_turns, rows_of(q), 12 + 2 * len(chain), chain)
    assert_close(found[:12], run(probes.end_of_chain, rows_of(q), 12, chain), atol=1e-14)


def test_the_entries_write_whole_matrices(description, tree, q):
    T, chain = np.full((N, 4, 4), np.nan), tree.chain(tree.link_names[0])
    poses = np.full((N, len(tree.link_names), 4, 4), np.nan)
    assert forward_batch(chain, q, T)
    assert frames_batch(tree.joints, tree.link_frames, q, poses)
    expected = np.array([formulas.link_poses(description, x) for x in q])
    assert_close(poses, expected, atol=2e-14)
    assert_close(T, expected[:, 0], atol=2e-14)
    assert np.array_equal(poses[..., 3, :], np.broadcast_to([0, 0, 0, 1], (N, len(tree.link_names), 4)))


def test_one_configuration_gives_what_the_batch_gives(description, tree, q):
    T, poses = np.empty((4, 4)), np.empty((len(tree.link_names), 4, 4))
    x = q[3] if tree.n_dof else np.zeros(1)
    assert forward.forward_one(tree.chain(tree.link_names[-1]).copy(), len(x), x, T)
    assert frames_one(tree.joints, tree.link_frames, x, poses)
    expected = formulas.link_poses(description, q[3])
    assert_close(poses, expected, atol=2e-14)
    assert_close(T, expected[-1], atol=2e-14)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -2e6])
def test_the_entries_report_an_entry_out_of_range(bad, rng):
    tree = build_tree(ROBOTS["every joint"])
    chain, links = tree.chain("hand"), len(tree.link_names)
    with np.errstate(invalid="ignore"):
        for row in (0, 8, 9):
            q = rng.normal(size=(10, tree.n_dof))
            q[row, -1] = bad
            assert not forward_batch(chain, q, np.empty((10, 4, 4)))
            assert not frames_batch(tree.joints, tree.link_frames, q, np.empty((10, links, 4, 4)))
            assert not forward.forward_one(chain.copy(), tree.n_dof, q[row], np.empty((4, 4)))
            assert not frames_one(tree.joints, tree.link_frames, q[row], np.empty((links, 4, 4)))


def test_a_long_chain_loses_no_digits(run):
    description = robots.of_chain(*["revolute"] * 40, axis=robots.unit(1, 1, 1), origin=formulas.transform(p=(0.1, 0, 0)))
    q = np.linspace(-3, 3, 40)
    found = run(probes.end_of_chain, q[:, None], 12, build_tree(description).chain("l40")).reshape(3, 4)
    assert_close(found, formulas.link_pose(description, q, "l40")[:3], atol=1e-13)
