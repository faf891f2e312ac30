"""Defines the methods of a robot that compute forces: each calls one function of ``ulna.dynamics``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.dynamics.dynamics import Dynamics
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


class Forces:
    """The dynamics of a robot: torques, accelerations, the mass matrix, energies and their derivatives.

    Torques act at the joints [Nm, or N for slides], without friction, damping and the inertia of rotors. Attached objects and
    tools with a mass count. All methods raise ``InertiaError`` if a moving link has a shape but no inertia. They raise
    ``InputError`` for an argument that has another shape, is out of range or is not finite.
    """

    tree: Tree
    _dynamics: Dynamics

    @property
    def gravity(self) -> Array:
        """The gravitational acceleration in the axes of the base [m/s^2], shape (3,): by default (0, 0, -9.81)."""
        return self._dynamics.gravity

    @property
    def inertial_parameters(self) -> Array:
        """The ten inertial parameters of the body that each moving joint carries, in the joint's frame: shape (n_bodies, 10).

        They are the mass [kg], mass times center of mass x, y, z [kg m], and the tensor about the origin [kg m^2]. The tensor's
        order is xx, xy, xz, yy, yz, zz. The z axis of the frame lies along the joint's axis. Links joined by fixed joints form
        one body.
        """
        return self._dynamics.mechanism.bodies

    def inverse_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        gravity: ArrayLike | None = None,
        wrenches: Mapping[str, ArrayLike] | None = None,
        out: Array | None = None,
    ) -> Array:
        """The torques of a motion: M(q) qdd + C(q, qd) qd + g(q), minus the torques of external wrenches.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof); the batch axes of q, qd and qdd broadcast.
            qd: Joint velocities [rad/s or m/s], shape (..., n_dof).
            qdd: Joint accelerations [rad/s^2 or m/s^2], shape (..., n_dof).
            gravity: The gravitational acceleration in the axes of the base [m/s^2], shape (3,); the robot's unless given.
            wrenches: External wrenches by link: force [N] and moment [Nm] at the link's origin in the axes of the base, shape
                (..., 6).
            out: A float64 array of the result's shape, which is filled and returned.

        Returns:
            Torques [Nm or N], shape (..., n_dof).

        Raises:
            InertiaError: A moving link has a shape but no inertia.
            InputError: An argument has another shape, is out of range or is not finite, or ``out`` does not fit.
            UnknownNameError: A wrench names an unknown link.

        Example:
            >>> import ulna
            >>> arm = ulna.load("panda")
            >>> arm.inverse_dynamics(arm.home, np.zeros(arm.n_dof), np.zeros(arm.n_dof)).shape
            (7,)
        """
        if gravity is None and wrenches is None and out is None:
            return self._dynamics.one(q, qd, qdd)
        return self._dynamics.inverse((q, qd, qdd), gravity, wrenches, out)

    def gravity_torque(self, q: ArrayLike, *, gravity: ArrayLike | None = None, out: Array | None = None) -> Array:
        """The torques that hold the robot still [Nm or N], shape (..., n_dof), for q of shape (..., n_dof)."""
        return self._dynamics.gravity_torque(q, gravity, out)

    def payload(
        self,
        q: ArrayLike,
        qd: ArrayLike | None = None,
        qdd: ArrayLike | None = None,
        *,
        com: ArrayLike = (0.0, 0.0, 0.0),
        link: str | None = None,
        torque: ArrayLike = True,
        gravity: ArrayLike | None = None,
        by_joint: bool = False,
    ) -> Any:
        """The maximum payload: the largest point mass [kg] that the motors can hold or move; shape (...).

        Torques are linear in the mass, so the result is exact. It is 0 where the motors cannot hold the robot without a payload,
        and infinite where the payload needs no torque.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            qd: Joint velocities [rad/s or m/s], shape (..., n_dof); 0 unless given.
            qdd: Joint accelerations [rad/s^2 or m/s^2], shape (..., n_dof); 0 unless given.
            com: The position of the mass in the frame of the link [m], shape (3,).
            link: The link that carries the mass; the tip unless given.
            torque: The torque limits: True for the description's effort limits, or numbers above 0 [Nm or N], one or shape
                (n_dof,).
            gravity: The gravitational acceleration in the axes of the base [m/s^2], shape (3,); the robot's unless given.
            by_joint: Whether to return the payload that each joint alone would allow, shape (..., n_dof).

        Raises:
            InertiaError: A moving link has a shape but no inertia.
            InputError: An argument has another shape, is out of range or is not finite. Or the description has no effort limit
                above 0 for a joint.
            UnknownNameError: There is no such link.

        Example:
            >>> import ulna
            >>> arm = ulna.load("panda")
            >>> bool(arm.payload(arm.home, com=(0, 0, 0.1)) > 3.0)
            True
        """
        each = self._dynamics.payload({"q": q, "qd": qd, "qdd": qdd}, (link, com), torque, gravity)
        return each if by_joint else each.min(axis=-1, initial=np.inf)

    def coriolis_torque(self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None) -> Array:
        """The torques of the Coriolis and centrifugal forces at a velocity, C(q, qd) qd [Nm or N], shape (..., n_dof)."""
        return self._dynamics.inverse((q, qd, np.zeros(self.tree.n_dof)), np.zeros(3), None, out)

    def mass_matrix(self, q: ArrayLike, *, out: Array | None = None) -> Array:
        """The mass matrix M(q), shape (..., n_dof, n_dof): symmetric, and positive definite if each joint moves a mass.

        For a robot at rest without gravity, torques are M(q) times accelerations. Units: kg m^2 for two revolute joints, kg for
        two slides, kg m for one of each.
        """
        return self._dynamics.mass_matrix(q, out)

    def forward_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        torque: ArrayLike,
        *,
        gravity: ArrayLike | None = None,
        wrenches: Mapping[str, ArrayLike] | None = None,
        out: Array | None = None,
    ) -> Array:
        """The joint accelerations [rad/s^2 or m/s^2], shape (..., n_dof), that torques [Nm or N] cause.

        It is the inverse of ``inverse_dynamics`` and takes the same arguments, with torques in place of accelerations.

        Raises:
            SingularityError: The mass matrix is singular: some joint motion moves no mass. The error's ``rows`` lists where.
        """
        return self._dynamics.forward(q, qd, torque, (gravity, wrenches, out))

    def inverse_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike | None = None, out: Array | None = None
    ) -> tuple[Array, Array]:
        """The derivatives of ``inverse_dynamics`` with respect to q and to qd, shape (..., n_dof, n_dof) each.

        Entry (r, c) is the derivative of torque r with respect to entry c. The derivative with respect to qdd is ``mass_matrix``.
        ``out``, a float64 array of shape (2, ..., n_dof, n_dof), is filled with both if given, which saves an allocation.
        """
        return self._dynamics.derivatives((q, qd, qdd), gravity, out)

    def external_torque(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, measured: ArrayLike, *, gravity: ArrayLike | None = None
    ) -> Array:
        """The external torques: measured torques minus the torques of the motion [Nm or N], shape (..., n_dof).

        A contact with the wrench w at a link with the Jacobian J gives -J' w.
        """
        return self._dynamics.external(measured, (q, qd, qdd), gravity)

    def center_of_mass(self, q: ArrayLike, *, out: Array | None = None) -> Array:
        """The center of mass of all moving bodies [m], in the frame of the base, shape (..., 3)."""
        return self._dynamics.center_of_mass(q, out)

    def center_of_mass_jacobian(self, q: ArrayLike) -> Array:
        """The Jacobian of the center of mass, in the axes of the base, shape (..., 3, n_dof)."""
        return self._dynamics.center_of_mass_jacobian(q)

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike) -> Any:
        """The kinetic energy 1/2 qd' M(q) qd [J], shape (...)."""
        return self._dynamics.kinetic_energy(q, qd)

    def potential_energy(self, q: ArrayLike, *, gravity: ArrayLike | None = None) -> Any:
        """The potential energy of all moving bodies [J], shape (...); zero for a body at the origin of the base."""
        return self._dynamics.potential_energy(q, gravity)

    def operational_inertia(self, q: ArrayLike, *, link: str | None = None) -> Array:
        """The operational-space inertia of a link, (J M^-1 J')^-1, shape (..., 6, 6), in the axes of the base.

        The linear part comes first.

        Source: Khatib, A unified approach for motion and force control of robot manipulators (IEEE J. Robotics Automation 1987).

        Raises:
            SingularityError: The joints cannot move the link in every direction. The error's ``rows`` lists where.
        """
        return self._dynamics.operational_inertia(q, self.tree.link_or_tip(link))

    def regressor(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike | None = None) -> Array:
        """The regressor: the torques per unit of each inertial parameter, shape (..., n_dof, n_bodies, 10).

        Its product with ``inertial_parameters``, summed over the last two axes, is ``inverse_dynamics``. It serves to identify
        inertias from measured torques.

        Source: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (IJRR 1986).
        """
        return self._dynamics.regressor(q, qd, qdd, gravity)
