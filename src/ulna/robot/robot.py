"""Holds a robot and passes each call to the layer that computes it.

A ``Robot`` is composed of a description, its tree in flat arrays, functions bound to a link, and a collision checker. A method
computes nothing itself: it calls one function of the folders below.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions, as_allowed
from ulna.collision.attached import Attached, attach, detach, inertias_of
from ulna.collision.checker import RESOLUTION, Checker
from ulna.collision.distances import Distances
from ulna.collision.report import EdgeReport
from ulna.collision.sampled_pairs import FoundPairs
from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.description.inertias import Payload
from ulna.description.likely_units import FAR, check_description, check_object
from ulna.description.meshes.mesh_files import with_mesh_paths
from ulna.description.pose import as_one_pose, inverse
from ulna.description.robot_description import Description, Inertia
from ulna.description.semantic import EndEffector, Srdf
from ulna.description.shapes import Solid
from ulna.description.subtree import with_tool
from ulna.description.urdf_writer import write_urdf
from ulna.dh.from_chain import dh_table
from ulna.dh.from_table import description_from_dh, description_of_table
from ulna.dh.table import PARALLEL, DHTable
from ulna.dynamics.bodies import described_with
from ulna.dynamics.dynamics import FREE_FALL, Dynamics, as_gravity
from ulna.errors import InputError, refuse_unknown
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of
from ulna.ik.differential import differential_ik
from ulna.ik.followed_path import FollowedPath
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import N_SAMPLES, TOLERANCE, Options, Request
from ulna.ik.problem import as_names
from ulna.ik.result import IKResult
from ulna.ik.solutions import IKSolutions
from ulna.ik.task import Task
from ulna.kinematics.forward import CompiledForward, ForwardByLink, frame_poses
from ulna.kinematics.frames import Frame, frame_pose, goal_in_base, poses_in_base, twist_in_base
from ulna.kinematics.groups import JointGroup, configuration, group_named, joint_groups, state_named
from ulna.kinematics.jacobian import CompiledJacobian, JacobianByLink, analytical_jacobian, manipulability
from ulna.kinematics.narrowed import narrowed_description, narrowed_tree
from ulna.kinematics.positions import q_of_joints
from ulna.kinematics.sample import uniform_positions
from ulna.kinematics.tree import Narrowed, Tree, build_tree, entry_names
from ulna.notebook.recording import Recording, drawer
from ulna.notebook.tables import table
from ulna.planning.batch import plan_many
from ulna.planning.constraint_table import KeepReport, edge_keeps
from ulna.planning.hand import HandLimits
from ulna.planning.keep import Keep
from ulna.planning.motion_limits import GivenLimits
from ulna.planning.path_trajectory import GivenMotion, path_trajectory
from ulna.planning.plan import Plan
from ulna.planning.planner import PlanOptions, PlanRequest, plan_motion
from ulna.planning.tightened_limits import Given, narrower
from ulna.planning.trajectory import Trajectory
from ulna.robot.forces import Forces
from ulna.robot.other_names import put_other_names, without_other_names
from ulna.servo.servo import Request as ServoRequest
from ulna.servo.servo import Servo

if TYPE_CHECKING:
    from ulna.collision.clouds import PointCloud
    from ulna.gpu.robot import GpuRobot

Array = NDArray[np.float64]
_PLAN = PlanOptions()
# Defaults, known again by identity: a call with all of them takes the shortest way.
_SEED, _TASK, _NONE = 0, "pose", ()


class Robot(Forces):
    """A robot: its kinematic tree, forward and inverse kinematics, Jacobians, collision queries, plans and forces.

    Made by ``ulna.load`` or ``Robot.from_dh``. Immutable, picklable, safe to share between threads; its arrays are read-only.
    """

    description: Description
    """The links and joints of the description."""
    tree: Tree
    """The links and joints as flat arrays, for the kernels."""
    home: Array
    """The configuration to start from [rad or m], shape (n_dof,)."""
    attached: tuple[Attached, ...]
    """The objects attached to the robot's links."""
    _forward: ForwardByLink
    _jacobian: JacobianByLink
    _checker: Checker
    _inverse_kinematics: InverseKinematics

    def __init__(
        self,
        description: Description,
        *,
        home: ArrayLike | None = None,
        attached: Iterable[Attached] = (),
        allowed: AllowedCollisions | None = None,
        gravity: ArrayLike = FREE_FALL,
        _found: FoundPairs | None = None,
        _narrowed: Narrowed | None = None,
    ) -> None:
        wide = build_tree(description)
        tree = wide if _narrowed is None else narrowed_tree(wide, _narrowed)
        start = np.clip(np.zeros(tree.n_dof) if home is None else _one_configuration(tree, home), tree.lower, tree.upper)
        start.setflags(write=False)
        carried = tuple(attached)
        checker = Checker(description, tree, carried, allowed, _found or FoundPairs(description, wide))
        self.__dict__.update(
            description=description,
            tree=tree,
            home=start,
            attached=carried,
            _forward=ForwardByLink(tree),
            _jacobian=JacobianByLink(tree),
            _checker=checker,
            _inverse_kinematics=InverseKinematics(tree, start, checker),
            _dynamics=Dynamics(tree, description, inertias_of(description, carried), as_gravity(gravity)),
        )

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
            rows: a [m], d [m], alpha [rad], theta_offset [rad], shape (n, 4). Or a ``DHTable``, which has the other arguments.
            convention: ``"modified"``: Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a) Rx(alpha).
            joint_types: ``"revolute"`` (the default for all), ``"continuous"``, ``"prismatic"`` or ``"fixed"``, one a row.
            limits: Lower and upper limit of each moving joint [rad or m], shape (n_moving, 2); none unless given.
            T_base_0: The pose of the link ``link0``, where the first row begins, shape (4, 4); the identity unless given.
            T_n_tip: The pose of the link ``tip`` in the frame of the last row, shape (4, 4); the identity unless given.
            name: The robot's name.

        Raises:
            InputError: The rows, types, limits or poses do not fit each other, or the convention is not known; or a ``DHTable``
                is given together with arguments that it has itself.

        Example:
            >>> import ulna
            >>> planar = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
            >>> planar.forward_kinematics([0.0, np.pi / 2])[:3, 3].round(12)
            array([1., 1., 0.])
        """
        if isinstance(rows, DHTable):
            if (convention, joint_types, limits, T_base_0, T_n_tip, name) != ("modified", None, None, None, None, "robot"):
                raise InputError("rows", "a DHTable has its own values of the other arguments; give table.rows to choose others")
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

    # ---- what it is ----------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """The robot's name in its description."""
        return self.description.name

    @property
    def n_dof(self) -> int:
        """The number of entries of q: those of the independent joints, without mimics."""
        return self.tree.n_dof

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The independent joints, in the order of q."""
        return self.tree.joint_names

    @property
    def joint_slices(self) -> tuple[slice, ...]:
        """The entries of joint i are ``q[joint_slices[i]]``: planar has x, y, theta; floating x, y, z, roll, pitch, yaw."""
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
        """The only link without child links that a joint moves; None if there are several such links."""
        return self.tree.tip

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
    def acceleration_limits(self) -> Array:
        """Largest accelerations and decelerations [rad/s^2 or m/s^2], shape (n_dof,); inf where the description gives none."""
        return self.tree.acceleration_limits

    @property
    def jerk_limits(self) -> Array:
        """Largest jerks [rad/s^3 or m/s^3], shape (n_dof,); inf where the description gives none."""
        return self.tree.jerk_limits

    @property
    def effort_limits(self) -> Array:
        """Largest torques and forces [Nm or N], shape (n_dof,); inf where the description gives none."""
        return self.tree.effort_limits

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

    def q_of_joints(self, names: Sequence[str], positions: ArrayLike, *, others: ArrayLike | None = None) -> Array:
        """q, shape (n_dof,), of joints by name: of a ``JointState`` of ROS, its ``name`` and its ``position``.

        Args:
            names: Joints in any order. Those that the robot does not have are ignored: a ``JointState`` has mimic joints, and
                joints of other robots.
            positions: The position of each [rad or m], shape (len(names),).
            others: Where the robot's other joints are: q [rad or m], shape (n_dof,). Unless given, every joint must be named.

        Raises:
            InputError: The positions do not go with the names, are not finite, or a joint is missing or named twice; or a named
                joint has several positions, as a planar one.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> q = panda.q_of_joints(["panda_joint4", "panda_finger_joint1"], [-1.5, 0.02], others=panda.home)
            >>> float(q[3])
            -1.5
        """
        return q_of_joints(names, positions, others, self.tree)

    def random(self, n: int | None = None, *, seed: object = None) -> Array:
        """Random configurations, uniform within the limits.

        Args:
            n: How many; one unless given.
            seed: What ``numpy.random.default_rng`` takes: the same number gives the same configurations. Unless given, others in
                every call.

        Returns:
            Shape (n, n_dof), or (n_dof,) for one [rad or m]. An angle without limits is within +-pi; a slide without limits is
            within the robot's length, its slides at 0, to both sides. The angles of a floating joint are uniform one by one.

        Raises:
            InputError: ``n`` is not a count.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> panda.random(1000, seed=0).shape, panda.random().shape
            ((1000, 7), (7,))
        """
        return uniform_positions(self.tree, n, seed)

    def to_urdf(self, *, mesh_paths: str = "given") -> str:
        """URDF text: the expanded text that was read, or one that is written for a robot made in another way.

        Attached objects are no part of it.

        Args:
            mesh_paths: ``"given"``: meshes are named as they were; ``"file"``: by absolute ``file://`` addresses, as RViz needs.

        Raises:
            FileError: With ``"file"``: a mesh is not there; the message lists every path tried.
        """
        described = narrowed_description(self.description, self.tree)
        text = described.text or write_urdf(described)
        return with_mesh_paths(mesh_paths, text, described.folder, described.package_dirs)

    def dh(self, *, convention: str = "modified", link: str | None = None, tolerance: float = PARALLEL) -> DHTable:
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
        return dh_table(
            narrowed_description(self.description, self.tree), self.tree, self.tree.link_or_tip(link), convention, tolerance
        )

    # ---- where its links are, and how fast they move -------------------------------------------------------------------

    def forward_kinematics(
        self, q: ArrayLike, *, link: str | None = None, frame: Frame | None = None, out: Array | None = None, **unknown: Never
    ) -> Array:
        """The pose of a link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            frame: The frame of the result instead of the base: any link, such as ``"base"`` of a UR, which its pendant shows, or
                its pose T_base_frame, shape (4, 4).
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            T_base_link, shape (..., 4, 4); with ``frame`` T_frame_link.

        Raises:
            InputError: q has another shape or an entry out of range, ``out`` does not fit, or the robot has several tips and no
                link is named; or ``out`` is given beside ``frame``.
            UnknownNameError: There is no such link.
        """
        if unknown:
            refuse_unknown("forward_kinematics", unknown)
        if frame is not None:
            if out is not None:
                raise InputError("out", "goes with the base; with frame= an array is made")
            T_base_frame = self.forward_kinematics(q, link=frame) if isinstance(frame, str) else frame_pose(self.tree, frame)
            return inverse(T_base_frame) @ self.forward_kinematics(q, link=link)
        try:
            forward = self._forward.get(link)
        except TypeError:  # not hashable, so not the name of a link
            forward = None
        return (forward or self._forward.of(link))(q, out)

    def compile_forward(self, *, link: str | None = None) -> CompiledForward:
        """Forward kinematics of one link as a function ``fk(q, out=None)`` for control loops: the same, but faster.

        Args:
            link: The link's name; the tip unless given.

        Returns:
            A function of q, shape (..., n_dof), that gives T_base_link, shape (..., 4, 4), and refuses what
            ``forward_kinematics`` refuses. It may be pickled, and called from many threads at once.

        Raises:
            InputError: The robot has several tips, and no link is named.
            UnknownNameError: There is no such link.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> fk, T = panda.compile_forward(link="panda_link4"), np.empty((4, 4))
            >>> fk(panda.home, out=T) is T
            True
        """
        return self._forward.of(link)

    def link_poses(self, q: ArrayLike, *, out: Array | None = None, **unknown: Never) -> Array:
        """The poses of all links, in the order of ``link_names``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            T_base_link, shape (..., n_links, 4, 4).

        Raises:
            InputError: q has another shape or an entry out of range, or ``out`` does not fit.
        """
        if unknown:
            refuse_unknown("link_poses", unknown)
        return frame_poses(self.tree, self.tree.link_frames, q, out)

    def jacobian(
        self, q: ArrayLike, *, link: str | None = None, expressed_in: str = "base", out: Array | None = None, **unknown: Never
    ) -> Array:
        """The geometric Jacobian: the link's velocity for a unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``: velocity of the link's origin and angular velocity, in the axes of the base;
                ``"link"``: the same in the axes of the link (body twist); ``"spatial"``: velocity of the point that passes
                the base's origin, in the axes of the base.
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            J, shape (..., 6, n_dof): rows v_x, v_y, v_z [m/s], w_x, w_y, w_z [rad/s].

        Raises:
            InputError: q has another shape or an entry out of range, ``expressed_in`` is not a frame, ``out`` does not fit, or
                the robot has several tips and no link is named.
            UnknownNameError: There is no such link.
        """
        if unknown:
            refuse_unknown("jacobian", unknown)
        try:
            jacobian = self._jacobian.get((link, expressed_in))
        except TypeError:  # not hashable, so not the name of a link or of a frame
            jacobian = None
        return (jacobian or self._jacobian.of(link, expressed_in))(q, out)

    def on_gpu(self, *, float32: bool = False) -> GpuRobot:
        """A robot like this one, its batches computed on an NVIDIA GPU: the kernels of the CPU, one problem a thread.

        Its methods have the names of these. They take NumPy arrays, or arrays on the device, and return the same kind.

        Args:
            float32: Whether poses, Jacobians and collisions of boxes are computed in float32: for cards with few float64 units.

        Raises:
            DeviceError: There is no GPU that can be used, or numba-cuda cannot be used with this NumPy.
            InputError: The robot has no moving joints.
            MissingExtraError: Neither the extra ``cuda12`` nor ``cuda13`` is installed.
        """
        from ulna.gpu.robot import GpuRobot  # noqa: PLC0415 - needs the extra

        return GpuRobot(self, float32=float32)

    def compile_jacobian(self, *, link: str | None = None, expressed_in: str = "base") -> CompiledJacobian:
        """The Jacobian of one link as a function ``jac(q, out=None)`` for control loops: the same, but faster.

        Args:
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``, ``"link"`` or ``"spatial"``, as for ``jacobian``.

        Returns:
            A function of q, shape (..., n_dof), that gives J, shape (..., 6, n_dof), and refuses what ``jacobian``
            refuses. It may be pickled, and called from many threads at once.

        Raises:
            InputError: ``expressed_in`` is not a frame, or the robot has several tips and no link is named.
            UnknownNameError: There is no such link.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> jac = panda.compile_jacobian(expressed_in="link")
            >>> bool((jac(panda.home) == panda.jacobian(panda.home, expressed_in="link")).all())
            True
        """
        return self._jacobian.of(link, expressed_in)

    def analytical_jacobian(self, q: ArrayLike, *, link: str | None = None, out: Array | None = None, **unknown: Never) -> Array:
        """The rates of x, y, z, roll, pitch and yaw of a link for a unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            Shape (..., 6, n_dof), rows in m/s and rad/s; R = Rz(yaw) Ry(pitch) Rx(roll).

        Raises:
            SingularityError: |cos(pitch)| < 1e-6 somewhere; ``rows`` lists where.
        """
        if unknown:
            refuse_unknown("analytical_jacobian", unknown)
        return analytical_jacobian(self.tree, q, self.tree.link_or_tip(link), out)

    def manipulability(self, q: ArrayLike, *, link: str | None = None, out: Array | None = None, **unknown: Never) -> Any:
        """How well a link can be moved in all directions: sqrt(det(J J')), 0 at a singularity (Yoshikawa 1985).

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            Shape (...,): the volume of the ellipsoid of velocities, up to a factor; of J' J for fewer than six joints, and 0
            for a link that none moves.

        Raises:
            InputError: q has another shape or an entry out of range, ``out`` does not fit, or the robot has several tips and no
                link is named.
            UnknownNameError: There is no such link.
        """
        if unknown:
            refuse_unknown("manipulability", unknown)
        return manipulability(self.tree, q, self.tree.link_or_tip(link), out)

    # ---- which joint positions bring a link to a pose ------------------------------------------------------------------

    def inverse_kinematics(
        self,
        T: ArrayLike | Keep,
        q_seed: ArrayLike | None = None,
        *,
        link: str | None = None,
        frame: Frame | None = None,
        seed: int = 0,
        task: Task | str = _TASK,
        world: World | None = None,
        rank: str | None = None,
        posture: ArrayLike | str | None = None,
        held: Iterable[str] = (),
        max_step: float | None = None,
        position_tolerance: float = TOLERANCE,
        rotation_tolerance: float = TOLERANCE,
        max_iterations: int | None = None,
        time_limit: float | None = None,
        trace: bool = False,
        **unknown: Never,
    ) -> IKResult:
        """Joint positions that bring a link to a pose, within the joint limits.

        Where the link has an exact closed form of six joints (``closed_form``) and the whole pose is asked for, all its branches
        are computed, and the one nearest to ``q_seed``, or to ``home``, is returned, or that of the best rank. Otherwise, and
        with ``posture``, ``held`` or ``max_step``, there is a search.

        Args:
            T: The poses to reach, T_base_link, shape (..., 4, 4). Or a ``Keep`` with a pose: then its link and its task are
                taken, and what is found keeps it.
            q_seed: Where to start [rad or m], shape (..., n_dof), broadcast with T: several seeds may be of one target. If given,
                the search from it comes first; if that fails, random starts follow, and the solution nearest to the seed is
                returned. Otherwise the search starts from ``home`` and random configurations.
            link: The link's name; the tip unless given.
            frame: The frame of T, if not the base: a link that stands still, such as ``"base"`` of a UR, which its pendant
                shows; or the frame's pose T_base_frame, shape (4, 4), such as that of a work object.
            seed: Chooses the random configurations; without ``time_limit`` the result depends on nothing else.
            task: ``"pose"``; ``"position"``: any orientation; ``"pointing"``: position and the direction of the link's z axis;
                or an ``ulna.Task`` (another axis, slack by component).
            world: Configurations that collide with it, or with the robot itself, are rejected, and the search continues.
            rank: Which of several solutions: ``"nearest"`` to the seed (largest joint change), ``"manipulability"``,
                ``"clearance"`` from the world, ``"mid_range"`` of the joints. It is chosen from the solutions of sixteen starts.
            posture: Of all solutions near the seed, the one nearest to this configuration, shape (n_dof,), or to
                ``"mid_range"``. The pose has priority: at limits, or when the steps run out, the posture is
                approached less closely, or not at all.
            held: Names of joints that keep their positions in the seed.
            max_step: The largest difference of any entry of q from ``q_seed`` [rad or m]; a solution beyond it is rejected.
            position_tolerance: Largest distance that counts as reached [m].
            rotation_tolerance: Largest angle that counts as reached [rad].
            max_iterations: The largest number of steps of all starts of a search together; 16 000 (800 starts) unless
                given. The closed form takes no steps.
            time_limit: The longest time of the search [s], checked between rounds of restarts.
            trace: For one target: keep the errors, the step and the damping of every step in ``result.trace``.
            **unknown: No other argument is taken.

        Returns:
            An ``IKResult``: q, success, status, errors, iterations, and the reasons. A target that is not reached is a result
            too.

        Raises:
            InputError: An argument that the search cannot take, such as a T that is not a rigid motion; its name is in the
                message.
            UnknownNameError: There is no such link or joint.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.
            UnknownArgumentError: There is no such argument.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> print(panda.inverse_kinematics(panda.forward_kinematics(panda.home) + 0.0).status)
            solved
        """
        if unknown:
            refuse_unknown("inverse_kinematics", unknown)
        if (
            type(T) is np.ndarray and frame is None and world is None and rank is None and posture is None and held is _NONE
            and seed is _SEED and task is _TASK and max_step is None and max_iterations is None and time_limit is None
            and position_tolerance is TOLERANCE and rotation_tolerance is TOLERANCE and trace is False
        ):  # fmt: skip
            return self._inverse_kinematics.with_defaults(T, q_seed, link)
        if isinstance(T, Keep):
            if task != "pose":
                raise InputError("task", "a constraint has a task of its own; none is given beside it")
            if frame is not None:
                raise InputError("frame", "goes with poses; a constraint is in the base")
            target, link, task = T.target(link)
        else:
            target = T if frame is None else poses_in_base(self.tree, T, frame)
        options = Options(  # in their order: by name they would take 0.3 us more
            seed, task, rank, position_tolerance, rotation_tolerance, max_step, max_iterations, time_limit, trace
        )
        names = held if type(held) is tuple else as_names(held)
        request = Request(target, q_seed, posture, names, world, link, options)
        return self._inverse_kinematics.inverse_kinematics(request)

    @cached_property
    def closed_form(self) -> ClosedForm | None:
        """The closed form of the tip's inverse kinematics: family, held joint, by how much the axes miss it; or None.

        Raises:
            InputError: The robot has several tips.

        Example:
            >>> import ulna
            >>> ulna.load("panda").closed_form.held
            'panda_joint7'
        """
        return closed_form_of(self.tree, self.tree.link_or_tip(None))

    def all_solutions(
        self,
        T: ArrayLike,
        *,
        q_seed: ArrayLike | None = None,
        link: str | None = None,
        frame: Frame | None = None,
        task: Task | str = _TASK,
        world: World | None = None,
        rank: str | None = None,
        redundancy: str | None = None,
        n_samples: int = N_SAMPLES,
        whole_turns: bool = False,
        seed: int = 0,
        position_tolerance: float = TOLERANCE,
        rotation_tolerance: float = TOLERANCE,
        **unknown: Never,
    ) -> IKSolutions:
        """All joint positions that bring a link to poses, and what is proved of them.

        Arms of six joints of a family with a closed form have at most eight solutions, whole turns aside. For arms of seven
        joints one is held at ``n_samples`` places, and all solutions are found at each. Arms of three joints have a closed form
        for a position, arms of five for a pointing; for whole poses those of three, four and five have one that says which of the
        poses they reach; so do planar arms of two and three joints. Other arms are searched for each pose.

        Args:
            T: The poses to reach, T_base_link, shape (..., 4, 4).
            q_seed: Each solution is as near to this as whole turns within the limits bring it [rad or m], shape (n_dof,);
                ``home`` unless given.
            link: The link's name; the tip unless given.
            frame: The frame of T, if not the base: a link that stands still, such as ``"base"`` of a UR, which its pendant
                shows; or the frame's pose T_base_frame, shape (4, 4), such as that of a work object.
            task: What of the pose is to be reached: ``"pose"``, ``"position"``, ``"pointing"``, or an ``ulna.Task``.
            world: Solutions that collide with it, or in which the robot touches itself, are not valid.
            rank: By what they are ordered, the best first: ``"nearest"`` to ``q_seed``, ``"manipulability"``, ``"clearance"`` or
                ``"mid_range"``; see ``inverse_kinematics``. Those that are not valid come last. Unless given, in no order.
            redundancy: The joint of seven that is held; that of ``closed_form`` unless given. Or ``"elbow"``, for arms with a
                spherical shoulder and wrist: the angle by which the arm is turned about the line between them.
            n_samples: The number of places at which it is held, spread evenly over its range; and, where a search finds more
                solutions than can be listed, the number of those returned, far from each other.
            whole_turns: Whether to list every whole turn that the limits allow, and no solution beyond the limits. Otherwise
                each branch is listed once; branches that coincide, as ``proof`` says then, are one solution to rounding, listed
                more than once.
            seed: Chooses the random starts of a search; the result depends on nothing else.
            position_tolerance: Largest distance that counts as reached in a search [m].
            rotation_tolerance: Largest angle that counts as reached in a search [rad].
            **unknown: No other argument is taken.

        Returns:
            An ``IKSolutions``: q (..., m, n_dof), valid, real, proof, family. Of one target ``found.q[found.valid]`` are those
            within the limits and clear of the world. Joints that may have any angle are near ``q_seed``.

        Raises:
            InputError: T is not an array of poses, the robot has several tips and no link is named, ``redundancy`` is not a joint
                of an arm of seven or there is no closed form with it held, or another argument cannot be taken.
            UnknownNameError: There is no such link or joint.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.

        Example:
            >>> import ulna
            >>> found = ulna.load("panda").all_solutions(ulna.pose((0.5, 0.0, 0.4), (np.pi, 0, 0)), n_samples=32)
            >>> found.q.shape, str(found.proof)
            ((256, 7), 'continuum')
        """
        if unknown:
            refuse_unknown("all_solutions", unknown)
        if (
            type(T) is np.ndarray and T.ndim == 2 and frame is None and world is None and rank is None and q_seed is None
            and redundancy is None and seed is _SEED and task is _TASK and n_samples is N_SAMPLES and whole_turns is False
            and position_tolerance is TOLERANCE and rotation_tolerance is TOLERANCE
        ):  # fmt: skip
            return self._inverse_kinematics.all_with_defaults(T, link)
        options = Options(seed, task, rank, position_tolerance, rotation_tolerance)
        request = Request(poses_in_base(self.tree, T, frame), q_seed, world=world, link=link, options=options)
        return self._inverse_kinematics.all_solutions(
            request, n_samples=n_samples, redundancy=redundancy, whole_turns=whole_turns
        )

    def follow(
        self,
        T_path: ArrayLike,
        q_start: ArrayLike | None = None,
        *,
        link: str | None = None,
        frame: Frame | None = None,
        task: Task | str = _TASK,
        max_step: float = 0.1,
        world: World | None = None,
        rank: str | None = None,
        seed: int = 0,
        time_limit: float | None = None,
        **unknown: Never,
    ) -> FollowedPath:
        """The joint path through a path of poses that never jumps to another branch, or where and why there is none.

        Of all joint paths with no step longer than ``max_step`` the one with the least sum of squared joint steps is returned,
        the step from ``q_start`` to the first pose among them; without one that from ``home``, which may be of any length.
        Where the link has an exact closed form of six joints, all branches of all poses are compared. Other arms are searched;
        for seven joints and more, or a task that leaves some of a pose free, a graph of samples of the redundancy is searched,
        and its best path is smoothed.

        Args:
            T_path: The poses in their order, T_base_link, shape (n, 4, 4).
            q_start: Where the arm is before the first pose [rad or m], shape (n_dof,): the path begins at most ``max_step`` from
                it. Unless given, it may begin anywhere, and begins as near to ``home`` as that sum allows.
            link: The link's name; the tip unless given.
            frame: The frame of T_path, if not the base: a link that stands still, such as ``"base"`` of a UR, which its pendant
                shows; or the frame's pose T_base_frame, shape (4, 4), such as that of a work object.
            task: What of each pose must be reached, as for ``inverse_kinematics``: ``"pointing"`` leaves the turn about the tool
                free (welding, milling); a ``Task`` may leave a band, within which the path chooses.
            max_step: The largest step of any joint from one pose to the next [rad or m]. Another branch is rarely within 0.1 rad;
                poses that are further apart than that need a larger step, or poses in between.
            world: Configurations that collide with it, or with the robot itself, are left out, and the straight lines between
                those of neighbouring poses are certified to be free (``edge_in_collision``).
            rank: What is minimised instead, as a sum over the poses: ``"nearest"``: the largest difference of a joint from
                ``q_start``, or ``home``; ``"manipulability"``; ``"clearance"`` from the world; ``"mid_range"`` of the joints;
                each with the squared joint steps, as shares of ``max_step``, added.
            seed: Chooses the random configurations where a search is needed. The result depends on nothing else, unless
                ``time_limit`` ends the search.
            time_limit: The longest time of the search [s]; None for no limit. It is looked at between rounds of some hundredths
                to tenths of a second. A path that is known by then is returned as it is, less smooth.
            **unknown: No other argument is taken.

        Returns:
            A ``FollowedPath``: q, status, reason, steps; where no path leads on, ``ends_at`` and ``ending`` say where and why.

        Raises:
            InputError: T_path is not an array of poses, ``max_step`` is not above 0, or another argument cannot be taken.
            UnknownNameError: There is no such link.
            GeometryError: A world is given, and the robot has no collision shapes, or some that cannot be checked.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> q = panda.home + np.linspace(0, 0.5, 20)[:, None]
            >>> path = panda.follow(panda.forward_kinematics(q))
            >>> str(path.status), bool(path.steps.max() < 0.1)
            ('followed', True)
        """
        if unknown:
            refuse_unknown("follow", unknown)
        options = Options(task=task, rank=rank, seed=seed, time_limit=time_limit)
        T_path = poses_in_base(self.tree, T_path, frame, "T_path")
        return self._inverse_kinematics.follow(T_path, q_start, link, options, max_step, world)

    def differential_ik(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        dt: float,
        *,
        link: str | None = None,
        expressed_in: str = "base",
        frame: Frame | None = None,
        damping: float = 0.01,
        out: Array | None = None,
        **unknown: Never,
    ) -> Array:
        """The joint velocities of one control step that give a link a twist, as nearly as velocity and position limits allow.

        They minimise |J qd - twist|^2 + damping^2 |qd|^2 within the limits: the only minimum, near singularities too, where the
        damping keeps them short.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            twist: v [m/s] and w [rad/s] of the link, shape (..., 6).
            dt: The step's length [s]: ``q + dt * qd`` lies within the position limits, to rounding. A joint that is beyond one
                returns to it, at its velocity limit if it is further away than that.
            link: The link's name; the tip unless given.
            expressed_in: The frame of the twist; see ``jacobian``.
            frame: The axes of the twist instead of the base's: a link that stands still, or the frame's pose T_base_frame, shape
                (4, 4). It goes with ``expressed_in="base"``.
            damping: Above 0. Where the arm moves well a velocity is short by a share of about damping^2 / sigma^2, with sigma
                the smallest singular value of J; no joint moves faster than |twist| / (2 damping). A damping below 1e-4 |J|, or
                1e-2 |J| for fewer than six joints, takes some times longer; singular values below 1e-14 |J| are within the
                rounding of J, and count as 0.
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            qd [rad/s or m/s], shape (..., n_dof).

        Raises:
            InputError: q or twist has another shape or an entry out of range, dt or damping is not above 0, ``expressed_in`` is
                not a frame, ``out`` does not fit, or the robot has no joint.
            UnknownNameError: There is no such link.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> qd = panda.differential_ik(panda.home, [0.1, 0, 0, 0, 0, 0], dt=0.001)
            >>> float((panda.jacobian(panda.home) @ qd)[0].round(3))
            0.1
        """
        if unknown:
            refuse_unknown("differential_ik", unknown)
        if frame is not None and expressed_in != "base":
            raise InputError("frame, expressed_in", "give one of them, not both")
        link, twist = self.tree.link_or_tip(link), twist_in_base(self.tree, twist, frame)
        return differential_ik(self.tree, q, twist, dt, link, expressed_in, damping, out)

    # ---- what it touches -----------------------------------------------------------------------------------------------

    def in_collision(
        self,
        q: ArrayLike,
        world: World | None = None,
        *,
        self_collision: bool = True,
        out: NDArray[np.bool_] | None = None,
        **unknown: Never,
    ) -> bool | NDArray[np.bool_]:
        """Whether any of the robot's shapes touches, overlaps, contains or lies within an object of the world, or another link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            out: Written to and returned if given: a bool array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            A bool for one q, else shape (...,).

        Raises:
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        if unknown:
            refuse_unknown("in_collision", unknown)
        return self._checker.in_collision(q, world, self_collision, out)

    def links_near(
        self, cloud: PointCloud, q: ArrayLike, *, within: float = 0.0, pose: ArrayLike | None = None
    ) -> tuple[tuple[str, ...], NDArray[np.int64]]:
        """The links and attached objects with collision shapes, and which of them is nearest to each ball of a cloud.

        ``PointCloud.without`` removes these balls: a camera sees the robot too.

        Args:
            cloud: The cloud.
            q: Joint positions [rad or m], shape (n_dof,).
            within: How far a ball may be from a shape [m]; 0: only those that touch.
            pose: T_base_cloud, shape (4, 4); the origin unless given.

        Returns:
            The names, and for each point the place in them of the nearest, or -1 if all are farther, shape (n,).

        Raises:
            InputError: q is not one configuration, ``within`` is not a length, or the pose is not a rigid motion.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        return self._checker.links_near(cloud, q, within, pose)

    def check_collision(
        self,
        q: ArrayLike,
        world: World | None = None,
        *,
        self_collision: bool = True,
        max_distance: float = 0.0,
        **unknown: Never,
    ) -> Any:
        """The pairs of the robot's shapes and objects, or of its own shapes, that overlap: how deep and where.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            max_distance: Also report pairs that do not overlap, up to this distance [m]; ``np.inf`` reports all pairs.
            **unknown: No other argument is taken.

        Returns:
            A ``Report`` for one q, else an array of them, shape (...,).

        Raises:
            InputError: q has another shape or an entry out of range, ``max_distance`` is not a number of at least 0, or there is
                nothing to check.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
            UnknownArgumentError: There is no such argument.
        """
        if unknown:
            refuse_unknown("check_collision", unknown, "max_distance= is how near pairs may be")
        return self._checker.check_collision(q, world, self_collision, max_distance)

    def distances(
        self, q: ArrayLike, world: World | None = None, *, within: float = 0.1, self_collision: bool = True, **unknown: Never
    ) -> Distances:
        """All pairs of the robot's shapes and objects, or of its own shapes, that are near each other, with gradients, as arrays.

        They are the rows of a constraint: to first order the distance of pair k at ``q + dq`` is
        ``signed_distance[k] + gradient[k] @ dq``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            within: How far apart pairs may be [m]; ``np.inf`` gives all pairs.
            self_collision: Whether to measure between the robot's links too, but for ``allowed_collisions``.
            **unknown: No other argument is taken.

        Returns:
            The ``Distances``: of a point cloud or a height map, for each of the robot's shapes, the nearest point or column only.

        Raises:
            InputError: q has another shape or an entry out of range, ``within`` is not a number of at least 0, or there is
                nothing to check.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.

        Example:
            >>> import ulna
            >>> panda, world = ulna.load("panda"), ulna.World()
            >>> world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.45, 0, 0.35)))
            >>> near = panda.distances(panda.home, world, within=0.08)
            >>> near.name_a[0], near.name_b[0], near.gradient.shape
            ('box 6', 'box 9', (3, 7))
        """
        if unknown:
            refuse_unknown("distances", unknown)
        return self._checker.distances(q, world, self_collision, within)

    def signed_distance(
        self, q: ArrayLike, world: World | None = None, *, self_collision: bool = True, out: Array | None = None, **unknown: Never
    ) -> Any:
        """The least distance of the robot's shapes from an object, or from another link [m]; negative: how deep they overlap.

        It is 0 where shapes touch: ``signed_distance(q) <= 0`` equals ``in_collision(q)``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to measure between the robot's links too, but for ``allowed_collisions``.
            out: Written to and returned if given: a float64 array of the result's shape.
            **unknown: No other argument is taken.

        Returns:
            A number for one q, else shape (...,); infinite where there is nothing to measure to.

        Raises:
            InputError: q has another shape or an entry out of range, ``out`` does not fit, or there is nothing to check.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        if unknown:
            refuse_unknown("signed_distance", unknown)
        return self._checker.signed_distance(q, world, self_collision, out)

    def distance_gradient(
        self, q: ArrayLike, world: World | None = None, *, self_collision: bool = True, out: Array | None = None, **unknown: Never
    ) -> Array:
        """The derivative of ``signed_distance`` by q [m/rad or m/m], shape (..., n_dof).

        Where two pairs are equally near, or a pair has several nearest points, it is the derivative of one of them; zero where
        there is nothing to measure to. The arguments are those of ``signed_distance``.

        Raises:
            InputError: As for ``signed_distance``.
            GeometryError: As for ``signed_distance``.
        """
        if unknown:
            refuse_unknown("distance_gradient", unknown)
        return self._checker.distance_gradient(q, world, self_collision, out)

    def edge_in_collision(
        self,
        q_a: ArrayLike,
        q_b: ArrayLike,
        world: World | None = None,
        *,
        self_collision: bool = True,
        resolution: float = RESOLUTION,
        **unknown: Never,
    ) -> EdgeReport:
        """Whether anything touches on the straight line from one configuration to another. Free holds for the whole line.

        That rests on lower bounds of distances, with their rounding, and not on samples (docs/edges.md).

        Args:
            q_a: Joint positions at the start [rad or m], shape (..., n_dof).
            q_b: Joint positions at the end, of a shape that goes with the other. Joints move evenly; none takes a shorter way.
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            resolution: A clearance below this [m] may count as a contact; none above does.
            **unknown: No other argument is taken.

        Returns:
            An ``EdgeReport``: in_collision, and how far on the way all is free.

        Raises:
            InputError: q_a or q_b has another shape or an entry out of range, their shapes do not go together, ``resolution`` is
                below 1e-5 m, or there is nothing to check.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        if unknown:
            refuse_unknown("edge_in_collision", unknown)
        return self._checker.edge_in_collision(q_a, q_b, world, self_collision, resolution)

    def edge_keeps(self, q_a: ArrayLike, q_b: ArrayLike, keep: Keep | Iterable[Keep]) -> KeepReport:
        """Whether constraints are kept on the straight line from one configuration to another, at all of its configurations.

        That rests on bounds of how far a link moves and turns, with their rounding, and not on samples (docs/edges.md).

        Args:
            q_a: Joint positions at the start [rad or m], shape (..., n_dof).
            q_b: Joint positions at the end, of a shape that goes with the other. Joints move evenly; none takes a shorter way.
            keep: The constraints. One without a pose keeps that of the (first) q_a.

        Returns:
            A ``KeepReport``: kept, and the greatest share of a tolerance that is used. What uses more than 0.9999 of a tolerance
            may count as not kept.

        Raises:
            InputError: q_a or q_b has another shape or an entry out of range, their shapes do not go together, a constraint
                cannot be taken, or none is given.
            UnknownNameError: A constraint's link is not there.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> tilted = panda.home + 0.0
            >>> tilted[5] += 0.2
            >>> panda.edge_keeps(panda.home, tilted, ulna.Keep.upright(within=0.1)).kept
            False
        """
        return edge_keeps(self.tree, q_a, q_b, keep)

    # ---- how it gets somewhere -----------------------------------------------------------------------------------------

    def plan(
        self,
        q_start: ArrayLike,
        goal: ArrayLike | Mapping[str, ArrayLike],
        world: World | None = None,
        *,
        link: str | None = None,
        frame: Frame | None = None,
        task: Task | str = _TASK,
        held: Iterable[str] = (),
        group: str | None = None,
        keep: Keep | Iterable[Keep] = (),
        certify: bool = _PLAN.certify,
        clearance: float = _PLAN.clearance,
        seed: int = _PLAN.seed,
        max_checks: int = _PLAN.max_checks,
        shorten: bool = _PLAN.shorten,
        escape: bool = _PLAN.escape,
        time_limit: float | None = _PLAN.time_limit,
        progress: Callable[[int, int], object] | None = None,
    ) -> Plan:
        """A motion from a configuration to a goal, free of collision: straight lines between configurations.

        RRT-Connect: two trees, from the start and from the goals, grow towards each other (docs/planning_search.md). Joints whose
        position is the same at the start and the goal are held first, and move only if no path is found so (``plan.moved``).

        Args:
            q_start: Where to start [rad or m], shape (n_dof,); or the name of a state of the SRDF, such as ``"arm/ready"``.
            goal: Where to go: a configuration, shape (n_dof,), or several, of which one is reached, shape (n, n_dof); or a pose
                T_base_link, shape (4, 4), or several, shape (n, 4, 4), with all the configurations that inverse kinematics finds;
                or a pose for each of several links, as in ``{"left_hand": T_1, "right_hand": T_2}``, to which they come together;
                or the name of a state, whose other joints keep their positions.
            world: The objects; none unless given. The robot's links are checked against each other too.
            link: The link that is brought to the pose; the tip, of the group if one is named, unless given. Joints that do not
                move it keep their positions, and so do those that move several links of the goal.
            frame: The frame of a goal of poses, if not the base: a link that stands still, such as ``"base"`` of a UR, which its
                pendant shows; or the frame's pose T_base_frame, shape (4, 4), such as that of a work object.
            task: The components of the pose that count; see ``inverse_kinematics``.
            held: Names of joints that keep their positions.
            group: A group of the SRDF (``robot.groups``): the joints outside keep their positions. A configuration may then have
                the joints of the group alone, shape (k,) or (n, k), and a state be named without its group.
            keep: What the motion keeps at all times, one ``Keep`` or several (docs/constraints.md). Where it keeps another link
                at a pose that the goal's link sees, as the other hand at an object, the goal is one of both.
            certify: Whether each edge is certified, as by ``edge_in_collision``: free at all its configurations. Otherwise at
                samples 1/32 rad apart, between which it may touch something.
            clearance: No object of the world is nearer than this [m]; it does not count between links of the robot.
            seed: Chooses the samples. The result depends on nothing else, unless ``time_limit`` ends the search.
            max_checks: How many edges the search checks at most: 100,000 unless given.
            shorten: Whether the path that is found is shortened.
            escape: Whether a start that touches something by at most 10 mm is left, first of all, by an edge that is not checked;
                and one that is beyond the joint limits by a straight edge back within them, which is certified to touch nothing
                but keeps neither ``clearance`` nor ``keep``.
            time_limit: The longest time of the search [s], 10 s unless given; None for no limit. Not counted are the first edges,
                during which kernels may be compiled. Where it ends the search, the result depends on the machine.
            progress: Called about a hundred times a second during the search, with the number of edges checked so far and
                ``max_checks``; shortening may exceed that.

        Returns:
            A ``Plan``: path, status, and the reason if there is no path.

        Raises:
            InputError: An argument that cannot be taken, such as a goal outside the joint limits; its name is in the message.
            UnknownNameError: There is no such link, joint, group or state.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.

        Example:
            >>> import ulna
            >>> panda, world = ulna.load("panda"), ulna.World()
            >>> world.add("post", ulna.Box((0.1, 0.1, 1.2)), ulna.pose((0.5, 0.0, 0.6)))
            >>> left, right = panda.home + 0.0, panda.home + 0.0
            >>> left[0], right[0] = 0.8, -0.8
            >>> plan = panda.plan(left, right, world)
            >>> str(plan.status), plan.certified
            ('solved', True)
        """
        goal = goal_in_base(self.tree, goal, frame)
        options = PlanOptions(certify, clearance, seed, max_checks, shorten, escape, time_limit, progress).checked()
        members, states = None if group is None else group_named(group, self.groups), self.srdf.states
        if isinstance(q_start, str):
            q_start = configuration(state_named(q_start, states, members), self.tree, self.home)
        asked = PlanRequest(q_start, goal, world, link, task, held, members, states, keep, options, self._dynamics)
        return plan_motion(self._checker, self._inverse_kinematics, asked)

    def trajectory(
        self,
        q_path: ArrayLike | FollowedPath | Trajectory,
        *,
        within: float = 0.01,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
        limits: GivenLimits | None = None,
        hand: HandLimits | Iterable[HandLimits] | None = None,
        torque: ArrayLike | None = None,
        world: World | None = None,
        start_velocity: ArrayLike | None = None,
        end_velocity: ArrayLike | None = None,
    ) -> Trajectory:
        """The fastest motion along given configurations, within limits, by ``Plan.trajectory``'s method.

        It flows through the points. Without a world nothing is checked for collisions, and ``certified`` is false.

        Args:
            q_path: Joint positions [rad or m], shape (n, n_dof), n >= 1, within the limits, joined by straight lines; or what
                ``follow`` returns; or a motion, whose path is timed anew.
                Points that differ from the one before by at most 1e-9 are left out, and those on the line between two others.
            within: How far the motion may leave these lines [rad or m], above 0: at any time some configuration on them differs
                from the motion's by at most so much in each joint. More of it is faster.
            velocity: The greatest velocity [rad/s or m/s], a number or n_dof numbers; that of ``limits``, or of the robot.
            acceleration: The greatest acceleration [rad/s^2 or m/s^2]; needed unless ``limits`` or the robot states it.
            jerk: The greatest jerk [rad/s^3 or m/s^3]; unless given that of ``limits`` or of the robot, if one states it.
            limits: The name of an arm, as "franka", a file ``joint_limits.yaml``, or the mapping of one.
            hand: The greatest speed and acceleration of the hand, or of several links, at all times: ``HandLimits``.
            torque: The greatest torque of each joint [Nm or N], as of ``Plan.trajectory``; for True the limits of effort.
            world: Objects. Where a rounded corner is not certified to be free of them and of the robot itself, the motion stops;
                ``certified`` says whether all of it is free.
            start_velocity: The velocity at the start [rad/s or m/s], shape (n_dof,), along the first line, where the acceleration
                is 0; at rest unless given.
            end_velocity: The same at the end, along the last line.

        Returns:
            A ``Trajectory``.

        Raises:
            InputError: q_path is no such array, beyond a limit or not followed to its end, or another argument cannot be taken,
                such as a velocity at an end that is not along the path, or too great for it.
            UnknownNameError: There is no such set of limits.
            FileError: The file of limits cannot be read.
            DescriptionError: The file is none of limits.
            GeometryError: There is a world, and shapes that cannot be checked.

        Example:
            >>> import ulna
            >>> robot = ulna.load("panda")
            >>> s = np.linspace(0, 1, 30)[:, None]
            >>> motion = robot.trajectory(robot.home + 0.3 * np.sin(3 * s) * np.ones(7), limits="franka")
            >>> motion.stops, bool(motion.check("franka"))
            (0, True)
        """
        given = GivenMotion(velocity, acceleration, jerk, limits, hand, torque)
        return path_trajectory(q_path, self._checker, self._dynamics, world, within, given, (start_velocity, end_velocity))

    def motion_from_file(self, path: str | Path, *, others: ArrayLike | None = None) -> Trajectory:
        """A motion of this robot from elsewhere; see ``Trajectory.from_file``.

        Args:
            path: A message of ROS or a plan of MoveIt (``.yaml``, ``.yml``, ``.json``), or a table with times (``.csv``).
            others: Where joints are that the file does not name: q [rad or m], shape (n_dof,). Unless given, it names all.

        Raises:
            FileError, DescriptionError, InputError: As of ``Trajectory.from_file``.
        """
        from ulna.robot.motion_file import motion_of_file  # noqa: PLC0415 - it needs this class

        return motion_of_file(self, path, others)

    def plan_many(
        self,
        q_starts: ArrayLike | str | Sequence[str],
        goals: ArrayLike | Mapping[str, ArrayLike] | str | Sequence[str],
        world: World | Iterable[World | None] | None = None,
        *,
        progress: Callable[[int, int], None] | bool | None = None,
        **options: Any,
    ) -> tuple[Plan, ...]:
        """A plan for each of many problems, in several threads.

        Args:
            q_starts: Where to start [rad or m], shape (n, n_dof), or (n_dof,) for all; or names of states of the SRDF, or one.
            goals: Where to go: configurations, shape (n, n_dof), or poses, shape (n, 4, 4), one a problem; or poses of several
                links, shape (n, 4, 4) for each; or the names of states, or one for all.
            world: One for all, or one for each problem.
            progress: Called with the number of problems that are done, and of all, after each. True: a bar on standard error, if
                that is a terminal.
            options: Those of ``plan``.

        Returns:
            A ``Plan`` for each problem, in their order: the same bit for bit as that of ``plan``.

        Raises:
            InputError: The numbers of starts, goals and worlds do not go together; or ``plan`` refuses a problem, whose number is
                in the message.
            UnknownNameError: There is no such link, joint or state; a note names the row.
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        if "threads" in options:
            refuse_unknown("plan_many", ("threads",))
        if "held" in options:
            options["held"] = as_names(options["held"])  # once: it may be an iterator, and so may the constraints
        if isinstance(options.get("keep"), Iterator):
            options["keep"] = tuple(options["keep"])
        plan = partial(self.plan, **options)
        return plan_many(plan, q_starts, goals, world, progress=progress)

    def servo(
        self,
        world: World | None = None,
        *,
        acceleration: ArrayLike | None = None,
        rate: float = 1000,
        link: str | Sequence[str] | None = None,
        weights: ArrayLike | None = None,
        held: Iterable[str] = (),
        group: str | None = None,
        velocity: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
        clearance: float = 0.01,
        tracking_error: ArrayLike = 0.0,
        posture: ArrayLike | None = None,
        hand: HandLimits | Iterable[HandLimits] | None = None,
        torque: ArrayLike | None = None,
        torque_rate: ArrayLike | None = None,
    ) -> Servo:
        """A servo: it steers the arm tick by tick, and certifies each command together with a full stop after it (docs/servo.md).

        Args:
            world: The objects; none unless given. It may change between ticks.
            acceleration: The greatest of each joint [rad/s^2 or m/s^2], a number or shape (n_dof,), where it is below the
                robot's; needed unless the robot has one of every joint.
            rate: Ticks a second [Hz].
            link: The link that poses and twists are of, or several, such as both hands; the tip, of the group if one is
                named, unless given.
            weights: How much each of several links counts where not all can be where they are sent: of the squares of what each
                misses, 0.001 to 1000, a number or shape (n_links,); 1 unless given.
            held: Names of joints that keep their positions.
            group: A group of the SRDF (``robot.groups``): the joints outside keep their positions.
            velocity: The greatest of each joint [rad/s or m/s], a number or shape (n_dof,), where it is below the description's.
            jerk: The greatest of each joint [rad/s^3 or m/s^3], a number or shape (n_dof,); unless given that of the
                description, if it states one. With it no acceleration is used that takes longer than 0.1 s to begin.
            clearance: No object is nearer than this [m]; it does not count between links of the robot.
            tracking_error: How far each joint may be from its command [rad or m]: the certificate holds for all of that.
            posture: A configuration that the null space goes towards [rad or m], shape (n_dof,); none unless given.
            hand: The greatest speed and angular speed of the hand, or of several links, at all times; no limit unless given.
            torque: The greatest torque of each joint [Nm or N], a number or n_dof numbers; for True the limits of effort of the
                description. A tick is slower where it, or the stop after it, needs more. Torques are judged at samples.
            torque_rate: How fast a torque may change [Nm/s or N/s], a number or n_dof numbers; no limit unless given. It limits
                the jerks too, by the mass matrix. A Franka takes 1000 Nm/s.

        Raises:
            InputError: An argument that cannot be taken; its name is in the message.
            UnknownNameError: There is no such link, joint or group.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> servo = panda.servo(acceleration=5.0)
            >>> servo.start(panda.home).status
            <CommandStatus.AT_REST: 'at rest'>
            >>> for _ in range(400):
            ...     command = servo.step(twist=[0.1, 0, 0, 0, 0, 0])
            >>> str(command)
            'following'
        """
        members = None if group is None else group_named(group, self.groups)
        asked = ServoRequest(
            rate, link, weights, held, members, velocity, acceleration, jerk, clearance, tracking_error, posture,
            hand, torque, torque_rate, self._dynamics,
        )  # fmt: skip
        return Servo(self.tree, self._checker, world, asked)

    def show(
        self, q: ArrayLike | None = None, world: World | None = None, *, boxes: bool = False, size: tuple[int, int] | None = None
    ) -> Recording:
        """A picture of the robot, drawn with no display: a notebook shows it, and keeps it in its file.

        ``ulna.view(robot)`` opens a page instead, on which it can be moved.

        Args:
            q: Joint positions [rad or m], shape (n_dof,); ``home`` unless given.
            world: The obstacles; those that the robot touches are red.
            boxes: Show the boxes that collisions of the robot are checked with; red those that touch.
            size: Width and height [pixels]; 720 and 480 unless given.

        Returns:
            A ``Recording``; its ``save("arm.png")`` writes it.

        Raises:
            InputError: q, the world or the size cannot be taken.
            MissingExtraError: The extra ``viewer`` is not installed.
        """
        return drawer("robot")(self, q, world, boxes=boxes, size=size)

    @property
    def allowed_collisions(self) -> AllowedCollisions:
        """The pairs of links that may touch, each with its reason: found from joints and samples unless others were given."""
        return self._checker.allowed

    def collision_poses(self, q: ArrayLike, *, out: Array | None = None, **unknown: Never) -> Array:
        """The poses of the robot's collision shapes, in the order of ``collision_names``: shape (..., n_shapes, 4, 4).

        The arguments are those of ``link_poses``.

        Raises:
            InputError: q has another shape or an entry out of range, or ``out`` does not fit.
        """
        if unknown:
            refuse_unknown("collision_poses", unknown)
        return frame_poses(self.tree, self._checker.bodies.frames, q, out)

    @property
    def collision_names(self) -> tuple[str, ...]:
        """The names of the robot's collision shapes, attached objects last."""
        return self._checker.bodies.names

    # ---- the robot, changed --------------------------------------------------------------------------------------------

    def with_tool(
        self,
        T_flange_tool: ArrayLike,
        *,
        name: str = "tool",
        mass: float | None = None,
        com: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
    ) -> Robot:
        """The robot with a tool: one more link, fixed to the tip, which becomes the new tip.

        Args:
            T_flange_tool: The tool's pose in the frame of the tip, shape (4, 4).
            name: The new link's name.
            mass: Its mass [kg]; unless given, it is taken as weightless.
            com: Its center of mass in the frame of the tool [m], shape (3,); the origin of that frame unless given.
            inertia: Its inertia tensor about the center of mass, in the axes of that frame [kg m^2], shape (3, 3); zero unless
                given, as of a point.

        Raises:
            InputError: The pose is not a rigid motion, the robot has several tips, or it already has a link of this name. Or no
                body has this mass and tensor.

        Example:
            >>> import ulna
            >>> ulna.load("panda").with_tool(np.eye(4), name="gripper").tip
            'gripper'
        """
        T = as_one_pose(T_flange_tool, "T_flange_tool")
        description = with_tool(self.description, T, name, Payload(mass, com, inertia).of())
        if np.linalg.norm(T[:3, 3]) > FAR:
            check_description("T_flange_tool", description)
        return self._changed(description=description)

    def with_gravity(self, gravity: ArrayLike) -> Robot:
        """The robot as it is mounted: on a wall or a ceiling, for torques and motions within them.

        Args:
            gravity: The acceleration of free fall in the axes of the base [m/s^2], shape (3,).

        Raises:
            InputError: It is not three finite numbers.

        Example:
            >>> import ulna
            >>> hanging = ulna.load("panda").with_gravity((0, 0, 9.81))
            >>> hanging.gravity
            array([0.  , 0.  , 9.81])
        """
        return self._changed(gravity=gravity)

    def with_inertias(self, inertias: Mapping[str, Inertia | None]) -> Robot:
        """The robot with other inertias of some links: where a description has none, or wrong ones.

        Args:
            inertias: The inertia of each link by its name; None for a link that has none.

        Raises:
            InputError: A value is not an ``ulna.Inertia``.
            UnknownNameError: There is no such link.

        Example:
            >>> import ulna
            >>> arm = ulna.Robot.from_dh([(0, 0, 0, 0), (0.5, 0, 0, 0)])
            >>> arm = arm.with_inertias({"link2": ulna.Inertia(2.0, (0.2, 0, 0), np.diag([0.01, 0.1, 0.1]))})
            >>> arm.gravity_torque([0.0, 0.0], gravity=(0, -10, 0)).round(6)
            array([14.,  4.])
        """
        return self._changed(description=described_with(self.description, inertias))

    def with_limits(
        self,
        limits: GivenLimits | None = None,
        *,
        lower: Given | None = None,
        upper: Given | None = None,
        velocity: Given | None = None,
        acceleration: Given | None = None,
        jerk: Given | None = None,
    ) -> Robot:
        """The robot with narrower limits, as of a cell: plans, motions, inverse kinematics, servos and maps keep them.

        Each limit is a number for every joint, an array, shape (n_dof,), or a mapping by the names of joints, of those alone. A
        limit of a mimic joint narrows that of its leader. What may touch is as before, and ``home`` is moved into the limits.

        Args:
            limits: A file ``joint_limits.yaml`` or its mapping: its positions, velocities, accelerations and jerks.
            lower: Lower limits of position [rad or m].
            upper: Upper limits of position [rad or m].
            velocity: The greatest velocity [rad/s or m/s].
            acceleration: The greatest acceleration [rad/s^2 or m/s^2]; with one of every joint, ``trajectory`` and ``servo`` need
                none.
            jerk: The greatest jerk [rad/s^3 or m/s^3].

        Raises:
            InputError: A limit is wider than the robot's, is no limit, or leaves a joint no range.
            UnknownNameError: There is no such joint.
            FileError: The file cannot be read.
            DescriptionError: The file is none of limits.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> narrow = panda.with_limits(lower={"panda_joint1": -0.5}, upper={"panda_joint1": 0.5}, velocity=1.0)
            >>> float(narrow.upper[0]), float(narrow.velocity_limits.max())
            (0.5, 1.0)
        """
        given = {"lower": lower, "upper": upper, "velocity": velocity, "acceleration": acceleration, "jerk": jerk}
        return self._changed(_narrowed=narrower(self.tree, limits, given))

    def with_allowed_collisions(
        self, pairs: Iterable = (), *, at: ArrayLike | str | None = None, touching: float | None = None
    ) -> Robot:
        """The robot with more pairs of links that may touch.

        Args:
            pairs: Pairs of names, or the ``disabled_collisions`` of an SRDF: they are added. Or an ``AllowedCollisions``, as
                ``robot.allowed_collisions.minus(("a", "b"))`` makes it: then these are all.
            at: A configuration that is known to be free, such as the robot at rest [rad or m], shape (n_dof,), or the name of a
                state of the SRDF: the pairs that touch there are added. Hulls are larger than the links, so that some touch
                wherever the robot is.
            touching: The pairs that touched in at least this share of the random configurations are added, above 0 and at most 1.
                MoveIt's setup assistant uses 0.95.

        Raises:
            InputError: ``at`` is not one configuration, or ``touching`` not such a share.
            UnknownNameError: There is no such link or state.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda").with_allowed_collisions([("panda_link1", "panda_link7")])
            >>> ("panda_link1", "panda_link7") in panda.allowed_collisions
            True
        """
        if isinstance(at, str):
            at = configuration(state_named(at, self.srdf.states, None), self.tree, self.home)
        more = () if at is None else self._checker.links_that_touch(at)
        allowed = as_allowed(pairs, self.link_names)
        if not isinstance(pairs, AllowedCollisions):
            allowed = self.allowed_collisions.plus(*allowed)
        if touching is not None:
            more = *more, *self._checker.found.counted(self._checker.bodies).touching(touching)
        return self._changed(allowed=allowed.plus(*more) if more else allowed)

    def with_convex_hulls(self) -> Robot:
        """The robot with convex hulls in place of its collision meshes; hulls are checked exactly. Visuals are unchanged.

        A hull is larger than a mesh with hollows, so it may touch where the mesh would not; it holds all of the mesh. STL, OBJ
        and Collada files are read, found as by ``ulna.load``. The time of a query grows with the number of vertices.
        ``with_convex_pieces`` follows hollows.

        Raises:
            FileError: A mesh is not there, or cannot be read.
            MissingExtraError: What reads meshes and finds hulls is not installed (the extra ``hulls``).

        Example:
            >>> import ulna
            >>> ulna.load("ur5").with_convex_hulls().in_collision(np.zeros(6))  # pip install example-robot-data
            False
        """
        from ulna.description.meshes.hulls import with_hulls  # noqa: PLC0415 - needed for meshes alone

        return self._changed(description=with_hulls(self.description))

    def with_convex_pieces(self) -> Robot:
        """The robot with convex pieces in place of its collision meshes (convex decomposition). Visuals are unchanged.

        The pieces hold the mesh's whole surface, and stand out beyond it by much less than the hull. How far, as sampled, is the
        ``excess`` of each collision of ``robot.description.links``. CoACD finds them, with a fixed seed, in seconds to minutes
        for each mesh file; they are kept on disk by the file's content. A query takes longer than with hulls.

        Raises:
            FileError: A mesh is not there, cannot be read, or not be decomposed within the limits of time and memory.
            MissingExtraError: CoACD, or what reads meshes, is not installed (the extra ``decompose``).
        """
        from ulna.description.meshes.decompose import with_pieces  # noqa: PLC0415 - needed for meshes alone

        return self._changed(description=with_pieces(self.description))

    def with_spheres(self, *, within: float = 0.01, most: int | None = None) -> Robot:
        """The robot with balls that cover its collision meshes, in their place. Other shapes and visuals are unchanged.

        A free verdict holds for the mesh and what it encloses: every point of a triangle, and every point about which a surface
        of the mesh winds, is in a ball; that is proved, not sampled. Holes in a surface count as closed, cavities as filled. In
        turn, every point of a ball is at most ``within`` from the mesh or what it encloses, proved too; it is the ``excess`` of
        each such collision of ``robot.description.links``. So the balls of two links may touch where the links are up to twice
        ``within`` apart. Which pairs of links may touch is found anew from the balls, as it is with pieces;
        ``with_allowed_collisions(at=q)`` allows more.

        The balls are found in seconds to minutes for each mesh file, and kept on disk by the file's content. Their number grows
        as ``within`` gets smaller, most along sharp edges. Boxes, cylinders, capsules and spheres of the description, and
        attached objects, are checked as they are.

        Args:
            within: The largest distance of a point of a ball from the mesh and what it encloses [m], above 0.
            most: The largest number of balls for each mesh; unless given, as many as are needed.

        Raises:
            FileError: A mesh is not there, or cannot be read.
            GeometryError: More than ``most`` balls are needed; the message says with which ``within`` they suffice. Or
                ``within`` is too small for the size of a mesh.
            InputError: ``within`` is not such a distance, or ``most`` not a count.
            MissingExtraError: What reads meshes is not installed (the extra ``hulls``).

        Example:
            >>> import ulna
            >>> ulna.load("ur5").with_spheres(within=0.05).in_collision(np.zeros(6))  # pip install example-robot-data
            False
        """
        from ulna.description.meshes.spheres import with_balls  # noqa: PLC0415 - needed for meshes alone

        return self._changed(description=with_balls(self.description, within, most))

    def with_attached(
        self,
        name: str,
        shape: Solid,
        T_link_object: ArrayLike,
        *,
        link: str | None = None,
        touch_links: Iterable[str] = (),
        mass: float | None = None,
        com: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        density: float | None = None,
    ) -> Robot:
        """The robot with an attached object: it moves with a link, and is checked like the robot's own shapes.

        With a mass or a density its weight is part of the arm's, until ``without_attached``. The frame of the object is that of
        its shape, whose pose is ``T_link_object``. ``to_urdf`` writes neither its shape nor its mass.

        Args:
            name: The object's name in reports.
            shape: What it is.
            T_link_object: Its pose in the frame of the link, shape (4, 4).
            link: The link that holds it, and may touch it; the tip unless given.
            touch_links: Other links that may touch it, such as fingers.
            mass: Its mass [kg]; without it and without a density it is taken as weightless.
            com: Its center of mass in the frame of the object [m], shape (3,); the centroid of the shape unless given, which only
                of a convex mesh is not the origin.
            inertia: Its inertia tensor about the center of mass, in the axes of that frame [kg m^2], shape (3, 3); unless given,
                that of the shape about its centroid, with the mass spread evenly.
            density: Its density [kg/m^3], in place of mass, com and inertia: that times the volume of the shape is the mass.

        Raises:
            GeometryError: The shape is not a solid that can be attached.
            InputError: The name is taken or not text, or the pose is not a rigid motion. Or no body has this mass and tensor, or
                the density is of a shape without volume.
            MissingExtraError: A convex mesh has no ``com`` or no ``inertia``, and the extra ``hulls`` is not installed.
            UnknownNameError: There is no such link, or no such link or attached object to touch.

        Example:
            >>> import ulna
            >>> robot = ulna.load("panda").with_attached("cup", ulna.Box((0.05, 0.05, 0.1)), np.eye(4))
            >>> robot.without_attached("cup").attached
            ()
        """
        holder = self.tree.link_or_tip(link)
        new = Attached(name, shape, as_one_pose(T_link_object, "T_link_object"), holder, touch_links)  # type: ignore[arg-type]
        new = replace(new, inertia=Payload(mass, com, inertia, density).of(shape))
        check_object(name, shape, new.T_link_object)
        return self._changed(attached=attach(self.attached, new, self.link_names))

    def without_attached(self, name: str) -> Robot:
        """The robot without an attached object. ``world.add`` can add it to a world.

        Raises:
            UnknownNameError: There is no such attached object.
        """
        return self._changed(attached=detach(self.attached, name))

    # ---- the parts it is made of ---------------------------------------------------------------------------------------

    def _changed(self, **changes: Any) -> Robot:
        kept = {"description": self.description, "home": self.home, "attached": self.attached, "allowed": self._checker.given}
        kept.update(_narrowed=self.tree.narrowed, gravity=self.gravity)
        if "description" not in changes:
            kept["_found"] = self._checker.found
        return Robot(**{**kept, **changes})

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Robot cannot be changed: {name} = {value!r}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a Robot cannot be changed: del {name}")

    def __reduce__(self):
        return _restore, (self.description, self.home, self.attached, self._checker.given, self.tree.narrowed, self.gravity)

    def __dir__(self) -> list[str]:
        return without_other_names(super().__dir__())

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {self.n_dof} dof, {self.base} to {self.tip or f'{len(self.tree.leaves)} tips'}>"

    def _repr_html_(self) -> str:
        columns = (each.tolist() for each in (self.lower, self.upper, self.velocity_limits, self.home))
        rows = zip(entry_names(self.tree), *columns, strict=True)
        return table(repr(self)[1:-1], ("joint", "lower", "upper", "velocity", "home"), rows, ["in rad and s; m for slides"])


put_other_names(Robot)


def _one_configuration(tree: Tree, home: ArrayLike) -> Array:
    q = as_floats("home", home)
    if q.shape != (tree.n_dof,) or not np.isfinite(q).all():
        raise InputError("home", f"shape {q.shape}; {tree.n_dof} finite numbers are expected, one for each entry of q")
    return q


def _restore(
    description: Description,
    home: Array,
    attached: tuple[Attached, ...],
    allowed: AllowedCollisions | None,
    narrowed: Narrowed | None,
    gravity: Array,
) -> Robot:
    return Robot(description, home=home, attached=attached, allowed=allowed, gravity=gravity, _narrowed=narrowed)
