"""Implements ``ulna.jax``: functions of q for JAX.

The CPU computes them in float64, by ``jax.pure_callback``: arrays on a GPU are copied to the host and back. Batch axes lead.
Results have the type of q, which is float32 unless ``jax.config.update("jax_enable_x64", True)`` was called. JAX may run a
callback in another thread, where the context ``jax.enable_x64()`` has no effect: such a float64 is refused.

``jax.jit``, ``jax.vmap`` and ``jax.grad`` may be combined. Gradients are of any order for poses and Jacobians, and of first order
for distances. JAX refuses forward-mode differentiation (``jax.jacfwd``, ``jax.hessian``); use ``jax.jacrev`` twice.
"""

# Without an installed JAX, Pyright takes `jax` for ulna.jax.
# pyright: reportAttributeAccessIssue=false, reportInvalidTypeForm=false, reportMissingImports=false
# pyright: reportFunctionMemberAccess=false

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.errors import InputError, needs_extra
from ulna.kinematics.positions import refuse_out_of_range
from ulna.learning import functions
from ulna.learning.functions import FunctionOfQ
from ulna.robot import Robot

with needs_extra("ulna.jax", "jax", "jax", "jaxlib"):
    import jax
    import jax.numpy as jnp
    from jax.core import Tracer

Array = jax.Array


def forward_kinematics(robot: Robot, q: Array, *, link: str | None = None) -> Array:
    """The pose of a link, T_base_link, shape (..., 4, 4).

    Args:
        robot: The robot.
        q: Joint positions [rad or m], float32 or float64, shape (..., n_dof).
        link: The link's name; by default the tip.

    Raises:
        InputError: q is no such array, has another shape or an entry out of range, or the robot has several tips and no link is
            named. Within a transformation of JAX, numbers are known only at run time: then an entry out of range is a
            ``jax.errors.JaxRuntimeError``, which quotes this error.
        UnknownNameError: There is no such link.
    """
    return _evaluate_array(functions.poses(robot, link), q)


def jacobian(robot: Robot, q: Array, *, link: str | None = None, expressed_in: str = "base") -> Array:
    """The geometric Jacobian, shape (..., 6, n_dof), linear rows first; see ``Robot.jacobian``.

    Args:
        robot: The robot.
        q: Joint positions [rad or m], float32 or float64, shape (..., n_dof).
        link: The link's name; by default the tip.
        expressed_in: ``"base"``, ``"link"`` or ``"spatial"``.

    Raises:
        InputError: As ``forward_kinematics``; or ``expressed_in`` is not a frame.
        UnknownNameError: There is no such link.
    """
    return _evaluate_array(functions.jacobians(robot, link, expressed_in), q)


def signed_distance(robot: Robot, q: Array, world: World | None = None, *, self_collision: bool = True) -> Array:
    """The minimum distance of the robot from a world and from itself [m], shape (...,); see ``Robot.signed_distance``.

    Its gradient is ``robot.distance_gradient``. If two pairs are equally near, or a pair has several nearest points, the gradient
    belongs to one of them. It is zero if there is nothing to measure to.

    Args:
        robot: The robot.
        q: Joint positions [rad or m], float32 or float64, shape (..., n_dof).
        world: The objects; by default none. Under ``jax.jit`` too, their poses are those at run time.
        self_collision: Whether to measure between the robot's links too.

    Raises:
        InputError: As ``forward_kinematics``; there is nothing to check; or a second derivative is requested.
        GeometryError: The robot has no collision shapes, or some that cannot be checked.
    """
    return _evaluate_array(functions.distances(robot, world, self_collision), q)


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _evaluate(function: FunctionOfQ, q: Array) -> Any:
    """The results at q, in the type of q."""
    result = jax.ShapeDtypeStruct((*q.shape[:-1], *function.shape), q.dtype)
    return jax.pure_callback(partial(_on_host, function, q.dtype), result, q, vmap_method="broadcast_all")


def _on_host(function: FunctionOfQ, dtype: Any, q: Any) -> NDArray[Any]:
    q = np.asarray(q)
    if q.dtype != dtype:  # JAX rounded it
        remedy = 'jax.enable_x64() applies to one thread; jax.config.update("jax_enable_x64", True) applies to all'
        raise InputError("q", f"JAX passed {q.dtype} instead of {dtype}; {remedy}")
    out = np.empty((*q.shape[:-1], *function.shape))
    function.write(q.astype(np.float64), out)
    return out.astype(q.dtype)


def _forward(function: FunctionOfQ, q: Array) -> Any:
    value = _evaluate(function, q)
    return value, (q, value)


def _gradient(function: FunctionOfQ, kept: tuple[Array, Array], G: Array) -> tuple[Array]:
    return (function.gradient(_LIBRARY, *kept, G),)


_evaluate.defvjp(_forward, _gradient)


class _Library:
    """The operations of JAX that the gradients need."""

    evaluate = staticmethod(_evaluate)

    @staticmethod
    def cross(a: Array, b: Array) -> Array:
        return jnp.cross(a, b, axis=-2)

    @staticmethod
    def constant(numbers: NDArray[np.float64], like: Array) -> Array:
        return jnp.asarray(numbers, like.dtype)


_LIBRARY = _Library()


def _evaluate_array(function: functions.Poses | functions.Jacobians | functions.Distances, q: Array) -> Array:
    """The results at an array, which is checked first."""
    if not isinstance(function.robot, Robot):
        raise InputError("robot", "computes on a GPU; JAX's arrays go with a Robot, which computes on the CPU")
    if not isinstance(q, jax.Array | np.ndarray) or q.dtype not in {np.dtype(np.float32), np.dtype(np.float64)}:
        what = f"an array of {q.dtype}" if isinstance(q, jax.Array | np.ndarray) else type(q).__name__
        raise InputError("q", f"{what}; an array of float32 or float64 is expected")
    functions.refuse_shape(function.robot, q.shape)
    if not isinstance(q, Tracer):
        refuse_out_of_range(np.asarray(q))
    return _evaluate(function, jnp.asarray(q))
