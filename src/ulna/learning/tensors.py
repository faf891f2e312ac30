"""Implements ``ulna.torch``: functions of q for PyTorch.

A ``Robot`` reads tensors on the CPU in place; ``robot.on_gpu()`` reads and writes tensors on the GPU. Batch axes lead. Tensors of
float32 are computed in float64, and the results are float32.

Gradients are of any order for poses and Jacobians, and of first order for distances. ``torch.func`` may be used. PyTorch refuses
forward-mode differentiation.
"""

# Without an installed PyTorch, Pyright takes `torch` for ulna.torch.
# pyright: reportAttributeAccessIssue=false, reportInvalidTypeForm=false, reportMissingImports=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.errors import InputError, needs_extra
from ulna.learning import functions
from ulna.learning.functions import FunctionOfQ
from ulna.robot import Robot

with needs_extra("ulna.torch", "torch", "torch"):
    import torch

if TYPE_CHECKING:
    from ulna.gpu.robot import GpuRobot

Tensor = torch.Tensor


def forward_kinematics(robot: Robot | GpuRobot, q: Tensor, *, link: str | None = None) -> Tensor:
    """The pose of a link, T_base_link, shape (..., 4, 4).

    Args:
        robot: A ``Robot``, or the result of ``robot.on_gpu()``.
        q: Joint positions [rad or m], float32 or float64, shape (..., n_dof).
        link: The link's name; by default the tip.

    Raises:
        InputError: q is no such tensor, has another shape or an entry out of range, or is on another device than the robot; or
            the robot has several tips and no link is named.
        UnknownNameError: There is no such link.
    """
    return _evaluate_tensor(functions.poses(robot, link), q)


def jacobian(robot: Robot | GpuRobot, q: Tensor, *, link: str | None = None, expressed_in: str = "base") -> Tensor:
    """The geometric Jacobian, shape (..., 6, n_dof), linear rows first; see ``Robot.jacobian``.

    Args:
        robot: A ``Robot``, or the result of ``robot.on_gpu()``.
        q: Joint positions [rad or m], float32 or float64, shape (..., n_dof).
        link: The link's name; by default the tip.
        expressed_in: ``"base"``, ``"link"`` or ``"spatial"``.

    Raises:
        InputError: As ``forward_kinematics``; or ``expressed_in`` is not a frame.
        UnknownNameError: There is no such link.
    """
    return _evaluate_tensor(functions.jacobians(robot, link, expressed_in), q)


def signed_distance(robot: Robot | GpuRobot, q: Tensor, world: World | None = None, *, self_collision: bool = True) -> Tensor:
    """The minimum distance of the robot from a world and from itself [m], shape (...,); see ``Robot.signed_distance``.

    Its gradient is ``robot.distance_gradient``, computed by the CPU. If two pairs are equally near, or a pair has several nearest
    points, the gradient belongs to one of them. It is zero if there is nothing to measure to.

    Args:
        robot: A ``Robot``, or the result of ``robot.on_gpu()``.
        q: Joint positions [rad or m], float32 or float64, shape (..., n_dof).
        world: The objects; by default none. The gradient uses the objects' poses at the time of the backward pass.
        self_collision: Whether to measure between the robot's links too.

    Raises:
        InputError: As ``forward_kinematics``; there is nothing to check; or a second derivative is requested.
        GeometryError: The robot has no collision shapes, or some that cannot be checked.
    """
    return _evaluate_tensor(functions.distances(robot, world, self_collision), q)


class _Function(torch.autograd.Function):
    """A function of q for the tape of PyTorch."""

    @staticmethod
    def forward(function: FunctionOfQ, q: Tensor) -> Tensor:
        q, shape = q.detach().contiguous(), (*q.shape[:-1], *function.shape)
        is_there = q.is_cuda and not function.on_host
        out = torch.empty(shape, dtype=torch.float64, device=q.device if is_there else "cpu")
        if is_there:
            function.write(q, out)
        else:
            function.write(q.cpu().numpy(), out.numpy())
        return out.to(q.device)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[FunctionOfQ, Tensor], output: Tensor) -> None:
        ctx.function, q = inputs
        ctx.save_for_backward(q, output)

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> tuple[None, Tensor]:
        return None, ctx.function.gradient(_LIBRARY, *ctx.saved_tensors, *cotangents)

    @staticmethod
    def vmap(info: Any, in_dims: Any, *args: Any) -> tuple[Tensor, int]:  # noqa: ARG004 - PyTorch's interface
        function, q = args
        return _LIBRARY.evaluate(function, q.movedim(in_dims[1], 0)), 0


class _Library:
    """The operations of PyTorch that the gradients need."""

    @staticmethod
    def evaluate(function: FunctionOfQ, q: Tensor) -> Tensor:
        return _Function.apply(function, q)

    @staticmethod
    def cross(a: Tensor, b: Tensor) -> Tensor:
        return torch.linalg.cross(a, b, dim=-2)

    @staticmethod
    def constant(numbers: NDArray[np.float64], like: Tensor) -> Tensor:
        return torch.as_tensor(numbers, dtype=like.dtype, device=like.device)


_LIBRARY = _Library()


def _evaluate_tensor(function: functions.Poses | functions.Jacobians | functions.Distances, q: Tensor) -> Tensor:
    """The results at a tensor, in its type; the tensor is checked first."""
    if not isinstance(q, torch.Tensor) or q.dtype not in {torch.float32, torch.float64}:
        what = f"a tensor of {q.dtype}" if isinstance(q, torch.Tensor) else type(q).__name__
        raise InputError("q", f"{what}; a tensor of float32 or float64 is expected")
    on_gpu = functions.host_of(function.robot) is not function.robot
    if q.device.type not in ({"cpu", "cuda"} if on_gpu else {"cpu"}):
        remedy = "a Robot takes tensors on the CPU, and robot.on_gpu() those on an NVIDIA GPU"
        raise InputError("q", f"a tensor on {q.device}; {remedy}")
    functions.refuse_shape(function.robot, tuple(q.shape))
    return _LIBRARY.evaluate(function, q.to(torch.float64)).to(q.dtype)
