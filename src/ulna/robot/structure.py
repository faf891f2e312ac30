"""What a robot is: names, limits, groups, and its description in other forms."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ulna.description.meshes.addresses import with_mesh_paths
from ulna.description.robot_description import Description
from ulna.description.semantic import EndEffector, Srdf
from ulna.description.urdf_writer import write_urdf
from ulna.dh.from_chain import dh_table
from ulna.dh.table import PARALLEL, DHTable
from ulna.errors import InputError
from ulna.kinematics.groups import JointGroup, configuration, joint_groups
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


class Structure:
    """What every part of a robot knows of it."""

    description: Description
    """Links and joints as the file gives them."""
    tree: Tree
    """The same in flat arrays, as the kernels read it."""
    home: Array
    """The configuration to start from [rad or m], shape (n_dof,)."""

    @property
    def name(self) -> str:
        """The robot's name in its description."""
        return self.description.name

    @property
    def n_dof(self) -> int:
        """The number of entries of q: independent joints, mimics applied."""
        return self.tree.n_dof

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The independent joints, in the order of q."""
        return self.tree.joint_names

    @property
    def joint_slices(self) -> tuple[slice, ...]:
        """Joint i owns ``q[joint_slices[i]]``: planar is x, y, theta; floating is x, y, z, roll, pitch, yaw."""
        return self.tree.joint_slices

    @property
    def link_names(self) -> tuple[str, ...]:
        """Every link, in the order of the description."""
        return self.tree.link_names

    @property
    def base(self) -> str:
        """The link in whose frame all poses are given."""
        return self.tree.root

    @property
    def tip(self) -> str | None:
        """The only link that carries no other, or None where there are several."""
        return self.tree.leaves[0] if len(self.tree.leaves) == 1 else None

    @property
    def lower(self) -> Array:
        """Lower limits [rad or m], shape (n_dof,); -inf where there is none."""
        return self.tree.lower

    @property
    def upper(self) -> Array:
        """Upper limits [rad or m], shape (n_dof,); inf where there is none."""
        return self.tree.upper

    @property
    def soft_lower(self) -> Array:
        """Lower soft limits [rad or m], shape (n_dof,): those of the safety controllers, ``lower`` where there is none."""
        return self.tree.soft_lower

    @property
    def soft_upper(self) -> Array:
        """Upper soft limits [rad or m], shape (n_dof,): those of the safety controllers, ``upper`` where there is none."""
        return self.tree.soft_upper

    @property
    def velocity_limits(self) -> Array:
        """Largest speeds [rad/s or m/s], shape (n_dof,); inf where none is given."""
        return self.tree.velocity_limits

    @property
    def srdf(self) -> Srdf:
        """The semantic description, its names checked against the robot; empty where none was given."""
        return self.description.srdf

    @cached_property
    def groups(self) -> Mapping[str, JointGroup]:
        """The groups of the semantic description, by name: ``robot.groups["arm"].joint_names``, ``columns``, ``link_names``."""
        return MappingProxyType(joint_groups(self.description, self.tree))

    @cached_property
    def end_effectors(self) -> Mapping[str, EndEffector]:
        """The end effectors of the semantic description, by name."""
        return MappingProxyType({effector.name: effector for effector in self.srdf.end_effectors})

    @cached_property
    def named_configurations(self) -> Mapping[str, Array]:
        """The states of the semantic description as q [rad or m], shape (n_dof,), by ``"group/state"``.

        A state that does not name every joint is completed from ``home``.
        """
        return MappingProxyType({state.key: configuration(state, self.tree, self.home) for state in self.srdf.states})

    def to_urdf(self, *, mesh_paths: str = "given") -> str:
        """URDF text: the expanded text that was read, or one that is written for a robot made in another way.

        Args:
            mesh_paths: ``"given"``: meshes are named as they were; ``"file"``: by absolute ``file://`` addresses, as RViz needs.

        Raises:
            FileError: With ``"file"``: a mesh is not there; the message lists every path tried.
        """
        text = self.description.text or write_urdf(self.description)
        return with_mesh_paths(mesh_paths, text, self.description.folder, self.description.package_dirs)

    def dh(self, convention: str = "modified", link: str | None = None, *, tolerance: float = PARALLEL) -> DHTable:
        """The Denavit-Hartenberg table of the chain from the base to a link, and the proof that it is the same robot.

        Args:
            convention: ``"modified"``: Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a) Rx(alpha).
            link: The link's name; the tip unless given.
            tolerance: Axes within this angle [rad] count as parallel, and parallel ones within this distance [m] as one. What
                that loses is in the table's ``max_position_difference`` and ``max_rotation_difference``.

        Returns:
            A ``DHTable``: one row for each moving joint, and the poses of the base and the tip, to which fixed joints go.
            ``print`` it; ``Robot.from_dh`` makes a robot of it.

        Raises:
            InputError: The chain has a planar or floating joint, or axes so nearly parallel that their common normal is out of
                reach.

        Example:
            >>> import ulna
            >>> ulna.load("panda").dh().rows[4]
            array([-0.0825    ,  0.384     , -1.57079633,  0.        ])
        """
        return dh_table(self.description, self.tree, self._the_tip if link is None else link, convention, tolerance)

    @cached_property
    def _the_tip(self) -> str:
        if self.tip is None:
            leaves = ", ".join(self.tree.leaves[:12]) + (" ..." if len(self.tree.leaves) > 12 else "")
            raise InputError("link", f"{self.name!r} has several tips; name one of {leaves}, or any other link")
        return self.tip

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Robot cannot be changed: {name} = {value!r}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a Robot cannot be changed: del {name}")

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {self.n_dof} dof, {self.base} to {self.tip or f'{len(self.tree.leaves)} tips'}>"
