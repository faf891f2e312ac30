"""Where a robot's links are, and how fast they move."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.robot.structure import Structure

Array = NDArray[np.float64]


class Kinematics(Structure):
    """Forward kinematics and Jacobians."""

    def forward_kinematics(self, q: ArrayLike, link: str | None = None) -> Array:
        """The pose of a link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.

        Returns:
            T_base_link, shape (..., 4, 4).
        """
        return self._forward.forward_kinematics(self.tree, q, self._the_tip if link is None else link)

    def link_poses(self, q: ArrayLike) -> Array:
        """The poses of all links, in the order of ``link_names``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).

        Returns:
            T_base_link, shape (..., n_links, 4, 4).
        """
        return self._forward.frame_poses(self.tree, self.tree.link_frames, q)

    def jacobian(self, q: ArrayLike, link: str | None = None, expressed_in: str = "base") -> Array:
        """The geometric Jacobian: the link's velocity for a unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``: velocity of the link's origin and angular velocity, in the axes of the base;
                ``"link"``: the same in the axes of the link (body twist); ``"spatial"``: velocity of the point that passes
                the base's origin, in the axes of the base.

        Returns:
            J, shape (..., 6, n_dof): rows v_x, v_y, v_z [m/s], w_x, w_y, w_z [rad/s].
        """
        return self._jacobian.geometric_jacobian(self.tree, q, self._the_tip if link is None else link, expressed_in)

    def analytical_jacobian(self, q: ArrayLike, link: str | None = None) -> Array:
        """The rates of x, y, z, roll, pitch and yaw of a link for a unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.

        Returns:
            Shape (..., 6, n_dof), rows in m/s and rad/s; R = Rz(yaw) Ry(pitch) Rx(roll).

        Raises:
            SingularityError: |cos(pitch)| < 1e-6 somewhere; ``rows`` lists where.
        """
        return self._jacobian.analytical_jacobian(self.tree, q, self._the_tip if link is None else link)

    def manipulability(self, q: ArrayLike, link: str | None = None) -> Array:
        """How well a link can be moved in all directions: sqrt(det(J J')), 0 at a singularity (Yoshikawa 1985).

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.

        Returns:
            Shape (...,): the volume of the ellipsoid of velocities, up to a factor; of J' J for fewer than six joints.
        """
        return self._jacobian.manipulability(self.tree, q, self._the_tip if link is None else link)

    # The layers below are imported when first used: they load the compiler, which `import ulna` must not.

    @cached_property
    def _forward(self):
        from ulna.kinematics import forward

        return forward

    @cached_property
    def _jacobian(self):
        from ulna.kinematics import jacobian

        return jacobian
