"""Row i of a batch is the same to the last bit whatever the batch's length, the row's place in it, and the axes of the batch."""

import numpy as np
import pytest

import ulna
from assertions import assert_close

N = 37
WORLD = ulna.World()
for k, xyz in enumerate([(0.4, 0.2, 0.5), (-0.3, 0.3, 0.8), (0.2, -0.5, 0.2)]):
    WORLD.add(f"box {k}", ulna.Box((0.2, 0.3, 0.25)), ulna.pose(xyz, (0.3 * k, 1.0, -k)))

QUERIES = {
    "forward_kinematics": lambda robot, q: robot.forward_kinematics(q),
    "forward_kinematics of a link": lambda robot, q: robot.forward_kinematics(q, link="panda_link4"),
    "link_poses": lambda robot, q: robot.link_poses(q),
    "jacobian": lambda robot, q: robot.jacobian(q),
    "jacobian in the link": lambda robot, q: robot.jacobian(q, expressed_in="link"),
    "spatial jacobian": lambda robot, q: robot.jacobian(q, expressed_in="spatial"),
    "analytical_jacobian": lambda robot, q: robot.analytical_jacobian(q),
    "in_collision": lambda robot, q: robot.in_collision(q, WORLD),
    "collision_poses": lambda robot, q: robot.collision_poses(q),
}
ENTRY_SHAPES = {
    "forward_kinematics": (4, 4),
    "forward_kinematics of a link": (4, 4),
    "link_poses": (10, 4, 4),
    "collision_poses": (12, 4, 4),
    "in_collision": (),
}
SHAPES = [(), (1,), (8,), (9,), (2, 3), (2, 1, 4), (1, 1, 1, 5), (0,), (2, 0), (0, 3), (2, 0, 3)]
TARGET_QUERIES = {
    "from home": {},
    "with a seed": {"q_seed": np.array([0.1, -0.5, 0.2, -1.8, 0.1, 1.4, 0.5])},
    "with a posture": {"posture": np.array([0.0, 0.3, 0.0, -1.5, 0.0, 1.8, 0.7]), "max_iterations": 100},
    "within a step": {"q_seed": np.array([0.1, -0.5, 0.2, -1.8, 0.1, 1.4, 0.5]), "max_step": 1.5, "max_iterations": 400},
    "a position": {"task": "position", "rank": "mid_range"},
}
FIELDS = ("q", "success", "status", "position_error", "rotation_error", "iterations", "starts", "reach_excess")


@pytest.fixture(scope="module")
def q(panda):
    return np.random.default_rng(3).uniform(panda.lower, panda.upper, (N, 7))


@pytest.fixture(scope="module")
def targets(panda, q):
    return panda.forward_kinematics(q)


def assert_same_bits(a, b):
    assert a.dtype == b.dtype
    assert a.shape == b.shape
    assert a.tobytes() == b.tobytes()


def assert_same_results(a, b):
    for field in FIELDS:
        assert_same_bits(np.asarray(getattr(a, field)), np.asarray(getattr(b, field)))


def entry_shape(name):
    return ENTRY_SHAPES.get(name, (6, 7))


@pytest.mark.parametrize("name", QUERIES)
def test_a_row_does_not_depend_on_its_neighbors(panda, q, rng, name):
    whole = QUERIES[name](panda, q)
    for start, stop in [(0, 1), (0, 7), (0, 8), (0, 9), (1, 9), (5, 6), (7, 8), (8, 16), (3, 30), (36, 37), (29, 37)]:
        assert_same_bits(QUERIES[name](panda, q[start:stop]), whole[start:stop])
    order = rng.permutation(N)
    assert_same_bits(QUERIES[name](panda, q[order]), whole[order])
    assert_same_bits(QUERIES[name](panda, q[::-1]), whole[::-1])
    assert_same_bits(QUERIES[name](panda, np.repeat(q[11:12], 13, axis=0)), np.repeat(whole[11:12], 13, axis=0))


@pytest.mark.parametrize("name", QUERIES)
def test_a_row_is_the_same_in_a_very_long_batch(panda, q, name):
    long = np.tile(q, (60, 1))
    assert_same_bits(QUERIES[name](panda, long), np.concatenate([QUERIES[name](panda, q)] * 60))


@pytest.mark.parametrize("name", QUERIES)
@pytest.mark.parametrize("shape", SHAPES)
def test_batch_axes_lead_and_come_back_unchanged(panda, q, name, shape):
    n = int(np.prod(shape))
    given = QUERIES[name](panda, q[:n].reshape(*shape, 7))
    assert np.shape(given) == shape + entry_shape(name)
    if shape:
        assert_same_bits(given.reshape(n, *entry_shape(name)), QUERIES[name](panda, q[:n]))


@pytest.mark.parametrize("name", QUERIES)
def test_one_configuration_is_a_batch_of_one(panda, q, name):
    batch = QUERIES[name](panda, q)
    ones = np.array([QUERIES[name](panda, x) for x in q])
    assert_close(ones, batch, atol=1e-14 if "analytical" not in name else 1e-11)  # which divides by cos(pitch)


def test_one_verdict_is_a_plain_bool(panda, q):
    verdicts = [panda.in_collision(x, WORLD) for x in q]
    assert {type(verdict) for verdict in verdicts} == {bool}
    assert {True, False} == set(verdicts)


@pytest.mark.parametrize("name", TARGET_QUERIES)
def test_a_target_is_solved_alike_in_any_company(panda, targets, rng, name):
    options = TARGET_QUERIES[name]
    whole = panda.inverse_kinematics(targets, **options)
    assert np.mean(whole.success) > 0.5 or "method" in options or "max_step" in options
    for chosen in [slice(0, 1), slice(3, 20), slice(36, 37), slice(None, None, -1), rng.permutation(N)]:
        part = panda.inverse_kinematics(targets[chosen], **options)
        for field in FIELDS:
            assert_same_bits(getattr(part, field), np.ascontiguousarray(getattr(whole, field)[chosen]))


def test_every_target_may_have_a_seed_of_its_own(panda, targets, q):
    seeds = np.clip(q + 0.05, panda.lower, panda.upper)
    whole = panda.inverse_kinematics(targets, q_seed=seeds)
    assert whole.success.all()
    for k in (0, 8, 36):
        alone = panda.inverse_kinematics(targets[k : k + 1], q_seed=seeds[k : k + 1])
        assert_same_bits(alone.q[0], whole.q[k])
        assert_same_bits(panda.inverse_kinematics(targets[k], q_seed=seeds[k]).q, whole.q[k])


@pytest.mark.parametrize("name", TARGET_QUERIES)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_axes_of_targets_come_back_unchanged(panda, targets, name, shape):
    n = int(np.prod(shape))
    s = panda.inverse_kinematics(targets[:n].reshape(*shape, 4, 4), **TARGET_QUERIES[name])
    assert s.q.shape == (*shape, 7)
    for field in FIELDS[1:]:
        assert np.shape(getattr(s, field)) == shape
    if n and (shape or name != "from home"):  # one target without a seed has all lanes: the first to arrive wins
        flat = panda.inverse_kinematics(targets[:n], **TARGET_QUERIES[name])
        assert_same_bits(s.q.reshape(n, 7), flat.q)
    assert isinstance(str(s), str)
