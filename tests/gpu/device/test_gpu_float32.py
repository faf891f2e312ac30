"""``robot.on_gpu(float32=True)`` against the robot on the CPU: on a GPU, or with simulated threads.

The numbers of these are float32 too. See ``test_gpu_robot.py``. What is compared is exact for the same float32 joint positions.
"""

import os

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import ulna

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"
N = 12 if SIMULATED else 100_000
POSE, JACOBIAN = 1e-6, 1e-6  # of poses and Jacobians of the Panda [m, and sines], as docs/gpu_explained.md says
SURE = 1e-3  # m; of the sizes of two boxes, some 1 m: further apart, or deeper in each other, the verdict is that of float64
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)


@pytest.fixture(scope="module")
def on_gpu(panda):
    return panda.on_gpu(float32=True)


@pytest.fixture
def q(panda):
    """What a float32 holds exactly."""
    q = np.random.default_rng(3).uniform(panda.lower, panda.upper, (N, panda.n_dof))
    return q.astype(np.float32).astype(np.float64)


def test_poses_and_jacobians_are_float32_and_right_to_a_few_of_its_units(panda, on_gpu, q):
    T, J, frames = on_gpu.forward_kinematics(q), on_gpu.jacobian(q), on_gpu.link_poses(q)
    assert {T.dtype, J.dtype, frames.dtype} == {np.dtype(np.float32)}
    np.testing.assert_allclose(T, panda.forward_kinematics(q), rtol=0, atol=POSE)
    np.testing.assert_allclose(frames, panda.link_poses(q), rtol=0, atol=POSE)
    np.testing.assert_allclose(J, panda.jacobian(q), rtol=0, atol=JACOBIAN)
    assert np.abs(T - panda.forward_kinematics(q)).max() > 1e-9, "it is not computed in float64"


def boxes(*turns):
    """A world of boxes, each turned: by 0 all edges are parallel to each other."""
    rng, world = np.random.default_rng(4), ulna.World()
    for k in range(20):
        turn = rng.choice(turns) * rng.uniform(-1, 1, 3)
        world.add(f"box {k}", ulna.Box(rng.uniform(0.02, 0.2, 3)), ulna.pose(rng.uniform(-0.8, 0.8, 3), turn))
    return world


@pytest.mark.parametrize("turns", [(3.0,), (0.0, 1e-3, 1e-4, 1e-6)], ids=["any way", "nearly parallel"])
def test_collisions_of_boxes_are_those_of_float64_away_from_contact(panda, on_gpu, q, turns):
    world = boxes(*turns)
    far = np.abs(panda.signed_distance(q, world)) > SURE
    assert far.any()
    assert (on_gpu.in_collision(q, world) == panda.in_collision(q, world))[far].all()


def test_other_shapes_distances_and_searches_are_computed_in_float64(panda, on_gpu, q):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.2), ulna.pose((0.4, 0.2, 0.5)))
    far = np.abs(panda.signed_distance(q, world)) > 1e-9
    assert (on_gpu.in_collision(q, world) == panda.in_collision(q, world))[far].all()
    np.testing.assert_allclose(on_gpu.signed_distance(q[:3]), panda.signed_distance(q[:3]), rtol=0, atol=1e-9)
    T = panda.forward_kinematics(q[:3])
    found = on_gpu.inverse_kinematics(T)
    assert found.q.dtype == np.float64
    np.testing.assert_allclose(panda.forward_kinematics(found.q)[:, :3, 3], T[:, :3, 3], atol=1e-5)


def test_arrays_of_float32_stay_on_the_device(panda, on_gpu, q):
    there = cuda.to_device(q.astype(np.float32))
    T = on_gpu.forward_kinematics(there)
    assert T.dtype == np.float32
    np.testing.assert_allclose(T.copy_to_host(), panda.forward_kinematics(q), rtol=0, atol=POSE)
    assert on_gpu.in_collision(there, boxes(3.0)).copy_to_host().shape == (N,)
    np.testing.assert_allclose(on_gpu.signed_distance(there[:2]).copy_to_host(), panda.signed_distance(q[:2]), atol=1e-9)
    found = on_gpu.inverse_kinematics(T[:2])
    assert found.success.all()
    np.testing.assert_allclose(panda.forward_kinematics(found.q.copy_to_host()), T.copy_to_host()[:2], atol=1e-4)
    with pytest.raises(ulna.InputError, match="float32 of shape"):
        on_gpu.forward_kinematics(cuda.to_device(q))
    with pytest.raises(ulna.InputError, match="float64 of shape"):
        panda.on_gpu().forward_kinematics(there)


def test_what_is_out_of_range_is_refused_by_name(on_gpu, q):
    for bad in (np.nan, 2e6) if SIMULATED else (np.nan, np.inf, 2e6, 1e300):
        q[2, 3] = bad
        with pytest.raises(ulna.InputError, match=r"q\[2, 3\]"):
            on_gpu.forward_kinematics(q)
