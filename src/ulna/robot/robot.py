"""The robot that a user holds: immutable, picklable, safe to share between threads. Its methods lead down into the layers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions, as_allowed
from ulna.collision.attached import Attached, attach, detach
from ulna.description.arrays import as_floats
from ulna.description.meshes.hulls import with_hulls
from ulna.description.pose import as_one_pose
from ulna.description.robot_description import Description
from ulna.description.shapes import Solid
from ulna.description.subtree import with_tool
from ulna.dh.from_table import description_from_dh, description_of_table
from ulna.dh.table import DHTable
from ulna.errors import InputError
from ulna.kinematics.tree import Tree, build_tree
from ulna.robot.collisions import Collisions
from ulna.robot.inverse import InverseKinematics

Array = NDArray[np.float64]


class Robot(InverseKinematics, Collisions):
    """A robot: its kinematic tree, forward and inverse kinematics, Jacobians and collision queries.

    Made by ``ulna.load`` or ``Robot.from_dh``. Nothing of it can be changed; every array that it shows is read-only.
    """

    def __init__(
        self,
        description: Description,
        *,
        home: ArrayLike | None = None,
        attached: Iterable[Attached] = (),
        allowed: AllowedCollisions | None = None,
    ) -> None:
        tree = build_tree(description)
        start = np.clip(np.zeros(tree.n_dof) if home is None else _one_configuration(tree, home), tree.lower, tree.upper)
        start.setflags(write=False)
        self.__dict__.update(description=description, tree=tree, home=start, attached=tuple(attached), _allowed=allowed)

    @classmethod
    def from_dh(
        cls,
        rows: ArrayLike | DHTable,
        *,
        convention: str = "modified",
        joint_types: Sequence[str] | None = None,
        limits: ArrayLike | None = None,
        T_base_0: ArrayLike | None = None,
        T_n_tip: ArrayLike | None = None,
        name: str = "robot",
    ) -> Robot:
        """The serial arm of a Denavit-Hartenberg table; the link ``linkN`` is the frame of row N.

        Args:
            rows: a [m], d [m], alpha [rad], theta_offset [rad], shape (n, 4). Or a ``DHTable``, which says all the rest itself.
            convention: ``"modified"``: Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a) Rx(alpha).
            joint_types: ``"revolute"`` (all, unless said), ``"continuous"``, ``"prismatic"`` or ``"fixed"``, one a row.
            limits: Lower and upper limit of each moving joint [rad or m], shape (n_moving, 2); none unless given.
            T_base_0: Where the first row begins, the link ``link0``, shape (4, 4); at ``base`` unless given.
            T_n_tip: Where the tip, the link ``tip``, is in the frame of the last row, shape (4, 4); that frame unless given.
            name: The robot's name.

        Example:
            >>> import ulna
            >>> planar = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
            >>> planar.forward_kinematics([0.0, np.pi / 2])[:3, 3].round(12)
            array([1., 1., 0.])
        """
        if isinstance(rows, DHTable):
            if (convention, joint_types, limits, T_base_0, T_n_tip, name) != ("modified", None, None, None, None, "robot"):
                raise InputError("rows", "a DHTable says all the rest itself; give its rows, table.rows, to say it otherwise")
            return cls(description_of_table(rows))
        return cls(
            description_from_dh(
                rows,
                convention=convention,
                joint_types=joint_types,
                limits=limits,
                T_base_0=T_base_0,
                T_n_tip=T_n_tip,
                name=name,
            )
        )

    def with_tool(self, T_flange_tool: ArrayLike, name: str = "tool") -> Robot:
        """The robot with a tool: one more link, fixed to the tip, which becomes the new tip.

        Args:
            T_flange_tool: The tool's pose in the frame of the tip, shape (4, 4).
            name: The new link's name.

        Example:
            >>> import ulna
            >>> ulna.load("panda").with_tool(np.eye(4), name="gripper").tip
            'gripper'
        """
        return self._changed(description=with_tool(self.description, as_one_pose(T_flange_tool, "T_flange_tool"), name))

    def with_allowed_collisions(self, allowed: Iterable) -> Robot:
        """The robot with other pairs of links that may touch, instead of those that were found.

        Args:
            allowed: An ``AllowedCollisions``, as ``robot.allowed_collisions.plus(("a", "b"))`` makes it; or pairs of names; or
                the ``disabled_collisions`` of an SRDF.

        Raises:
            UnknownNameError: There is no such link.
        """
        return self._changed(allowed=as_allowed(allowed, self.link_names))

    def with_convex_hulls(self) -> Robot:
        """The robot whose collision meshes are their convex hulls, which are checked exactly; what is seen stays as it is.

        A hull is larger than a mesh with hollows, so it may touch where the mesh would not; it holds all of the mesh. STL, OBJ
        and Collada files are read, found as ``ulna.load`` was told. A query costs time for each vertex.

        Raises:
            FileError: A mesh is not there, or cannot be read.
            MissingExtraError: SciPy, which finds hulls, is not installed: pip install 'ulna[hulls]'.

        Example:
            >>> import ulna
            >>> ulna.load("ur5").with_convex_hulls().in_collision(np.zeros(6))  # pip install example-robot-data
            False
        """
        return self._changed(description=with_hulls(self.description))

    def with_attached(
        self, name: str, shape: Solid, T_link_object: ArrayLike, link: str | None = None, touch_links: Iterable[str] = ()
    ) -> Robot:
        """The robot with something that it holds: it moves with a link, and is checked like the robot's own shapes.

        Args:
            name: The object's name in reports.
            shape: What it is.
            T_link_object: Its pose in the frame of the link, shape (4, 4).
            link: The link that holds it, and may touch it; the tip unless given.
            touch_links: Other links that may touch it, such as fingers.

        Example:
            >>> import ulna
            >>> robot = ulna.load("panda").with_attached("cup", ulna.Box((0.05, 0.05, 0.1)), np.eye(4))
            >>> robot.without_attached("cup").attached
            ()
        """
        holder = self._the_tip if link is None else link
        new = Attached(name, shape, as_one_pose(T_link_object, "T_link_object"), holder, touch_links)  # type: ignore[arg-type]
        return self._changed(attached=attach(self.attached, new, self.link_names))

    def without_attached(self, name: str) -> Robot:
        """The robot without an object that it held. ``world.add`` puts it down."""
        return self._changed(attached=detach(self.attached, name))

    def _changed(self, **changes: Any) -> Robot:
        kept = {"description": self.description, "home": self.home, "attached": self.attached, "allowed": self._allowed}
        return Robot(**{**kept, **changes})

    def __reduce__(self):
        return _restore, (self.description, self.home, self.attached, self._allowed)


def _one_configuration(tree: Tree, home: ArrayLike) -> Array:
    q = as_floats("home", home)
    if q.shape != (tree.n_dof,) or not np.isfinite(q).all():
        raise InputError("home", f"shape {q.shape}; {tree.n_dof} finite numbers are expected, one for each entry of q")
    return q


def _restore(description: Description, home: Array, attached: tuple[Attached, ...], allowed: AllowedCollisions | None) -> Robot:
    return Robot(description, home=home, attached=attached, allowed=allowed)
