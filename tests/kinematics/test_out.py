"""``out=``: every batch call writes its answer where it is told to, or says by name why not; nothing else is allocated."""

import subprocess
import sys

import numpy as np
import pytest

import ulna
from ulna.errors import InputError

WORLD = ulna.World()
WORLD.add("crate", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.4, 0.0, 0.4)))
CALLS = {
    "forward_kinematics": lambda robot, q, **out: robot.forward_kinematics(q, **out),
    "forward_kinematics of a link": lambda robot, q, **out: robot.forward_kinematics(q, link="panda_link4", **out),
    "link_poses": lambda robot, q, **out: robot.link_poses(q, **out),
    "jacobian": lambda robot, q, **out: robot.jacobian(q, expressed_in="spatial", **out),
    "analytical_jacobian": lambda robot, q, **out: robot.analytical_jacobian(q, **out),
    "manipulability": lambda robot, q, **out: robot.manipulability(q, **out),
    "differential_ik": lambda robot, q, **out: robot.differential_ik(q, [0.1, 0.2, 0.0, 0.0, 0.1, 0.0], 0.01, **out),
    "in_collision": lambda robot, q, **out: robot.in_collision(q, WORLD, **out),
    "signed_distance": lambda robot, q, **out: robot.signed_distance(q, WORLD, **out),
    "distance_gradient": lambda robot, q, **out: robot.distance_gradient(q, WORLD, **out),
    "collision_poses": lambda robot, q, **out: robot.collision_poses(q, **out),
}


@pytest.fixture(params=CALLS)
def call(request, panda):
    return lambda q, **out: CALLS[request.param](panda, q, **out)


@pytest.fixture
def q(panda, rng):
    return rng.uniform(panda.lower, panda.upper, (2, 5, 7))


def filled(answer):
    """An array of another content, to be written to."""
    answer = np.asarray(answer)
    return np.array(~answer) if answer.dtype == bool else np.full_like(answer, np.nan)


@pytest.mark.parametrize("part", [..., 0, (1, 3), slice(0, 0)], ids=["batch", "rows", "one", "none"])
def test_the_result_is_written_where_it_is_asked_for(call, q, part):
    expected = call(q[part])
    out = filled(expected)
    assert call(q[part], out=out) is out
    assert out.tobytes() == np.asarray(expected).tobytes()


def test_a_part_of_a_larger_array_will_do_and_the_rest_is_left_alone(call, q):
    expected = call(q)
    large = np.stack([filled(expected)] * 3)
    before = large.copy()
    call(q, out=large[1])
    assert large[1].tobytes() == expected.tobytes()
    assert large[::2].tobytes() == before[::2].tobytes()


def test_what_does_not_fit_is_refused_by_name_and_left_alone(call, q):
    right = filled(call(q))
    read_only = right.copy()
    read_only.setflags(write=False)
    faults = {
        "shape": right[:1].copy(),
        "one axis more": right[None].copy(),
        "float32": right.astype(np.float32),
        "other byte order": right.astype(right.dtype.newbyteorder()) if right.dtype != bool else right.astype(np.uint8),
        "order": np.asfortranarray(right),
        "strided": np.repeat(right, 2, axis=-1)[..., ::2],
        "read-only": read_only,
        "masked": np.ma.array(right),
        "list": right.tolist(),
    }
    for name, out in faults.items():
        kept = np.array(out)
        with pytest.raises(InputError, match=r"^out: "):
            call(q, out=out)
        assert np.array(out).tobytes() == kept.tobytes(), name


def test_an_array_that_is_not_aligned_is_refused_for_that(panda):
    out = np.zeros(16 * 8 + 8, np.uint8)[3 : 3 + 16 * 8].view(np.float64).reshape(4, 4)
    assert (out.flags.writeable, out.flags.c_contiguous, out.flags.aligned) == (True, True, False)
    with pytest.raises(InputError, match=r"^out: a writable, aligned, C-contiguous array is expected"):
        panda.forward_kinematics(panda.home, out=out)


def test_memory_of_q_is_refused(call, q):
    expected = call(q)
    block = np.zeros(expected.nbytes + q.nbytes, dtype=np.uint8)
    shared = block[: q.nbytes].view(np.float64).reshape(q.shape)
    shared[:] = q
    with pytest.raises(InputError, match=r"^out: shares memory"):
        call(shared, out=block[: expected.nbytes].view(expected.dtype).reshape(expected.shape))
    assert np.array_equal(shared, q)
    beside = block[q.nbytes :].view(expected.dtype).reshape(expected.shape)
    assert call(shared, out=beside).tobytes() == expected.tobytes()


def test_the_place_for_one_result_is_an_array_without_axes(panda):
    hit, distance = np.empty((), dtype=bool), np.empty(())
    assert panda.in_collision(panda.home, WORLD, out=hit) is hit
    assert panda.signed_distance(panda.home, WORLD, out=distance) is distance
    assert hit == panda.in_collision(panda.home, WORLD)
    assert distance == panda.signed_distance(panda.home, WORLD)


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="no resource module")
def test_a_million_poses_take_no_more_memory_than_their_result():
    code = """
import resource, sys
import numpy as np
import ulna
panda = ulna.load("panda")
q, out = np.ones((1_000_000, 7)), np.full((1_000_000, 4, 4), np.nan)
J = np.full((200_000, 6, 7), np.nan)
panda.forward_kinematics(q[:64]), panda.jacobian(q[:64])
def most():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform == "linux" else 1024**2)
before = most()
panda.forward_kinematics(q, out=out)
panda.jacobian(q[:200_000], out=J)
print(most() - before, np.isfinite(out).all() and np.isfinite(J).all())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    megabytes, finite = done.stdout.split()
    assert finite == "True"
    assert float(megabytes) < 10, "the answers alone are 128 and 67 MB"
