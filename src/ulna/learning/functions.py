"""Defines functions of q with gradients, for any library of arrays.

``write`` evaluates a function with NumPy's arrays, or with the library's own on a GPU. ``gradient`` computes the function's
gradient. It uses only the library's operations, and calls other functions of q through the library. So the gradient can be
differentiated again.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_switch
from ulna.errors import InputError
from ulna.kernels.layout import COLUMN, FIXED, KIND
from ulna.kinematics.jacobian import CompiledJacobian, as_frame
from ulna.kinematics.positions import as_positions, refuse_out_of_range
from ulna.kinematics.tree import Tree
from ulna.learning.gradients import Library, jacobian_gradient, pose_gradient
from ulna.robot import Robot


class FunctionOfQ(Protocol):
    """A function of q, shape (..., n_dof)."""

    on_host: bool
    """Whether the CPU computes it, even for a q on a GPU."""

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of one result."""
        ...

    def write(self, q: Any, out: Any) -> None:
        """Write the results, float64 of shape (..., *shape)."""
        ...

    def gradient(self, library: Library, q: Any, value: Any, G: Any) -> Any:
        """The gradient by q, shape (..., n_dof), for the cotangent G of the results."""
        ...


@dataclass(frozen=True, eq=False)
class Poses:
    """``robot.forward_kinematics`` of a link."""

    robot: Any
    link: str
    on_host = False
    shape = (4, 4)

    def write(self, q: Any, out: Any) -> None:
        self.robot.forward_kinematics(q, link=self.link, out=out)

    def gradient(self, library: Library, q: Any, value: Any, G: Any) -> Any:
        J = library.evaluate(Jacobians(self.robot, self.link, "base"), q)
        return pose_gradient(library, value, J, G)


@dataclass(frozen=True, eq=False)
class Jacobians:
    """``robot.jacobian`` of a link: a column for each entry of q."""

    robot: Any
    link: str
    expressed_in: str
    on_host = False

    @property
    def shape(self) -> tuple[int, ...]:
        return 6, host_of(self.robot).n_dof

    def write(self, q: Any, out: Any) -> None:
        self.robot.jacobian(q, link=self.link, expressed_in=self.expressed_in, out=out)

    def gradient(self, library: Library, q: Any, value: Any, G: Any) -> Any:
        by_joint = JointJacobians(host_of(self.robot), self.link, self.expressed_in)
        if by_joint.is_plain:
            return jacobian_gradient(library, value, G, self.expressed_in)
        drives = library.constant(by_joint.drives, G)
        J = library.evaluate(by_joint, q)
        return jacobian_gradient(library, J, G @ drives.swapaxes(-1, -2), self.expressed_in) @ drives


@dataclass(frozen=True, eq=False)
class JointJacobians:
    """The Jacobian with a column for each moving joint between the base and a link, in that order.

    Several mimic joints may follow one entry of q. ``jacobian`` adds up their columns, but the derivative needs each one.
    """

    robot: Any
    link: str
    expressed_in: str
    on_host = True

    @cached_property
    def drives(self) -> NDArray[np.float64]:
        """Selection of the entry of q that drives each joint: ones and zeros, shape (k, n_dof)."""
        return np.eye(self.robot.tree.n_dof)[self._columns]

    @property
    def is_plain(self) -> bool:
        """Whether it equals ``robot.jacobian``: each entry of q drives one joint, in order."""
        return np.array_equal(self._columns, np.arange(self.robot.tree.n_dof))

    @property
    def shape(self) -> tuple[int, ...]:
        return 6, len(self._columns)

    def write(self, q: Any, out: Any) -> None:
        q = as_positions(q, self.robot.tree)
        refuse_out_of_range(q)
        CompiledJacobian(self._tree, self.link, self.expressed_in)(q[..., self._columns], out)

    def gradient(self, library: Library, q: Any, value: Any, G: Any) -> Any:  # noqa: ARG002 - the interface's signature
        return jacobian_gradient(library, value, G, self.expressed_in) @ library.constant(self.drives, G)

    @cached_property
    def _columns(self) -> NDArray[np.int64]:
        chain = self.robot.tree.chain(self.link)
        return chain[chain[:, KIND] != FIXED, COLUMN].astype(np.int64)

    @cached_property
    def _tree(self) -> Tree:
        """The chain to the link with an entry of q for each of its joints."""
        chain, k = self.robot.tree.chain(self.link).copy(), len(self._columns)
        chain[chain[:, KIND] != FIXED, COLUMN] = np.arange(k)
        return replace(self.robot.tree, lower=np.full(k, -np.inf), upper=np.full(k, np.inf), _chains={self.link: chain})


@dataclass(frozen=True, eq=False)
class Distances:
    """``robot.signed_distance``."""

    robot: Any
    world: World | None
    self_collision: bool
    on_host = False
    shape = ()

    def write(self, q: Any, out: Any) -> None:
        self.robot.signed_distance(q, self.world, self_collision=self.self_collision, out=out)

    def gradient(self, library: Library, q: Any, value: Any, G: Any) -> Any:  # noqa: ARG002 - the interface's signature
        return library.evaluate(DistanceGradients(host_of(self.robot), self.world, self.self_collision), q) * G[..., None]


@dataclass(frozen=True, eq=False)
class DistanceGradients:
    """``robot.distance_gradient``, which has no derivative here."""

    robot: Any
    world: World | None
    self_collision: bool
    on_host = True

    @property
    def shape(self) -> tuple[int, ...]:
        return (self.robot.tree.n_dof,)

    def write(self, q: Any, out: Any) -> None:
        self.robot.distance_gradient(q, self.world, self_collision=self.self_collision, out=out)

    def gradient(self, library: Library, q: Any, value: Any, G: Any) -> Any:
        del library, q, value, G
        raise InputError("signed_distance", "has first derivatives only, not second ones")


def poses(robot: Any, link: str | None) -> Poses:
    """The poses of a link; checks its name."""
    return Poses(robot, _link(robot, link))


def jacobians(robot: Any, link: str | None, expressed_in: str) -> Jacobians:
    """The Jacobians of a link in a frame; checks both names."""
    as_frame(expressed_in)
    return Jacobians(robot, _link(robot, link), expressed_in)


def distances(robot: Any, world: World | None, self_collision: object) -> Distances:
    """The distances of a robot from a world."""
    host_of(robot)
    return Distances(robot, world, as_switch("self_collision", self_collision))


def host_of(robot: Any) -> Robot:
    """The robot on the CPU: itself, or the robot behind its twin on a GPU.

    Raises:
        InputError: It is neither, or computes in float32.
    """
    host = robot if isinstance(robot, Robot) else getattr(robot, "robot", None)
    if not isinstance(host, Robot):
        raise InputError("robot", f"{type(robot).__name__}; a Robot, or the result of robot.on_gpu(), is expected")
    if getattr(robot, "float32", False):
        raise InputError("robot", "computes in float32; robot.on_gpu() without float32=True is expected")
    return host


def refuse_shape(robot: Any, shape: tuple[int, ...]) -> None:
    """Refuse a q of another shape than (..., n_dof)."""
    tree = host_of(robot).tree
    if shape[-1:] != tree.q_shape:
        as_positions(np.empty(shape), tree)


def _link(robot: Any, link: str | None) -> str:
    tree = host_of(robot).tree
    name = tree.link_or_tip(link)
    tree.chain(name)  # raises an error for an unknown link
    return name
