"""Positions and targets may come as any array of numbers; they are never changed, and answers share no memory with them."""

import tempfile

import numpy as np
import pytest

import robots
import ulna

WORLD = ulna.World()
WORLD.add("crate", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.4, 0.0, 0.4)))
QUERIES = {
    "forward_kinematics": lambda robot, q: robot.forward_kinematics(q),
    "link_poses": lambda robot, q: robot.link_poses(q),
    "jacobian": lambda robot, q: robot.jacobian(q),
    "analytical_jacobian": lambda robot, q: robot.analytical_jacobian(q),
    "in_collision": lambda robot, q: robot.in_collision(q, WORLD),
    "collision_poses": lambda robot, q: robot.collision_poses(q),
}
Q = np.round(np.random.default_rng(5).uniform(-1, 1, (6, 7)) * 64) / 64  # exact as float32, too


def strided(q):
    wide = np.full((*q.shape[:-1], 3 * q.shape[-1]), np.nan)
    wide[..., 1::3] = q
    return wide[..., 1::3]


def negative(q):
    return q[::-1].copy()[::-1]


def read_only(q):
    q = q.copy()
    q.setflags(write=False)
    return q


def mapped(q):
    with tempfile.TemporaryFile() as file:
        file.write(q.tobytes())
        file.flush()
        return np.memmap(file, np.float64, "r", shape=q.shape)


class Lender:
    """Gives its array to read, not to write, as those of other libraries do."""

    def __init__(self, q):
        self.q = read_only(q)

    def __array__(self, dtype=None, copy=None):
        return self.q

    def __getitem__(self, row):
        return Lender(self.q[row])


FORMS = {
    "Fortran order": np.asfortranarray,
    "every third column": strided,
    "negative strides": negative,
    "read-only": read_only,
    "read-only memory map": mapped,
    "read-only by __array__": Lender,
    "float32": np.float32,
    "longdouble": np.longdouble,
    "big-endian": lambda q: q.astype(">f8"),
    "unaligned": lambda q: np.frombuffer(b"\0" + q.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(q.shape),
    "list": lambda q: q.tolist(),
    "tuple": lambda q: tuple(map(tuple, q.tolist())),
    "list of arrays": list,
}


@pytest.mark.parametrize("name", QUERIES)
@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_an_array_gives_the_same_bits(panda, name, form):
    given = QUERIES[name](panda, FORMS[form](Q))
    assert np.asarray(given).tobytes() == QUERIES[name](panda, Q).tobytes()
    assert np.asarray(QUERIES[name](panda, FORMS[form](Q)[2])).tobytes() == np.asarray(QUERIES[name](panda, Q[2])).tobytes()


@pytest.mark.parametrize("name", QUERIES)
def test_whole_numbers_and_truth_values_are_numbers(panda, name):
    for kind in (np.int32, np.uint8, bool):
        q = np.array([[0, 1, 0, 1, 1, 0, 1]] * 3, dtype=kind)
        assert np.asarray(QUERIES[name](panda, q)).tobytes() == QUERIES[name](panda, q.astype(float)).tobytes()


@pytest.mark.parametrize("name", QUERIES)
def test_a_broadcast_batch_is_a_batch(panda, name):
    q = np.broadcast_to(Q[1], (2, 5, 7))
    assert QUERIES[name](panda, q).tobytes() == QUERIES[name](panda, q.copy()).tobytes()


@pytest.mark.parametrize("name", QUERIES)
def test_positions_are_not_changed_and_not_shared(panda, name):
    q = Q.copy()
    first = QUERIES[name](panda, q)
    kept = first.copy()
    assert np.array_equal(q, Q)
    assert not np.shares_memory(first, q)
    QUERIES[name](panda, q + 0.1)
    assert np.array_equal(first, kept), "a later call wrote into an earlier answer"
    assert first.flags.writeable


def test_targets_seeds_and_postures_are_not_changed_and_not_shared(panda):
    T, seed, posture = panda.forward_kinematics(Q), Q + 5.0, np.full(7, 0.5)  # the seeds lie beyond the limits
    kept = T.copy(), seed.copy(), posture.copy()
    s = panda.inverse_kinematics(T, q_seed=seed, max_iterations=30, posture=posture)
    assert all(np.array_equal(a, b) for a, b in zip((T, seed, posture), kept, strict=True))
    assert not np.shares_memory(s.q, seed)
    home = panda.home.copy()
    still = panda.inverse_kinematics(T[0], max_iterations=0)
    still.q[:] = 7.0
    assert np.array_equal(panda.home, home)


@pytest.mark.parametrize("form", [form for form in FORMS if form != "float32"])
def test_targets_may_have_any_form(panda, form):
    T = panda.forward_kinematics(Q)
    assert panda.inverse_kinematics(FORMS[form](T)).q.tobytes() == panda.inverse_kinematics(T).q.tobytes()


def test_a_target_in_float32_is_a_pose_to_its_own_precision(panda):
    s = panda.inverse_kinematics(panda.forward_kinematics(Q).astype(np.float32))
    assert s.success.all()


def test_a_world_keeps_copies_of_its_poses():
    world, T = ulna.World(), ulna.pose((1, 2, 3))
    world.add("crate", ulna.Box((1, 1, 1)), T)
    T[0, 3] = 99.0
    world.pose("crate")[1, 3] = 99.0
    assert np.array_equal(world.pose("crate"), ulna.pose((1, 2, 3)))


def test_a_robot_keeps_copies_of_what_it_is_made_of():
    origin, axis, home = np.eye(4), np.array([0.0, 0.0, 1.0]), np.array([0.5])
    robot = ulna.Robot(robots.two_links("revolute", axis, origin=origin), home=home)
    before = robot.forward_kinematics([0.3])
    origin[0, 3], axis[:], home[:] = 5.0, 0.0, 9.0
    assert np.array_equal(robot.forward_kinematics([0.3]), before)
    assert robot.home[0] == 0.5
