"""The methods of a robot that compute forces: each calls one function of ``ulna.dynamics``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.dynamics.dynamics import Dynamics
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


class Forces:
    """The dynamics of a robot: the torques of its motions, and what follows from them.

    Torques are those at the joints [Nm, or N for slides], without friction, damping and the inertia of rotors. Attached
    objects and tools that have a mass are part of the robot. All methods raise ``InertiaError`` where a link that moves has a
    shape and no inertia, and ``InputError`` for an argument that has another shape, is out of range or is not finite.
    """

    tree: Tree
    _dynamics: Dynamics

    @property
    def gravity(self) -> Array:
        """The acceleration of free fall in the axes of the base [m/s^2], shape (3,): by default (0, 0, -9.81)."""
        return self._dynamics.gravity

    @property
    def inertial_parameters(self) -> Array:
        """Ten numbers of the body that each moving joint carries, in the joint's frame: shape (n_bodies, 10).

        Mass [kg], mass times center of mass x, y, z [kg m], and the tensor about the origin xx, xy, xz, yy, yz, zz [kg m^2].
        The z axis of the frame lies along the joint's axis. Links that no joint moves against each other are one body.
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
        """The torques that a motion needs: M(q) qdd + C(q, qd) qd + g(q), less those of the wrenches.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof); qd and qdd may have other batch axes, to which these are
                broadcast.
            qd: Joint velocities [rad/s or m/s], shape (..., n_dof).
            qdd: Joint accelerations [rad/s^2 or m/s^2], shape (..., n_dof).
            gravity: The acceleration of free fall in the axes of the base [m/s^2], shape (3,); that of the robot unless given.
            wrenches: What acts on the robot from outside, by link: force [N] and moment [Nm] at the link's origin in the axes
                of the base, shape (..., 6).
            out: Written to and returned if given: a float64 array of the result's shape.

        Returns:
            Torques [Nm or N], shape (..., n_dof).

        Raises:
            InertiaError: A link that moves and has a shape has no inertia.
            InputError: An argument has another shape, is out of range or is not finite, or ``out`` does not fit.
            UnknownNameError: There is no link of a wrench.

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
        """The largest point mass [kg] that the motors hold still, or move, beside the robot itself; shape (...).

        Torques are linear in the mass, so it is exact. It is 0 where the motors cannot hold the robot without it, and infinite
        where no joint feels it.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            qd: Joint velocities [rad/s or m/s], shape (..., n_dof); 0 unless given.
            qdd: Joint accelerations [rad/s^2 or m/s^2], shape (..., n_dof); 0 unless given.
            com: Where the mass is, in the frame of the link [m], shape (3,).
            link: The link that carries it; the tip unless given.
            torque: The limits: True for those of the description, or numbers above 0 [Nm or N], one or shape (n_dof,).
            gravity: The acceleration of free fall in the axes of the base [m/s^2], shape (3,); that of the robot unless given.
            by_joint: Whether to return what each joint alone would bear, shape (..., n_dof).

        Raises:
            InertiaError: A link that moves and has a shape has no inertia.
            InputError: An argument has another shape, is out of range or is not finite; or the description states no effort above
                0 of a joint.
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
        """M(q), shape (..., n_dof, n_dof): symmetric, and positive definite where each joint moves a mass.

        Torques are M(q) times accelerations, for a robot at rest without gravity. Units: kg m^2 for two turning joints, kg m
        or kg for slides.
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

        The arguments are those of ``inverse_dynamics``, of which this is the inverse.

        Raises:
            SingularityError: The mass matrix is singular: some motion of the joints moves no mass. Its ``rows`` say where.
        """
        return self._dynamics.forward(q, qd, torque, (gravity, wrenches, out))

    def inverse_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike | None = None, out: Array | None = None
    ) -> tuple[Array, Array]:
        """The derivatives of ``inverse_dynamics`` by q and by qd, shape (..., n_dof, n_dof) each.

        Entry (r, c) is the derivative of torque r by entry c. The derivative by qdd is ``mass_matrix``. Both are written to
        ``out``, a float64 array of shape (2, ..., n_dof, n_dof), if it is given, which spares new memory.
        """
        return self._dynamics.derivatives((q, qd, qdd), gravity, out)

    def external_torque(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, measured: ArrayLike, *, gravity: ArrayLike | None = None
    ) -> Array:
        """The part of measured torques [Nm or N], shape (..., n_dof), that the robot's own motion does not explain.

        Of a contact with the wrench w at a link it is -J' w, with the Jacobian J of the link.
        """
        return self._dynamics.external(measured, (q, qd, qdd), gravity)

    def centre_of_mass(self, q: ArrayLike, *, out: Array | None = None) -> Array:
        """The center of mass of all bodies that joints move [m], in the frame of the base, shape (..., 3)."""
        return self._dynamics.centre_of_mass(q, out)

    def centre_of_mass_jacobian(self, q: ArrayLike) -> Array:
        """The velocity of the center of mass for a unit rate of each entry of q, in the axes of the base: (..., 3, n_dof)."""
        return self._dynamics.centre_of_mass_jacobian(q)

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike) -> Any:
        """1/2 qd' M(q) qd [J], shape (...)."""
        return self._dynamics.kinetic_energy(q, qd)

    def potential_energy(self, q: ArrayLike, *, gravity: ArrayLike | None = None) -> Any:
        """The energy in the field of gravity of all bodies that joints move [J], shape (...); 0 at the origin of the base."""
        return self._dynamics.potential_energy(q, gravity)

    def operational_inertia(self, q: ArrayLike, *, link: str | None = None) -> Array:
        """The inertia of a link as a wrench on it sees it, (J M^-1 J')^-1: shape (..., 6, 6), linear part first, in the base.

        Source: Khatib, A unified approach for motion and force control of robot manipulators (IEEE J. Robotics Automation 1987).

        Raises:
            SingularityError: The joints cannot move the link in every direction here. Its ``rows`` say where.
        """
        return self._dynamics.operational_inertia(q, self.tree.link_or_tip(link))

    def regressor(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike | None = None) -> Array:
        """The torques for a unit of each inertial parameter, in which they are linear: shape (..., n_dof, n_bodies, 10).

        Its product with ``inertial_parameters``, summed over the last two axes, is ``inverse_dynamics``. For the
        identification of inertias from measured torques.

        Source: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (IJRR 1986).
        """
        return self._dynamics.regressor(q, qd, qdd, gravity)
