"""Poses, Jacobians and distances of JAX's arrays against the robot's; gradients against PyTorch's and finite differences."""

import numpy as np
import pytest

pytest.importorskip("jax", reason="JAX is in an environment of its own: make test-learning")
pytest.importorskip("torch", reason="PyTorch is in an environment of its own: make test-learning")

import jax
import jax.numpy as jnp
import torch
from jax.test_util import check_grads

import ulna
import ulna.jax
import ulna.torch
from gradient_cases import FRAMES, case, crate
from ulna.learning import callbacks, functions

CASES = ["panda link", "mimics", "slides", "one floating"]  # the formulas are those that PyTorch uses for all of them


@pytest.fixture(autouse=True)
def _in_float64():
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


@pytest.mark.parametrize("name", CASES)
def test_poses_have_the_robots_numbers_and_first_and_second_derivatives(name):
    robot, link, q = case(name)

    def poses(x):
        return ulna.jax.forward_kinematics(robot, x, link=link)

    assert np.array_equal(poses(jnp.asarray(q)), robot.forward_kinematics(q, link=link))
    check_grads(poses, (jnp.asarray(q),), order=2, modes=("rev",), atol=1e-6, rtol=1e-6)


@pytest.mark.parametrize("expressed_in", FRAMES)
@pytest.mark.parametrize("name", CASES)
def test_the_gradients_of_jacobians_are_those_of_pytorch(name, expressed_in):
    robot, link, q = case(name)
    G = np.random.default_rng(1).normal(size=(2, 6, robot.n_dof))

    def number(x):
        return jnp.sum(G * ulna.jax.jacobian(robot, x, link=link, expressed_in=expressed_in) ** 2)

    x = torch.tensor(q, requires_grad=True)
    (torch.tensor(G) * ulna.torch.jacobian(robot, x, link=link, expressed_in=expressed_in) ** 2).sum().backward()
    assert np.allclose(jax.jit(jax.grad(number))(q), x.grad.numpy(), rtol=1e-12, atol=1e-12)


def test_distances_have_the_robots_numbers_and_a_derivative():
    robot, world = case("panda")[0], crate()
    q = robot.random(6, seed=3)

    def distance(x):
        return ulna.jax.signed_distance(robot, x, world)

    assert np.array_equal(jax.vmap(distance)(q), robot.signed_distance(q, world))
    check_grads(distance, (jnp.asarray(q),), order=1, modes=("rev",), atol=1e-6, rtol=1e-6)
    assert np.array_equal(jax.jit(jax.vmap(jax.grad(distance)))(q), robot.distance_gradient(q, world))
    with pytest.raises(ulna.InputError, match="signed_distance: has first derivatives only"):
        jax.jacrev(jax.grad(distance))(jnp.asarray(q[0]))


def test_a_compiled_function_sees_an_object_that_has_moved():
    robot, world = case("panda")[0], crate()
    distance = jax.jit(lambda x: ulna.jax.signed_distance(robot, x, world))
    before = distance(robot.home)
    world.move("ball", ulna.pose((0.45, 0.0, 0.6)))
    assert distance(robot.home) == robot.signed_distance(robot.home, world) != before


def test_transformations_nest():
    robot, _, q = case("panda", 3)

    def height(x):
        return ulna.jax.forward_kinematics(robot, x)[2, 3]

    assert np.allclose(jax.jit(jax.vmap(jax.grad(height)))(q), robot.jacobian(q)[:, 2])
    assert np.allclose(jax.vmap(jax.grad(height), in_axes=1)(q.T), robot.jacobian(q)[:, 2])
    second = jax.jit(jax.vmap(jax.jacrev(jax.jacrev(height))))(q)
    by_torch = torch.func.vmap(torch.func.jacrev(torch.func.jacrev(lambda x: ulna.torch.forward_kinematics(robot, x)[2, 3])))
    assert np.allclose(second, by_torch(torch.tensor(q)).numpy(), rtol=0, atol=1e-12)
    with pytest.raises(TypeError, match="forward-mode"):
        jax.hessian(height)(jnp.asarray(q[0]))


def test_without_x64_arrays_are_float32_and_the_work_is_in_float64():
    robot, _, q = case("panda", 3)
    with jax.enable_x64(False):
        x = jnp.asarray(q)
        T = ulna.jax.forward_kinematics(robot, x)
        assert x.dtype == T.dtype == np.float32
        assert jax.grad(lambda x: ulna.jax.signed_distance(robot, x).sum())(x).dtype == np.float32
    assert np.array_equal(T, robot.forward_kinematics(np.asarray(x, float)).astype(np.float32))


def test_a_large_batch_is_computed():
    robot = case("panda")[0]
    q = robot.random(100_000, seed=0)
    first = jax.jit(jax.grad(lambda x: ulna.jax.forward_kinematics(robot, x)[:, 0, 3].sum()))(q)
    assert np.allclose(first, robot.jacobian(q)[:, 0], rtol=0, atol=1e-14)


def test_what_cannot_be_taken_is_refused_by_name():
    robot, _, q = case("panda")
    with pytest.raises(ulna.InputError, match="q: list; an array of float32 or float64 is expected"):
        ulna.jax.forward_kinematics(robot, q.tolist())
    with pytest.raises(ulna.InputError, match="q: an array of int"):
        ulna.jax.forward_kinematics(robot, jnp.zeros(7, int))
    with pytest.raises(ulna.InputError, match=r"q: shape \(2, 6\), but shape \(..., 7\)"):
        jax.jit(lambda x: ulna.jax.jacobian(robot, x))(q[:, :6])
    with pytest.raises(ulna.InputError, match=r"q\[1, 2\]: nan is not a finite number"):
        ulna.jax.forward_kinematics(robot, jnp.asarray(q).at[1, 2].set(jnp.nan))
    with pytest.raises(ulna.InputError, match="expressed_in: 'bse' is not a frame"):
        ulna.jax.jacobian(robot, q, expressed_in="bse")
    with pytest.raises(ulna.UnknownNameError, match="panda_lnk4"):
        ulna.jax.forward_kinematics(robot, q, link="panda_lnk4")


def test_an_entry_out_of_range_in_a_compiled_function_is_quoted_by_jaxs_error():
    robot, _, q = case("panda")
    compiled = jax.jit(lambda x: ulna.jax.forward_kinematics(robot, x))
    with pytest.raises(jax.errors.JaxRuntimeError, match=r"q\[0, 0\]: nan is not a finite number"):
        compiled(q * jnp.nan).block_until_ready()


def test_numbers_that_jax_rounded_are_refused():
    robot, link, q = case("panda")
    with pytest.raises(ulna.InputError, match="q: JAX passed float32 instead of float64"):
        callbacks._on_host(functions.poses(robot, link), np.dtype(np.float64), q.astype(np.float32))
