"""Holds a robot and passes each call to the layer that computes it.

A ``Robot`` is composed of a description, its tree in flat arrays, functions bound to a link, and a collision checker. Its methods
compute nothing: each calls one function of the folders below.
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
from ulna.collision.sampled_pairs import SampledPairs
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
from ulna.dynamics.bodies import replace_inertias
from ulna.dynamics.dynamics import FREE_FALL, Dynamics, as_gravity
from ulna.errors import InputError, refuse_unknown
from ulna.ik.closed_form.closed_form import ClosedForm, closed_form_of
from ulna.ik.differential import differential_ik
from ulna.ik.followed_path import FollowedPath
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import N_SAMPLES, TOLERANCE, Options, Request
from ulna.ik.result import IKResult
from ulna.ik.solutions import IKSolutions
from ulna.ik.task import Task
from ulna.kinematics.forward import CompiledForward, ForwardByLink, frame_poses
from ulna.kinematics.frames import Frame, frame_pose, goal_in_base, poses_in_base, twist_in_base
from ulna.kinematics.groups import JointGroup, configuration, group_named, joint_groups, state_named
from ulna.kinematics.jacobian import CompiledJacobian, JacobianByLink, analytical_jacobian, manipulability
from ulna.kinematics.narrowed import narrowed_description, narrowed_tree
from ulna.kinematics.positions import as_names, q_of_joints
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
from ulna.planning.tightened_limits import Given, narrow_limits
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
# Default arguments, compared by identity: a call with only defaults skips the checks of options.
_SEED, _TASK, _NONE = 0, "pose", ()


class Robot(Forces):
    """A robot: its kinematic tree, forward and inverse kinematics, Jacobians, collision queries, plans and forces.

    ``ulna.load`` and ``Robot.from_dh`` make one. It is immutable, picklable and safe to share between threads; its arrays are
    read-only.
    """

    description: Description
    """The links and joints of the description."""
    tree: Tree
    """The links and joints as flat arrays, for the kernels."""
    home: Array
    """The default start configuration [rad or m], shape (n_dof,)."""
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
        _found: SampledPairs | None = None,
        _narrowed: Narrowed | None = None,
    ) -> None:
        wide = build_tree(description)
        tree = wide if _narrowed is None else narrowed_tree(wide, _narrowed)
        start = np.clip(np.zeros(tree.n_dof) if home is None else _check_home(tree, home), tree.lower, tree.upper)
        start.setflags(write=False)
        carried = tuple(attached)
        checker = Checker(description, tree, carried, allowed, _found or SampledPairs(description, wide))
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
            rows: a [m], d [m], alpha [rad], theta_offset [rad], shape (n, 4). Or a ``DHTable``, which includes the other
                arguments.
            convention: ``"modified"``: Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a) Rx(alpha).
            joint_types: ``"revolute"`` (the default for all), ``"continuous"``, ``"prismatic"`` or ``"fixed"``, one per row.
            limits: Lower and upper limit of each moving joint [rad or m], shape (n_moving, 2); no limits unless given.
            T_base_0: The pose of the link ``link0``, the frame before the first row, shape (4, 4); the identity unless given.
            T_n_tip: The pose of the link ``tip`` in the frame of the last row, shape (4, 4); the identity unless given.
            name: The robot's name.

        Raises:
            InputError: The rows, types, limits or poses do not fit each other, or the convention is unknown. Or a ``DHTable`` is
                given together with arguments that it includes.

        Example:
            >>> import ulna
            >>> planar = ulna.Robot.from_dh([(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)], joint_types=["revolute"] * 2 + ["fixed"])
            >>> planar.forward_kinematics([0.0, np.pi / 2])[:3, 3].round(12)
            array([1., 1., 0.])
        """
        if isinstance(rows, DHTable):
            if (convention, joint_types, limits, T_base_0, T_n_tip, name) != ("modified", None, None, None, None, "robot"):
                raise InputError("rows", "a DHTable includes the other arguments; pass table.rows to choose your own")
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

    # ---- model ---------------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """The robot's name in its description."""
        return self.description.name

    @property
    def n_dof(self) -> int:
        """The number of entries of q: the degrees of freedom of the independent joints, without mimic joints."""
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
        """All links, in the order of the description."""
        return self.tree.link_names

    @property
    def base(self) -> str:
        """The link in whose frame all poses are given."""
        return self.tree.root

    @property
    def tip(self) -> str | None:
        """The link at the end of the arm: the only moving link without child links; None if there are several."""
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
        """Lower soft limits of the safety controllers [rad or m], shape (n_dof,); ``lower`` where there is none."""
        return self.tree.soft_lower

    @property
    def soft_upper(self) -> Array:
        """Upper soft limits of the safety controllers [rad or m], shape (n_dof,); ``upper`` where there is none."""
        return self.tree.soft_upper

    @property
    def velocity_limits(self) -> Array:
        """Maximum speeds [rad/s or m/s], shape (n_dof,); inf where the description gives none."""
        return self.tree.velocity_limits

    @property
    def acceleration_limits(self) -> Array:
        """Maximum accelerations and decelerations [rad/s^2 or m/s^2], shape (n_dof,); inf where the description gives none."""
        return self.tree.acceleration_limits

    @property
    def jerk_limits(self) -> Array:
        """Maximum jerks [rad/s^3 or m/s^3], shape (n_dof,); inf where the description gives none."""
        return self.tree.jerk_limits

    @property
    def effort_limits(self) -> Array:
        """Maximum torques and forces [Nm or N], shape (n_dof,); inf where the description gives none."""
        return self.tree.effort_limits

    @property
    def srdf(self) -> Srdf:
        """The semantic description, with names checked against the robot; empty where none was given."""
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
        """q, shape (n_dof,), from joint names and positions, as a ``JointState`` message of ROS has them.

        Args:
            names: Joints in any order. Unknown names are ignored: a ``JointState`` also has mimic joints and joints of other
                robots.
            positions: The position of each named joint [rad or m], shape (len(names),).
            others: The configuration that gives the joints not named [rad or m], shape (n_dof,). Unless given, every joint must
                be named.

        Raises:
            InputError: The positions do not match the names or are not finite, or a joint is missing or named twice. Or a named
                joint has several positions, as a planar joint.

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
            n: The number of configurations; one configuration of shape (n_dof,) unless given.
            seed: A seed for ``numpy.random.default_rng``: the same number gives the same configurations. Unless given, each call
                gives different ones.

        Returns:
            Shape (n, n_dof), or (n_dof,) if n is None [rad or m]. An angle without limits is within +-pi. A slide without limits
            is within plus or minus the robot's length with its slides at 0. Each angle of a floating joint is uniform.

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
        """URDF text: the expanded text that was read, or generated text for a robot from another source.

        Attached objects are left out.

        Args:
            mesh_paths: ``"given"`` leaves the paths of meshes as they were; ``"file"`` writes absolute ``file://`` addresses, as
                RViz needs.

        Raises:
            FileError: With ``"file"``: a mesh does not exist; the message lists every path tried.
        """
        described = narrowed_description(self.description, self.tree)
        text = described.text or write_urdf(described)
        return with_mesh_paths(mesh_paths, text, described.folder, described.package_dirs)

    def dh(self, *, convention: str = "modified", link: str | None = None, tolerance: float = PARALLEL) -> DHTable:
        """The Denavit-Hartenberg table of the chain from the base to a link, with its largest difference from the robot.

        Args:
            convention: ``"modified"``: Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a) Rx(alpha).
            link: The link's name; the tip unless given.
            tolerance: Axes within this angle [rad] count as parallel, and parallel axes within this distance [m] as coincident.
                The resulting error is in the table's ``max_position_difference`` and ``max_rotation_difference``.

        Returns:
            A ``DHTable``: one row for each moving joint, and the poses of the base and the tip, which absorb fixed joints.
            ``print`` shows it; ``Robot.from_dh`` makes a robot of it.

        Raises:
            InputError: The chain has a planar or floating joint, or axes so nearly parallel that their common normal is too far
                away.

        Example:
            >>> import ulna
            >>> ulna.load("panda").dh().rows[4]
            array([-0.0825    ,  0.384     , -1.57079633,  0.        ])
        """
        return dh_table(
            narrowed_description(self.description, self.tree), self.tree, self.tree.link_or_tip(link), convention, tolerance
        )

    # ---- kinematics ----------------------------------------------------------------------------------------------------

    def forward_kinematics(
        self, q: ArrayLike, *, link: str | None = None, frame: Frame | None = None, out: Array | None = None, **unknown: Never
    ) -> Array:
        """The pose of a link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            frame: The frame of the result instead of the base: any link, such as ``"base"`` of a UR, the frame of its pendant. Or
                a pose T_base_frame, shape (4, 4).
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            T_base_link, shape (..., 4, 4); with ``frame`` T_frame_link.

        Raises:
            InputError: q has another shape or an entry out of range, ``out`` does not fit, or the robot has several tips and no
                link is named. Or both ``out`` and ``frame`` are given.
            UnknownNameError: There is no such link.
        """
        if unknown:
            refuse_unknown("forward_kinematics", unknown)
        if frame is not None:
            if out is not None:
                raise InputError("out", "cannot be combined with frame=")
            T_base_frame = self.forward_kinematics(q, link=frame) if isinstance(frame, str) else frame_pose(self.tree, frame)
            return inverse(T_base_frame) @ self.forward_kinematics(q, link=link)
        try:
            forward = self._forward.get(link)
        except TypeError:  # not hashable, so not the name of a link
            forward = None
        return (forward or self._forward.of(link))(q, out)

    def compile_forward(self, *, link: str | None = None) -> CompiledForward:
        """Forward kinematics of one link as a function ``fk(q, out=None)``, for control loops: same result, faster.

        Args:
            link: The link's name; the tip unless given.

        Returns:
            A function that maps q, shape (..., n_dof), to T_base_link, shape (..., 4, 4). It raises the errors of
            ``forward_kinematics``, can be pickled, and can be called from many threads at once.

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
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

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
        """The geometric Jacobian: the link's velocity per unit rate of each entry of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``: velocity of the link's origin and angular velocity, in the axes of the base;
                ``"link"``: the same in the axes of the link (body twist); ``"spatial"``: velocity of the point that passes
                the base's origin, in the axes of the base.
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            J, shape (..., 6, n_dof): rows v_x, v_y, v_z [m/s], w_x, w_y, w_z [rad/s].

        Raises:
            InputError: q has another shape or an entry out of range, ``expressed_in`` is not a frame, or ``out`` does not fit.
                Or the robot has several tips and no link is named.
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
        """A copy of the robot that computes batches on an NVIDIA GPU, with one problem per thread.

        It runs the same kernels as the CPU. Its methods have the same names. They take NumPy arrays or arrays on the device, and
        return arrays of the same kind.

        Args:
            float32: Compute poses, Jacobians and collisions of boxes in float32, for cards with few float64 units.

        Raises:
            DeviceError: No GPU can be used, or numba-cuda does not work with this NumPy.
            InputError: The robot has no moving joints.
            MissingExtraError: Neither the extra ``cuda12`` nor ``cuda13`` is installed.
        """
        from ulna.gpu.robot import GpuRobot  # noqa: PLC0415 - needs the extra

        return GpuRobot(self, float32=float32)

    def compile_jacobian(self, *, link: str | None = None, expressed_in: str = "base") -> CompiledJacobian:
        """The Jacobian of one link as a function ``jac(q, out=None)``, for control loops: same result, faster.

        Args:
            link: The link's name; the tip unless given.
            expressed_in: ``"base"``, ``"link"`` or ``"spatial"``, as for ``jacobian``.

        Returns:
            A function that maps q, shape (..., n_dof), to J, shape (..., 6, n_dof). It raises the errors of ``jacobian``, can be
            pickled, and can be called from many threads at once.

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
        """The analytical Jacobian: the rates of a link's x, y, z, roll, pitch and yaw per unit rate of q.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            Shape (..., 6, n_dof), rows in m/s and rad/s; R = Rz(yaw) Ry(pitch) Rx(roll).

        Raises:
            SingularityError: |cos(pitch)| < 1e-6 in some rows; the error's ``rows`` lists them.
        """
        if unknown:
            refuse_unknown("analytical_jacobian", unknown)
        return analytical_jacobian(self.tree, q, self.tree.link_or_tip(link), out)

    def manipulability(self, q: ArrayLike, *, link: str | None = None, out: Array | None = None, **unknown: Never) -> Any:
        """The manipulability of a link: sqrt(det(J J')), 0 at a singularity (Yoshikawa 1985).

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            link: The link's name; the tip unless given.
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            Shape (...,): the volume of the velocity ellipsoid, up to a factor. With fewer than six joints it is computed from
            J' J; it is 0 for a link that no joint moves.

        Raises:
            InputError: q has another shape or an entry out of range, ``out`` does not fit, or the robot has several tips and no
                link is named.
            UnknownNameError: There is no such link.
        """
        if unknown:
            refuse_unknown("manipulability", unknown)
        return manipulability(self.tree, q, self.tree.link_or_tip(link), out)

    # ---- inverse kinematics --------------------------------------------------------------------------------------------

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

        A link with an exact closed form of six joints (``closed_form``) is solved for the whole pose without a search. All
        branches are computed; the result is the branch nearest to ``q_seed`` or ``home``, or the branch of the best rank. Other
        arms and tasks are searched numerically, and so is any target with ``posture``, ``held`` or ``max_step``.

        Args:
            T: The target poses, T_base_link, shape (..., 4, 4). Or a ``Keep`` with a pose: it sets the link and the task, and
                the solution satisfies it.
            q_seed: Where to start [rad or m], shape (..., n_dof), broadcast with T: one target may have several seeds. The
                search first starts from the seed. If that fails, random restarts follow, and the solution nearest to the seed is
                returned. Without a seed the search starts from ``home`` and random configurations.
            link: The link's name; the tip unless given.
            frame: The frame of T, if not the base: a link that stands still, such as ``"base"`` of a UR, the frame of its
                pendant. Or the frame's pose T_base_frame, shape (4, 4), such as the pose of a work object.
            seed: Seed of the random configurations. The result is deterministic unless ``time_limit`` is given.
            task: ``"pose"``; ``"position"``: any orientation; ``"pointing"``: position and the direction of the link's z axis;
                or an ``ulna.Task`` (another axis, slack by component).
            world: Configurations that collide with it, or with the robot itself, are rejected, and the search continues.
            rank: The criterion that selects one of several solutions: ``"nearest"`` to the seed (largest joint change),
                ``"manipulability"``, ``"clearance"`` from the world, or ``"mid_range"`` of the joints. The solutions come from
                sixteen starts.
            posture: A configuration, shape (n_dof,), or ``"mid_range"``: the null space moves towards it from the seed. The pose
                has priority: at joint limits, or when the steps run out, the posture is approached less closely or not at all.
            held: Names of joints that keep their positions in the seed.
            max_step: The largest difference of any entry of q from ``q_seed`` [rad or m]; a solution beyond it is rejected.
            position_tolerance: The largest position error that counts as solved [m].
            rotation_tolerance: The largest rotation error that counts as solved [rad].
            max_iterations: The maximum number of steps of all starts together; 16 000 (800 starts) unless given. The closed form
                takes no steps.
            time_limit: The maximum time of the search [s], checked between rounds of restarts.
            trace: For one target: record the errors, the step and the damping of every step in ``result.trace``.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            An ``IKResult``: q, success, status, errors, iterations and reasons. A target that is not reached raises no error.

        Raises:
            InputError: An argument is invalid, such as a T that is not a rigid motion; the message names it.
            UnknownNameError: There is no such link or joint.
            GeometryError: A world is given, and the robot has no collision shapes, or shapes that cannot be checked.
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
                raise InputError("task", "a constraint includes a task; leave out task=")
            if frame is not None:
                raise InputError("frame", "cannot be combined with a constraint, which is in the base")
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
        """The closed form of the tip's inverse kinematics: family, held joint, deviation of the axes; None without one.

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
        """All joint positions that bring a link to poses, with a proof of completeness where there is a closed form.

        Arms of six joints of a family with a closed form have at most eight solutions, whole turns aside. For arms of seven
        joints, one joint is held at ``n_samples`` positions, and all solutions are computed at each. Arms of three joints have a
        closed form for positions, arms of five for pointing. Arms of three, four and five joints also have one for whole poses,
        which decides whether a pose can be reached; so do planar arms of two and three joints. Other arms are searched
        numerically for each pose.

        Args:
            T: The target poses, T_base_link, shape (..., 4, 4).
            q_seed: Each solution is turned by whole turns to be nearest to this configuration [rad or m], shape (n_dof,);
                ``home`` unless given.
            link: The link's name; the tip unless given.
            frame: The frame of T, if not the base: a link that stands still, such as ``"base"`` of a UR, the frame of its
                pendant. Or the frame's pose T_base_frame, shape (4, 4), such as the pose of a work object.
            task: The components of the pose that count: ``"pose"``, ``"position"``, ``"pointing"``, or an ``ulna.Task``.
            world: Solutions that collide with it, or with the robot itself, are not valid.
            rank: The criterion that sorts the solutions, best first: ``"nearest"`` to ``q_seed``, ``"manipulability"``,
                ``"clearance"`` or ``"mid_range"``; see ``inverse_kinematics``. Solutions that are not valid come last. Unless
                given, they are not sorted.
            redundancy: The joint of seven that is held; the joint of ``closed_form`` unless given. Or ``"elbow"``, for arms with
                a spherical shoulder and wrist: the angle of the arm about the line between them.
            n_samples: The number of positions at which it is held, spread evenly over its range. A search that finds more
                solutions than can be listed returns this number of solutions, far from each other.
            whole_turns: Whether to list every whole turn that the limits allow, and no solution beyond the limits. Otherwise
                each branch is listed once. Where branches coincide (see ``proof``), one solution is listed more than once, up to
                rounding.
            seed: Seed of the random starts of a search. The result is deterministic.
            position_tolerance: The largest position error that counts as solved in a search [m].
            rotation_tolerance: The largest rotation error that counts as solved in a search [rad].
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            An ``IKSolutions``: q (..., m, n_dof), valid, real, proof, family. For one target, ``found.q[found.valid]`` are the
            solutions within the limits and clear of the world. Joints whose angle is arbitrary are near ``q_seed``.

        Raises:
            InputError: T is not an array of poses, or the robot has several tips and no link is named. ``redundancy`` is not a
                joint of an arm of seven, or holding it leaves no closed form. Or another argument is invalid.
            UnknownNameError: There is no such link or joint.
            GeometryError: A world is given, and the robot has no collision shapes, or shapes that cannot be checked.

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
        """The joint path through a path of poses, without jumps between branches; or where and why it ends.

        Among all joint paths with no step longer than ``max_step``, the result has the least sum of squared joint steps. The step
        from ``q_start`` to the first pose is included; without ``q_start`` the step from ``home``, which may have any length. If
        the link has an exact closed form of six joints, all branches of all poses are compared. Other arms are searched
        numerically. With seven or more joints, or with a task that leaves part of the pose free, the redundancy is
        sampled. The best path through the graph of samples is smoothed.

        Args:
            T_path: The poses in order, T_base_link, shape (n, 4, 4).
            q_start: The configuration before the first pose [rad or m], shape (n_dof,): the path begins at most ``max_step`` from
                it. Unless given, the path may begin anywhere; the sum includes the step from ``home``.
            link: The link's name; the tip unless given.
            frame: The frame of T_path, if not the base: a link that stands still, such as ``"base"`` of a UR, the frame of its
                pendant. Or the frame's pose T_base_frame, shape (4, 4), such as the pose of a work object.
            task: The components of each pose that count, as for ``inverse_kinematics``. ``"pointing"`` leaves the rotation about
                the tool's axis free (welding, milling). A ``Task`` may leave a tolerance band, within which the path is
                optimized.
            max_step: The largest step of any joint from one pose to the next [rad or m]. Another branch is rarely within 0.1 rad.
                Poses that are further apart need a larger ``max_step``, or poses in between.
            world: Configurations that collide with it, or with the robot itself, are excluded. The straight edges between
                neighboring configurations are certified to be free (``edge_in_collision``).
            rank: The cost to minimize instead, summed over the poses: ``"nearest"``: the largest difference of a joint from
                ``q_start``, or ``home``; ``"manipulability"``; ``"clearance"`` from the world; ``"mid_range"`` of the joints.
                The squared joint steps, as shares of ``max_step``, are added to each.
            seed: Seed of the random configurations of a search. The result is deterministic unless ``time_limit`` ends the
                search.
            time_limit: The maximum time of the search [s]; None for no limit. It is checked between rounds of some hundredths to
                tenths of a second. A path found before the limit is returned, less smooth.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            A ``FollowedPath``: q, status, reason, steps. If the path cannot continue, ``ends_at`` and ``ending`` say where and
            why.

        Raises:
            InputError: T_path is not an array of poses, ``max_step`` is not above 0, or another argument is invalid.
            UnknownNameError: There is no such link.
            GeometryError: A world is given, and the robot has no collision shapes, or shapes that cannot be checked.

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
        """The joint velocities of one control step that best give a link a twist, within velocity and position limits.

        They minimize |J qd - twist|^2 + damping^2 |qd|^2 within the limits. The minimum is unique; near singularities the damping
        keeps the velocities small.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            twist: v [m/s] and w [rad/s] of the link, shape (..., 6).
            dt: The step's duration [s]: ``q + dt * qd`` lies within the position limits, up to rounding. A joint beyond a
                position limit returns to it, at most at its velocity limit.
            link: The link's name; the tip unless given.
            expressed_in: The frame of the twist; see ``jacobian``.
            frame: The axes of the twist instead of the base's: a link that stands still, or the frame's pose T_base_frame, shape
                (4, 4). It requires ``expressed_in="base"``.
            damping: Above 0. Far from singularities, velocities are too small by a share of about damping^2 / sigma^2, with sigma
                the smallest singular value of J. No joint moves faster than |twist| / (2 damping). A damping below 1e-4 |J|, or
                1e-2 |J| for fewer than six joints, takes several times longer. Singular values below 1e-14 |J| are within the
                rounding of J, and count as 0.
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            qd [rad/s or m/s], shape (..., n_dof).

        Raises:
            InputError: q or twist has another shape or an entry out of range, or dt or damping is not above 0.
                ``expressed_in`` is not a frame, ``out`` does not fit, or the robot has no joint.
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

    # ---- collision -----------------------------------------------------------------------------------------------------

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
            world: The obstacles; none unless given.
            self_collision: Also check the robot's links against each other, except ``allowed_collisions``.
            out: A bool array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            A bool for one q, else an array, shape (...,).

        Raises:
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
        """
        if unknown:
            refuse_unknown("in_collision", unknown)
        return self._checker.in_collision(q, world, self_collision, out)

    def links_near(
        self, cloud: PointCloud, q: ArrayLike, *, within: float = 0.0, pose: ArrayLike | None = None
    ) -> tuple[tuple[str, ...], NDArray[np.int64]]:
        """The links and attached objects with collision shapes, and the index of the nearest to each ball of a cloud.

        ``PointCloud.without`` uses it to remove the points of the robot that a camera sees.

        Args:
            cloud: The cloud.
            q: Joint positions [rad or m], shape (n_dof,).
            within: The largest distance of a ball from a shape [m]; with 0 only balls that touch count.
            pose: T_base_cloud, shape (4, 4); the identity unless given.

        Returns:
            The names, and the index into them of the nearest to each point, shape (n,); -1 if all are farther.

        Raises:
            InputError: q is not one configuration, ``within`` is not a length, or the pose is not a rigid motion.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
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
        """The colliding pairs of shapes, of the robot with objects or with itself, with depths and contact points.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The obstacles; none unless given.
            self_collision: Also check the robot's links against each other, except ``allowed_collisions``.
            max_distance: Also report pairs apart by up to this distance [m]; ``np.inf`` reports all pairs.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            A ``Report`` for one q, else an array of reports, shape (...,).

        Raises:
            InputError: q has another shape or an entry out of range, ``max_distance`` is not a number of at least 0, or there is
                nothing to check.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
            UnknownArgumentError: There is no such argument.
        """
        if unknown:
            refuse_unknown("check_collision", unknown, "max_distance= is the largest distance of a pair")
        return self._checker.check_collision(q, world, self_collision, max_distance)

    def distances(
        self, q: ArrayLike, world: World | None = None, *, within: float = 0.1, self_collision: bool = True, **unknown: Never
    ) -> Distances:
        """The distances of all near pairs of shapes, of the robot with objects or with itself, with gradients.

        They serve as linear constraints: to first order the distance of pair k at ``q + dq`` is
        ``signed_distance[k] + gradient[k] @ dq``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The obstacles; none unless given.
            within: The largest distance of a pair [m]; ``np.inf`` gives all pairs.
            self_collision: Also measure between the robot's links, except ``allowed_collisions``.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            The ``Distances``, as arrays. For a point cloud or a height map they have only the point or column nearest to each of
            the robot's shapes.

        Raises:
            InputError: q has another shape or an entry out of range, ``within`` is not a number of at least 0, or there is
                nothing to check.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.

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
        """The least distance of the robot's shapes from objects and from each other [m]; negative where they overlap.

        The magnitude of a negative distance is the penetration depth. ``signed_distance(q) <= 0`` equals ``in_collision(q)``.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The obstacles; none unless given.
            self_collision: Also measure between the robot's links, except ``allowed_collisions``.
            out: A float64 array of the result's shape, which is filled and returned.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            A number for one q, else an array, shape (...,); infinite if there is no pair to measure.

        Raises:
            InputError: q has another shape or an entry out of range, ``out`` does not fit, or there is nothing to check.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
        """
        if unknown:
            refuse_unknown("signed_distance", unknown)
        return self._checker.signed_distance(q, world, self_collision, out)

    def distance_gradient(
        self, q: ArrayLike, world: World | None = None, *, self_collision: bool = True, out: Array | None = None, **unknown: Never
    ) -> Array:
        """The derivative of ``signed_distance`` with respect to q [m/rad or m/m], shape (..., n_dof).

        Where two pairs are equally near, or a pair has several nearest points, it is the derivative for one of them. It is zero
        if there is no pair to measure. It takes the arguments of ``signed_distance``.

        Raises:
            InputError: See ``signed_distance``.
            GeometryError: See ``signed_distance``.
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
        """Whether anything collides on the straight line from one configuration to another, at any of its configurations.

        The certificate rests on lower bounds of distances that include rounding, not on samples (docs/edges.md).

        Args:
            q_a: Joint positions at the start [rad or m], shape (..., n_dof).
            q_b: Joint positions at the end, of a shape that broadcasts with q_a. Joints move linearly; none takes a shorter turn.
            world: The obstacles; none unless given.
            self_collision: Also check the robot's links against each other, except ``allowed_collisions``.
            resolution: A clearance below this [m] may count as a contact; a larger clearance never does.
            **unknown: Any other argument raises ``UnknownArgumentError``.

        Returns:
            An ``EdgeReport``: in_collision, and the share of the edge that is free.

        Raises:
            InputError: q_a or q_b has another shape or an entry out of range, or their shapes do not broadcast. ``resolution`` is
                below 1e-5 m, or there is nothing to check.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
        """
        if unknown:
            refuse_unknown("edge_in_collision", unknown)
        return self._checker.edge_in_collision(q_a, q_b, world, self_collision, resolution)

    def edge_keeps(self, q_a: ArrayLike, q_b: ArrayLike, keep: Keep | Iterable[Keep]) -> KeepReport:
        """Whether the straight line from one configuration to another satisfies constraints at all its configurations.

        The certificate rests on bounds of a link's motion that include rounding, not on samples (docs/edges.md).

        Args:
            q_a: Joint positions at the start [rad or m], shape (..., n_dof).
            q_b: Joint positions at the end, of a shape that broadcasts with q_a. Joints move linearly; none takes a shorter turn.
            keep: The constraints. A constraint without a pose keeps the link's pose at the (first) q_a.

        Returns:
            A ``KeepReport``: kept, and the greatest share of a tolerance that the edge uses. An edge that uses more than 0.9999
            of a tolerance may count as not kept.

        Raises:
            InputError: q_a or q_b has another shape or an entry out of range, or their shapes do not broadcast. A constraint is
                invalid, or none is given.
            UnknownNameError: A constraint names an unknown link.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> tilted = panda.home + 0.0
            >>> tilted[5] += 0.2
            >>> panda.edge_keeps(panda.home, tilted, ulna.Keep.upright(within=0.1)).kept
            False
        """
        return edge_keeps(self.tree, q_a, q_b, keep)

    # ---- planning, trajectories and servoing ---------------------------------------------------------------------------

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
        """Plan a collision-free path from a configuration to a goal, as straight edges in joint space.

        The search is RRT-Connect: trees from the start and from the goals grow towards each other (docs/planning_search.md).
        Joints with the same position at the start and the goal are held first, and move only if no path is found
        (``plan.moved``).

        Args:
            q_start: Where to start [rad or m], shape (n_dof,); or the name of a state of the SRDF, such as ``"arm/ready"``.
            goal: Where to go, in one of these forms. A configuration, shape (n_dof,), or alternatives, shape (n, n_dof). A pose
                T_base_link, shape (4, 4), or alternatives, shape (n, 4, 4), with all configurations that inverse kinematics
                finds. A pose for each of several links, as in ``{"left_hand": T_1, "right_hand": T_2}``, which all links reach
                together. Or the name of a state; joints that it does not name keep their positions.
            world: The obstacles; none unless given. The robot's links are checked against each other too.
            link: The link of the goal pose; the tip (of the group, if one is named) unless given. Joints that do not move it keep
                their positions, and so do joints that move several links of the goal.
            frame: The frame of a goal of poses, if not the base: a link that stands still, such as ``"base"`` of a UR, the frame
                of its pendant. Or the frame's pose T_base_frame, shape (4, 4), such as the pose of a work object.
            task: The components of the pose that count; see ``inverse_kinematics``.
            held: Names of joints that keep their positions.
            group: A group of the SRDF (``robot.groups``); joints outside it keep their positions. Configurations may then have
                the joints of the group alone, shape (k,) or (n, k), and states may be named without their group.
            keep: The constraints of the motion at all times, one ``Keep`` or several (docs/constraints.md). If a ``Keep`` holds a
                second link relative to the goal's link, as two hands on one object, both links get a goal pose.
            certify: Whether each edge is certified to be free at all its configurations, as by ``edge_in_collision``. Otherwise
                it is checked at samples 1/32 rad apart, and may touch something between them.
            clearance: The minimum distance from the objects of the world [m]; it does not apply between links of the robot.
            seed: Seed of the samples. The result is deterministic unless ``time_limit`` ends the search.
            max_checks: The maximum number of edges that the search checks: 100,000 unless given.
            shorten: Whether to shorten the path.
            escape: Whether a start that touches something by at most 10 mm may leave it by a first edge that is not checked.
                Likewise a start beyond the joint limits returns within them by a straight edge. That edge is certified to touch
                nothing, but may violate ``clearance`` and ``keep``.
            time_limit: The maximum time of the search [s], 10 s unless given; None for no limit. The first edges do not count,
                since kernels may be compiled during them. If the limit ends the search, the result depends on the machine.
            progress: Called about a hundred times a second during the search, with the number of checked edges and
                ``max_checks``; shortening may exceed ``max_checks``.

        Returns:
            A ``Plan``: path, status, and the reason if there is no path.

        Raises:
            InputError: An argument is invalid, such as a goal outside the joint limits; the message names it.
            UnknownNameError: There is no such link, joint, group or state.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.

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
        """The time-optimal trajectory along given configurations, within limits; see ``Plan.trajectory``.

        It passes the corners without stopping. Without a world nothing is checked for collisions, and ``certified`` is false.

        Args:
            q_path: Joint positions [rad or m], shape (n, n_dof), n >= 1, within the limits, joined by straight lines. Or a result
                of ``follow``. Or a ``Trajectory``, whose path gets a new time parameterization. Points within 1e-9 of the
                previous point are left out, and so are points on the line between two others.
            within: The largest distance of the motion from these lines in each joint [rad or m], above 0. A larger value allows
                a faster motion.
            velocity: Maximum velocity [rad/s or m/s], a number or n_dof numbers; from ``limits`` or the robot unless given.
            acceleration: Maximum acceleration [rad/s^2 or m/s^2]; required unless ``limits`` or the robot has it.
            jerk: Maximum jerk [rad/s^3 or m/s^3]; unless given from ``limits`` or the robot, if they have it.
            limits: The name of an arm, as "franka", a file ``joint_limits.yaml``, or its mapping.
            hand: Maximum speed and acceleration of the hand, or of several links, at all times: ``HandLimits``.
            torque: Maximum torque of each joint [Nm or N], as for ``Plan.trajectory``; True for the effort limits.
            world: The obstacles. The motion stops at a corner whose rounding is not certified to be free of them and of the
                robot itself. ``certified`` is true if the whole motion is certified.
            start_velocity: The velocity at the start [rad/s or m/s], shape (n_dof,), along the first line; the acceleration there
                is 0. At rest unless given.
            end_velocity: The velocity at the end, along the last line.

        Returns:
            A ``Trajectory``.

        Raises:
            InputError: q_path is not such an array, exceeds a limit, or is a followed path that did not reach its end. Or
                another argument is invalid, such as a velocity at an end that is not along the path or too large for it.
            UnknownNameError: There is no such set of limits.
            FileError: The file of limits cannot be read.
            DescriptionError: The file has no valid limits.
            GeometryError: A world is given, and there are shapes that cannot be checked.

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
        """Read a motion of this robot from a file; see ``Trajectory.from_file``.

        Args:
            path: A message of ROS or a plan of MoveIt (``.yaml``, ``.yml``, ``.json``), or a table with times (``.csv``).
            others: The configuration that gives joints the file does not name [rad or m], shape (n_dof,). Unless given, the file
                must name all joints.

        Raises:
            FileError, DescriptionError, InputError: See ``Trajectory.from_file``.
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
        """Plan many problems in several threads.

        Args:
            q_starts: Where to start [rad or m], shape (n, n_dof), or (n_dof,) for all; or names of states of the SRDF, or one
                name for all.
            goals: Where to go: configurations, shape (n, n_dof), or poses, shape (n, 4, 4), one per problem. Or poses of several
                links, shape (n, 4, 4) for each. Or names of states, or one name for all.
            world: One for all, or one for each problem.
            progress: Called after each problem with the numbers of finished problems and of all problems. True shows a bar on
                standard error, if that is a terminal.
            options: Options of ``plan``.

        Returns:
            A ``Plan`` for each problem, in order, bit for bit equal to the result of ``plan``.

        Raises:
            InputError: The numbers of starts, goals and worlds do not match. Or ``plan`` refuses a problem, whose number is in
                the message.
            UnknownNameError: There is no such link, joint or state; a note names the row.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
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
        """Make a servo, which steers the arm tick by tick and certifies each command with its braking trajectory (docs/servo.md).

        Args:
            world: The obstacles; none unless given. It may change between ticks.
            acceleration: Maximum acceleration of each joint [rad/s^2 or m/s^2], a number or shape (n_dof,), at most the
                robot's. Required unless the robot has a limit for every joint.
            rate: Ticks per second [Hz].
            link: The link of the target poses and twists, or several links, such as both hands. The tip (of the group, if one is
                named) unless given.
            weights: The weight of each link's squared error where several links cannot all reach their targets, 0.001 to 1000: a
                number or shape (n_links,); 1 unless given.
            held: Names of joints that keep their positions.
            group: A group of the SRDF (``robot.groups``): the joints outside keep their positions.
            velocity: Maximum velocity of each joint [rad/s or m/s], a number or shape (n_dof,), at most the description's.
            jerk: Maximum jerk of each joint [rad/s^3 or m/s^3], a number or shape (n_dof,). Unless given, the description's, if
                it has one. Accelerations that need more than 0.1 s to ramp up are not used.
            clearance: The minimum distance from objects [m]; it does not apply between links of the robot.
            tracking_error: The largest deviation of each joint from its command [rad or m]; the certificate covers it.
            posture: A configuration that the null space moves towards [rad or m], shape (n_dof,); none unless given.
            hand: Maximum speed and angular speed of the hand, or of several links, at all times; no limit unless given.
            torque: Maximum torque of each joint [Nm or N], a number or n_dof numbers; True for the effort limits of the
                description. The arm slows down where a tick or its braking trajectory needs more, as checked at samples.
            torque_rate: Maximum rate of change of a torque [Nm/s or N/s], a number or n_dof numbers; no limit unless given. It
                also limits the jerk, through the mass matrix. A Franka allows 1000 Nm/s.

        Raises:
            InputError: An argument is invalid; the message names it.
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
        self,
        q: ArrayLike | None = None,
        world: World | None = None,
        *,
        boxes: bool = False,
        size: tuple[int, int] | None = None,
        camera: str | ArrayLike | None = None,
    ) -> Recording:
        """Draw a picture of the robot without a display; a notebook shows it and stores it in its file.

        ``ulna.view(robot)`` opens an interactive page instead.

        Args:
            q: Joint positions [rad or m], shape (n_dof,); ``home`` unless given.
            world: The obstacles; obstacles that the robot touches are red.
            boxes: Show the robot's collision shapes, except meshes; shapes in contact are red.
            size: Width and height [pixels]; 720 and 480 unless given.
            camera: Where it is seen from: "corner", "front", "back", "left", "right" or "top"; or two angles [rad], about z
                from x and above the horizon.

        Returns:
            A ``Recording``; its ``save("arm.png")`` writes it.

        Raises:
            InputError: q, the world, the size or the camera is invalid.
            MissingExtraError: The extra ``viewer`` is not installed.
        """
        return drawer("robot")(self, q, world, boxes=boxes, size=size, camera=camera)

    @property
    def allowed_collisions(self) -> AllowedCollisions:
        """The pairs of links that may touch, each with its reason: found from joints and samples unless given."""
        return self._checker.allowed

    def collision_poses(self, q: ArrayLike, *, out: Array | None = None, **unknown: Never) -> Array:
        """The poses of the robot's collision shapes, in the order of ``collision_names``: shape (..., n_shapes, 4, 4).

        It takes the arguments of ``link_poses``.

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

    # ---- changed copies ------------------------------------------------------------------------------------------------

    def with_tool(
        self,
        T_flange_tool: ArrayLike,
        *,
        name: str = "tool",
        mass: float | None = None,
        com: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
    ) -> Robot:
        """A copy of the robot with a tool: a link fixed to the tip, which becomes the new tip.

        Args:
            T_flange_tool: The tool's pose in the frame of the tip, shape (4, 4).
            name: The new link's name.
            mass: The tool's mass [kg]; weightless unless given.
            com: The tool's center of mass in its frame [m], shape (3,); the origin unless given.
            inertia: The tool's inertia tensor about the center of mass, in the axes of its frame [kg m^2], shape (3, 3). Zero
                unless given: a point mass.

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
        """A copy of the robot with another direction of gravity, as if mounted on a wall or a ceiling.

        Torques, and motions limited by torque, use it.

        Args:
            gravity: The gravitational acceleration in the axes of the base [m/s^2], shape (3,).

        Raises:
            InputError: ``gravity`` is not three finite numbers.

        Example:
            >>> import ulna
            >>> hanging = ulna.load("panda").with_gravity((0, 0, 9.81))
            >>> hanging.gravity
            array([0.  , 0.  , 9.81])
        """
        return self._changed(gravity=gravity)

    def with_inertias(self, inertias: Mapping[str, Inertia | None]) -> Robot:
        """A copy of the robot with other inertias of some links, for descriptions with missing or wrong inertias.

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
        return self._changed(description=replace_inertias(self.description, inertias))

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
        """A copy of the robot with narrower limits, as in a work cell.

        Plans, trajectories, inverse kinematics, servos and maps stay within them. Each limit is a number for every joint, an
        array, shape (n_dof,), or a mapping from names of joints. A limit of a mimic joint narrows the limit of its leader. The
        allowed collisions do not change, and ``home`` is clipped to the limits.

        Args:
            limits: A file ``joint_limits.yaml`` or its mapping: its positions, velocities, accelerations and jerks.
            lower: Lower limits of position [rad or m].
            upper: Upper limits of position [rad or m].
            velocity: Maximum velocity [rad/s or m/s].
            acceleration: Maximum acceleration [rad/s^2 or m/s^2]. With a limit for every joint, ``trajectory`` and ``servo``
                need no ``acceleration``.
            jerk: Maximum jerk [rad/s^3 or m/s^3].

        Raises:
            InputError: A limit is wider than the robot's, is not a valid limit, or leaves a joint no range.
            UnknownNameError: There is no such joint.
            FileError: The file cannot be read.
            DescriptionError: The file has no valid limits.

        Example:
            >>> import ulna
            >>> panda = ulna.load("panda")
            >>> narrow = panda.with_limits(lower={"panda_joint1": -0.5}, upper={"panda_joint1": 0.5}, velocity=1.0)
            >>> float(narrow.upper[0]), float(narrow.velocity_limits.max())
            (0.5, 1.0)
        """
        given = {"lower": lower, "upper": upper, "velocity": velocity, "acceleration": acceleration, "jerk": jerk}
        return self._changed(_narrowed=narrow_limits(self.tree, limits, given))

    def with_allowed_collisions(
        self, pairs: Iterable = (), *, at: ArrayLike | str | None = None, touching: float | None = None
    ) -> Robot:
        """A copy of the robot with more allowed collisions: pairs of links that may touch.

        Args:
            pairs: Pairs of names, or the ``disabled_collisions`` of an SRDF, to add. Or an ``AllowedCollisions``, such as
                ``robot.allowed_collisions.minus(("a", "b"))``, which replaces all pairs.
            at: A configuration known to be free [rad or m], shape (n_dof,), or the name of a state of the SRDF. The pairs that
                touch there are added. Hulls are larger than the links, so some touch in every configuration.
            touching: A share above 0 and at most 1. The pairs that touched in at least this share of the random configurations
                are added. MoveIt's setup assistant uses 0.95.

        Raises:
            InputError: ``at`` is not one configuration, or ``touching`` is not such a share.
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
            more = *more, *self._checker.sampled_pairs.with_counts(self._checker.bodies).touching(touching)
        return self._changed(allowed=allowed.plus(*more) if more else allowed)

    def with_convex_hulls(self) -> Robot:
        """A copy of the robot with convex hulls in place of its collision meshes. Visuals are unchanged.

        Hulls are checked exactly. A hull contains its mesh, and is larger than a mesh with hollows: it may touch where the mesh
        would not. ``with_convex_pieces`` follows hollows. STL, OBJ and Collada files are read; ``ulna.load`` describes where
        they are searched. The time of a query grows with the number of vertices.

        Raises:
            FileError: A mesh does not exist, or cannot be read.
            MissingExtraError: The extra ``hulls`` is not installed.

        Example:
            >>> import ulna
            >>> ulna.load("ur5").with_convex_hulls().in_collision(np.zeros(6))  # pip install example-robot-data
            False
        """
        from ulna.description.meshes.hulls import with_hulls  # noqa: PLC0415 - needed for meshes alone

        return self._changed(description=with_hulls(self.description))

    def with_convex_pieces(self) -> Robot:
        """A copy of the robot with a convex decomposition of its collision meshes in their place. Visuals are unchanged.

        The pieces contain the mesh's whole surface, and exceed it by much less than the hull does. Each collision of
        ``robot.description.links`` has the sampled ``excess``. CoACD computes the pieces, with a fixed seed, in seconds to
        minutes per mesh file. They are cached on disk by the file's content. A query takes longer than with hulls.

        Raises:
            FileError: A mesh does not exist, cannot be read, or cannot be decomposed within the limits of time and memory.
            MissingExtraError: The extra ``decompose`` is not installed.
        """
        from ulna.description.meshes.decompose import with_pieces  # noqa: PLC0415 - needed for meshes alone

        return self._changed(description=with_pieces(self.description))

    def with_spheres(self, *, within: float = 0.01, most: int | None = None) -> Robot:
        """A copy of the robot with balls that cover its collision meshes, in their place.

        Other shapes and visuals are unchanged. The balls provably cover the mesh and its interior: every point of a triangle, and
        every point with a nonzero winding number. Holes in a surface count as closed, cavities as filled. Every point of a ball
        is at most ``within`` from the mesh or its interior, also proved; it is the ``excess`` of each such collision of
        ``robot.description.links``. So the balls of two links may touch while the links are up to twice ``within`` apart. The
        allowed collisions are computed from the balls, as they are from convex pieces; ``with_allowed_collisions(at=q)`` allows
        more.

        The computation takes seconds to minutes per mesh file, and is cached on disk by the file's content. The number of balls
        grows as ``within`` gets smaller, most along sharp edges. Boxes, cylinders, capsules and spheres of the description, and
        attached objects, stay as they are.

        Args:
            within: The largest distance of a point of a ball from the mesh and its interior [m], above 0.
            most: The maximum number of balls for each mesh; no maximum unless given.

        Raises:
            FileError: A mesh does not exist, or cannot be read.
            GeometryError: More than ``most`` balls are needed; the message names a ``within`` for which they suffice. Or
                ``within`` is too small for the size of a mesh.
            InputError: ``within`` is not such a distance, or ``most`` not a count.
            MissingExtraError: The extra ``hulls`` is not installed.

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
        """A copy of the robot with an attached object, which moves with a link.

        The object is checked for collisions like the robot's own shapes. With a mass or a density, the object's weight counts
        until ``without_attached``. The frame of the object is the frame of its shape, at ``T_link_object``. ``to_urdf`` writes
        neither its shape nor its mass.

        Args:
            name: The object's name in reports.
            shape: The object's shape.
            T_link_object: The object's pose in the frame of the link, shape (4, 4).
            link: The link that holds the object, and may touch it; the tip unless given.
            touch_links: Other links that may touch the object, such as fingers.
            mass: The object's mass [kg]; weightless unless this or a density is given.
            com: The center of mass in the object's frame [m], shape (3,). The centroid of the shape unless given; it is the
                origin except for a convex mesh.
            inertia: The inertia tensor about the center of mass, in the axes of the object's frame [kg m^2], shape (3, 3). Unless
                given, the tensor of the shape about its centroid, with uniform density.
            density: The object's density [kg/m^3], in place of mass, com and inertia; the mass is density times volume.

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
        """A copy of the robot without an attached object. ``world.add`` can put it into a world.

        Raises:
            UnknownNameError: There is no such attached object.
        """
        return self._changed(attached=detach(self.attached, name))

    # ---- construction and display --------------------------------------------------------------------------------------

    def _changed(self, **changes: Any) -> Robot:
        kept = {
            "description": self.description,
            "home": self.home,
            "attached": self.attached,
            "allowed": self._checker.user_pairs,
        }
        kept.update(_narrowed=self.tree.narrowed, gravity=self.gravity)
        if "description" not in changes:
            kept["_found"] = self._checker.sampled_pairs
        return Robot(**{**kept, **changes})

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Robot cannot be changed: {name} = {value!r}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a Robot cannot be changed: del {name}")

    def __reduce__(self):
        return _restore, (self.description, self.home, self.attached, self._checker.user_pairs, self.tree.narrowed, self.gravity)

    def __dir__(self) -> list[str]:
        return without_other_names(super().__dir__())

    def __repr__(self) -> str:
        return f"<Robot {self.name!r}: {self.n_dof} dof, {self.base} to {self.tip or f'{len(self.tree.leaves)} tips'}>"

    def _repr_html_(self) -> str:
        columns = (each.tolist() for each in (self.lower, self.upper, self.velocity_limits, self.home))
        rows = zip(entry_names(self.tree), *columns, strict=True)
        return table(repr(self)[1:-1], ("joint", "lower", "upper", "velocity", "home"), rows, ["in rad and s; m for slides"])


put_other_names(Robot)


def _check_home(tree: Tree, home: ArrayLike) -> Array:
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
