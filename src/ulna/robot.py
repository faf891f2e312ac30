"""The robot that a user holds: immutable, picklable, safe to share between threads. Its methods lead down into the layers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions, as_allowed
from ulna.collision.attached import Attached, attach, detach
from ulna.collision.world import World
from ulna.errors import InputError
from ulna.io.dh import description_from_dh
from ulna.io.load import load_description
from ulna.io.write_urdf import write_urdf
from ulna.model.arrays import as_floats
from ulna.model.description import Description
from ulna.model.pose import as_one_pose
from ulna.model.shapes import Solid
from ulna.model.subtree import cut_out, with_tool
from ulna.model.tree import Tree, build_tree

if TYPE_CHECKING:
    from ulna.collision.checker import Checker
    from ulna.collision.edge import EdgeReport
    from ulna.ik.result import IKResult

Array = NDArray[np.float64]


def load(
    source: str | Path,
    *,
    xacro_args: Mapping[str, object] | None = None,
    package_dirs: Iterable[str | Path] = (),
    base: str | None = None,
    tip: str | None = None,
) -> Robot:
    """The robot of a description.

    Args:
        source: A bundled name (``"panda"``), the path of a ``.urdf``, ``.xacro`` or ``.urdf.xacro`` file, or URDF text.
        xacro_args: Arguments of a xacro file, or of the one macro that it defines.
        package_dirs: Folders in which the packages of ``package://`` and ``$(find ...)`` lie.
        base: The link to begin at; the root unless given.
        tip: The link to end at: only the chain from base to tip is kept.

    Raises:
        DescriptionError: The description cannot be understood; the message gives file and line.
        FileError: There is no such file, or it cannot be read.

    Example:
        >>> load("panda").n_dof
        7
    """
    description, home = load_description(source, xacro_args or {}, package_dirs)
    robot = Robot(description, home=home)
    if base is None and tip is None:
        return robot
    part = Robot(cut_out(description, base, tip))
    return Robot(part.description, home=[robot.home[column] for column in _columns(part, robot)])


class Robot:
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

    description: Description
    tree: Tree
    home: Array
    """The configuration to start from [rad or m], shape (n_dof,)."""
    attached: tuple[Attached, ...]
    """What the robot carries."""
    _allowed: AllowedCollisions | None

    @classmethod
    def from_dh(
        cls,
        rows: ArrayLike,
        *,
        convention: str = "modified",
        joint_types: Sequence[str] | None = None,
        limits: ArrayLike | None = None,
        name: str = "robot",
    ) -> Robot:
        """The serial arm of a Denavit-Hartenberg table; the link ``linkN`` is the frame of row N.

        Args:
            rows: a [m], d [m], alpha [rad], theta_offset [rad], shape (n, 4).
            convention: ``"modified"``: Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a) Rx(alpha).
            joint_types: ``"revolute"`` (all, unless said), ``"continuous"``, ``"prismatic"`` or ``"fixed"``, one a row.
            limits: Lower and upper limit of each moving joint [rad or m], shape (n_moving, 2); none unless given.
            name: The robot's name.

        Example:
            >>> planar = Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
            >>> planar.forward_kinematics([0.0, np.pi / 2])[:3, 3].round(12)
            array([1., 1., 0.])
        """
        return cls(description_from_dh(rows, convention=convention, joint_types=joint_types, limits=limits, name=name))

    # ---- what it is ---------------------------------------------------------------------------------------------------

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
    def velocity_limits(self) -> Array:
        """Largest speeds [rad/s or m/s], shape (n_dof,); inf where none is given."""
        return self.tree.velocity_limits

    def to_urdf(self) -> str:
        """URDF text: the expanded text that was read, or one that is written for a robot made in another way."""
        return self.description.text or write_urdf(self.description)

    def with_tool(self, T_flange_tool: ArrayLike, name: str = "tool") -> Robot:
        """The robot with a tool: one more link, fixed to the tip, which becomes the new tip.

        Args:
            T_flange_tool: The tool's pose in the frame of the tip, shape (4, 4).
            name: The new link's name.

        Example:
            >>> load("panda").with_tool(np.eye(4), name="gripper").tip
            'gripper'
        """
        return self._changed(description=with_tool(self.description, as_one_pose(T_flange_tool, "T_flange_tool"), name))

    # ---- kinematics ---------------------------------------------------------------------------------------------------

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

    def inverse_kinematics(
        self,
        T: ArrayLike,
        q_seed: ArrayLike | None = None,
        link: str | None = None,
        method: str = "levenberg_marquardt",
        seed: int = 0,
        *,
        posture: ArrayLike | None = None,
        position_tolerance: float = 1e-5,
        rotation_tolerance: float = 1e-5,
        max_iterations: int | None = None,
    ) -> IKResult:
        """Joint positions that bring a link to a pose, within the joint limits.

        Args:
            T: The poses to reach, T_base_link, shape (..., 4, 4).
            q_seed: Where to start [rad or m], shape (..., n_dof) or (n_dof,). If given, its branch is followed as long as it
                leads to the target; otherwise the search starts from ``home`` and random configurations.
            link: The link's name; the tip unless given.
            method: ``"levenberg_marquardt"``: eight searches at once, with restarts; ``"jacobian_transpose"``: steepest
                descent from the seed alone, for teaching.
            seed: Chooses the random configurations; the result depends on nothing else.
            posture: Of all solutions near the seed, the one nearest to this configuration, shape (n_dof,). The pose comes
                first: where limits stand in the way or the steps run out, the posture is met less well, or not.
            position_tolerance: Largest distance that counts as reached [m].
            rotation_tolerance: Largest angle that counts as reached [rad].
            max_iterations: Steps before giving up; 2000 and 10000 for the two methods unless given.

        Returns:
            An ``IKResult``: q, success, status, errors and iterations. A target that is not reached is a result too.
        """
        return self._search.inverse_kinematics(
            self.tree,
            T,
            self._the_tip if link is None else link,
            self.home,
            q_seed=q_seed,
            method=method,
            seed=seed,
            posture=posture,
            tolerances=(position_tolerance, rotation_tolerance),
            max_iterations=max_iterations,
        )

    # ---- collision ----------------------------------------------------------------------------------------------------

    def in_collision(self, q: ArrayLike, world: World | None = None, self_collision: bool = True) -> bool | NDArray[np.bool_]:
        """Whether any of the robot's shapes touches, overlaps, contains or lies within an object of the world, or another link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.

        Returns:
            A bool for one q, else shape (...,).

        Raises:
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        return self._checker.in_collision(q, world, self_collision)

    def check_collision(
        self, q: ArrayLike, world: World | None = None, self_collision: bool = True, *, max_distance: float = 0.0
    ) -> Any:
        """Which of the robot's shapes overlap which objects, or each other, how deep and where.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            max_distance: Tell of pairs too that are apart, but no farther than this [m]; ``np.inf`` tells of all.

        Returns:
            A ``Report`` for one q, else an array of them, shape (...,).
        """
        return self._checker.check_collision(q, world, self_collision, max_distance)

    def signed_distance(self, q: ArrayLike, world: World | None = None, self_collision: bool = True) -> Any:
        """The least distance of the robot's shapes from an object, or from another link [m]; negative: how deep they overlap.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to measure between the robot's links too, but for ``allowed_collisions``.

        Returns:
            A number for one q, else shape (...,); infinite where there is nothing to measure to.
        """
        return self._checker.signed_distance(q, world, self_collision)

    def distance_gradient(self, q: ArrayLike, world: World | None = None, self_collision: bool = True) -> Array:
        """The derivative of ``signed_distance`` by q [m/rad or m/m], shape (..., n_dof).

        Where two pairs are equally near, or a pair has several nearest points, it is the derivative of one of them; zero where
        there is nothing to measure to. The arguments are those of ``signed_distance``.
        """
        return self._checker.distance_gradient(q, world, self_collision)

    def edge_in_collision(
        self,
        q_a: ArrayLike,
        q_b: ArrayLike,
        world: World | None = None,
        self_collision: bool = True,
        *,
        resolution: float = 1e-4,
    ) -> EdgeReport:
        """Whether anything touches anywhere on the straight line from one configuration to another: free means free everywhere.

        Args:
            q_a: Joint positions at the start [rad or m], shape (..., n_dof).
            q_b: Joint positions at the end, of a shape that goes with the other. Joints move evenly; none takes a shorter way.
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            resolution: A clearance below this [m] may count as a contact; none above does.

        Returns:
            An ``EdgeReport``: in_collision, and how far on the way all is free.
        """
        return self._checker.edge_in_collision(q_a, q_b, world, self_collision, resolution)

    @property
    def allowed_collisions(self) -> AllowedCollisions:
        """The pairs of links that may touch, each with its reason: found from joints and samples unless the user gave others."""
        return self._checker.allowed

    def with_allowed_collisions(self, allowed: Iterable) -> Robot:
        """The robot with other pairs of links that may touch, instead of those that were found.

        Args:
            allowed: An ``AllowedCollisions``, as ``robot.allowed_collisions.plus(("a", "b"))`` makes it; or pairs of names; or
                the ``disabled_collisions`` of an SRDF.

        Raises:
            UnknownNameError: There is no such link.
        """
        return self._changed(allowed=as_allowed(allowed, self.link_names))

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
            >>> robot = load("panda").with_attached("cup", ulna.Box((0.05, 0.05, 0.1)), np.eye(4))
            >>> robot.without_attached("cup").attached
            ()
        """
        holder = self._the_tip if link is None else link
        new = Attached(name, shape, as_one_pose(T_link_object, "T_link_object"), holder, touch_links)  # type: ignore[arg-type]
        return self._changed(attached=attach(self.attached, new, self.link_names))

    def without_attached(self, name: str) -> Robot:
        """The robot without an object that it held. ``world.add`` puts it down."""
        return self._changed(attached=detach(self.attached, name))

    def collision_poses(self, q: ArrayLike) -> Array:
        """The poses of the robot's collision shapes, in the order of ``collision_names``: shape (..., n_shapes, 4, 4)."""
        return self._forward.frame_poses(self.tree, self._checker.bodies.table, q)

    @property
    def collision_names(self) -> tuple[str, ...]:
        """The names of the robot's collision shapes, attached objects last."""
        return self._checker.bodies.names

    # ---- how it is held together --------------------------------------------------------------------------------------
    # The layers below are imported when first used: they load the compiler, which `import ulna` must not.

    @cached_property
    def _forward(self):
        from ulna.kinematics import forward

        return forward

    @cached_property
    def _jacobian(self):
        from ulna.kinematics import jacobian

        return jacobian

    @cached_property
    def _search(self):
        from ulna.ik import search

        return search

    @cached_property
    def _checker(self) -> Checker:
        from ulna.collision.checker import Checker

        return Checker(self.description, self.tree, self.attached, self._allowed)

    def _changed(self, **changes: Any) -> Robot:
        kept = {"description": self.description, "home": self.home, "attached": self.attached, "allowed": self._allowed}
        return Robot(**{**kept, **changes})

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

    def __reduce__(self):
        return _restore, (self.description, self.home, self.attached, self._allowed)

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {self.n_dof} dof, {self.base} to {self.tip or f'{len(self.tree.leaves)} tips'}>"


def _one_configuration(tree: Tree, home: ArrayLike) -> Array:
    q = as_floats("home", home)
    if q.shape != (tree.n_dof,) or not np.isfinite(q).all():
        raise InputError("home", f"shape {q.shape}; {tree.n_dof} finite numbers are expected, one for each entry of q")
    return q


def _columns(part: Robot, whole: Robot) -> list[int]:
    """For each entry of the part's q, the entry of the whole's that means the same."""
    slices = dict(zip(whole.joint_names, whole.joint_slices, strict=True))
    return [column for name in part.joint_names for column in range(*slices[name].indices(whole.n_dof))]


def _restore(description: Description, home: Array, attached: tuple[Attached, ...], allowed: AllowedCollisions | None) -> Robot:
    return Robot(description, home=home, attached=attached, allowed=allowed)
