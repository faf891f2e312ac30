"""Where a robot's links are, and how fast they move."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.kinematics.forward import CompiledForward, frame_poses
from ulna.kinematics.jacobian import CompiledJacobian, analytical_jacobian, manipulability
from ulna.robot.structure import Structure

Array = NDArray[np.float64]


class Kinematics(Structure):
    """Forward kinematics and Jacobians."""

    def forward_kinematics(
        self, q: ArrayLike, link: str | None = None, *, out: Array | None = None, threads: int | None = None
    ) -> Array:
        """The pose of a link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: Written to and returned if given: a float64 array of the result's shape.
            threads: How many threads a large batch uses at most; ``ULNA_THREADS``, or one a processor, unless given.

        Returns:
            T_base_link, shape (..., 4, 4).
        """
        try:  # as compile_forward, but for one call of Python
            forward = self._forwards[link]
        except (KeyError, TypeError):
            forward = self.compile_forward(link)
        return forward(q, out, threads)

    def compile_forward(self, link: str | None = None) -> CompiledForward:
        """Forward kinematics of one link as a function ``fk(q, out=None, threads=None)`` for control loops: the same, sooner.

        Args:
            link: The link's name; the tip unless given.

        Returns:
            A function of q, shape (..., n_dof), that gives T_base_link, shape (..., 4, 4), and refuses what
            ``forward_kinematics`` refuses. It may be pickled, and called from many threads at once.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> fk, T = panda.compile_forward("panda_link4"), np.empty((4, 4))
            >>> fk(panda.home, out=T) is T
            True
        """
        try:
            return self._forwards[link]
        except (KeyError, TypeError):  # not made yet, or nothing that could be a name
            forward = CompiledForward(self.tree, self._the_tip if link is None else link)
            return self._forwards.setdefault(link, forward)

    def link_poses(self, q: ArrayLike, *, out: Array | None = None, threads: int | None = None) -> Array:
        """The poses of all links, in the order of ``link_names``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            out: Written to and returned if given: a float64 array of the result's shape.
            threads: How many threads a large batch uses at most; ``ULNA_THREADS``, or one a processor, unless given.

        Returns:
            T_base_link, shape (..., n_links, 4, 4).
        """
        return frame_poses(self.tree, self.tree.link_frames, q, out, threads)

    def jacobian(
        self,
        q: ArrayLike,
        link: str | None = None,
        expressed_in: str = "base",
        *,
        out: Array | None = None,
        threads: int | None = None,
    ) -> Array:
        """The geometric Jacobian: the link's velocity for a unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``: velocity of the link's origin and angular velocity, in the axes of the base;
                ``"link"``: the same in the axes of the link (body twist); ``"spatial"``: velocity of the point that passes
                the base's origin, in the axes of the base.
            out: Written to and returned if given: a float64 array of the result's shape.
            threads: How many threads a large batch uses at most; ``ULNA_THREADS``, or one a processor, unless given.

        Returns:
            J, shape (..., 6, n_dof): rows v_x, v_y, v_z [m/s], w_x, w_y, w_z [rad/s].
        """
        try:  # as compile_jacobian, but for one call of Python
            jacobian = self._jacobians[link, expressed_in]
        except (KeyError, TypeError):
            jacobian = self.compile_jacobian(link, expressed_in)
        return jacobian(q, out, threads)

    def compile_jacobian(self, link: str | None = None, expressed_in: str = "base") -> CompiledJacobian:
        """The Jacobian of one link as a function ``jac(q, out=None, threads=None)`` for control loops: the same, sooner.

        Args:
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``, ``"link"`` or ``"spatial"``, as for ``jacobian``.

        Returns:
            A function of q, shape (..., n_dof), that gives J, shape (..., 6, n_dof), and refuses what ``jacobian``
            refuses. It may be pickled, and called from many threads at once.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> jac = panda.compile_jacobian(expressed_in="link")
            >>> bool((jac(panda.home) == panda.jacobian(panda.home, expressed_in="link")).all())
            True
        """
        try:
            return self._jacobians[link, expressed_in]
        except (KeyError, TypeError):  # not made yet, or nothing that could be a name
            jacobian = CompiledJacobian(self.tree, self._the_tip if link is None else link, expressed_in)
            return self._jacobians.setdefault((link, expressed_in), jacobian)

    def analytical_jacobian(
        self, q: ArrayLike, link: str | None = None, *, out: Array | None = None, threads: int | None = None
    ) -> Array:
        """The rates of x, y, z, roll, pitch and yaw of a link for a unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: Written to and returned if given: a float64 array of the result's shape.
            threads: How many threads a large batch uses at most; ``ULNA_THREADS``, or one a processor, unless given.

        Returns:
            Shape (..., 6, n_dof), rows in m/s and rad/s; R = Rz(yaw) Ry(pitch) Rx(roll).

        Raises:
            SingularityError: |cos(pitch)| < 1e-6 somewhere; ``rows`` lists where.
        """
        return analytical_jacobian(self.tree, q, self._the_tip if link is None else link, out, threads)

    def manipulability(
        self, q: ArrayLike, link: str | None = None, *, out: Array | None = None, threads: int | None = None
    ) -> Any:
        """How well a link can be moved in all directions: sqrt(det(J J')), 0 at a singularity (Yoshikawa 1985).

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: Written to and returned if given: a float64 array of the result's shape.
            threads: How many threads a large batch uses at most; ``ULNA_THREADS``, or one a processor, unless given.

        Returns:
            Shape (...,): the volume of the ellipsoid of velocities, up to a factor; of J' J for fewer than six joints, and 0
            for a link that none moves.
        """
        return manipulability(self.tree, q, self._the_tip if link is None else link, out, threads)

    @cached_property
    def _forwards(self) -> dict:
        return {}

    @cached_property
    def _jacobians(self) -> dict:
        return {}
