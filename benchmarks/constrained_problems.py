"""Makes problems of constrained motions, by a published seed, in the scenes of VAMP's planning problems.

Start and goal are random collision-free configurations within the limits, with the hand projected onto the constraint. A random
problem need not have a solution.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import ulna
from benchmarks.peer import bare_urdf
from benchmarks.plan_judges import samples_of
from benchmarks.vamp_problems import PlanningProblem

Array = NDArray[np.float64]
SEED = 20261126
KINDS = ("upright", "orientation", "plane", "line", "box")
TRAY = "tray"  # the kind of a robot with two hands
HANDS = {"panda": "panda_hand", "ur5": "tool0", "baxter": "left_gripper"}
OTHER_HAND = "right_gripper"
TILT, TURN, PLANE, LINE, BESIDE = float(np.radians(15)), float(np.radians(0.1)), 1e-4, 1e-3, 0.1  # [rad], [rad], [m], [m], [m]
TOGETHER = 1e-4, 1e-3  # [m], [rad]
NEAREST, FARTHEST, HALF_A_TRAY = (0.4, -0.25, -0.1, -0.4), (0.85, 0.25, 0.6, 0.4), 0.2  # x, y, z [m] and yaw of a tray; [m]
UP_OF_A_HAND = (0.0, 1.0, 0.0)  # in the axes of the first hand at a tray
_DRAWS = 400  # draws of a start and a goal before another scene is drawn


@dataclass(frozen=True)
class ConstrainedProblem:
    """A start, a goal, a scene, and the constraint of the motion.

    Attributes:
        kind: One of KINDS, or TRAY.
        scene: The problem whose objects are used.
        start, goal: Shape (n_dof,); the goal of a tray is the pose of one hand, shape (4, 4).
        link: The hand.
        T: The reference pose of the hand, shape (4, 4).
        away: The maximum displacement along its axes [m], shape (3,); infinite along free axes.
        keep: The same for Ulna.
        held: The pose T_hand_other, shape (4, 4), of OTHER_HAND, if the motion keeps it too.
    """

    kind: str
    scene: PlanningProblem
    start: Array
    goal: Array
    link: str
    T: Array
    away: tuple[float, float, float]
    keep: ulna.Keep | tuple[ulna.Keep, ...]
    held: Array | None = None

    @property
    def goal_link(self) -> str | None:
        """The link of a goal that is a pose."""
        return None if self.held is None else self.link


def kinds_of(name: str) -> tuple[str, ...]:
    """The kinds of problems of a robot."""
    return (TRAY,) if name == "baxter" else KINDS


def make_problem(robot: ulna.Robot, link: str, scenes: list[PlanningProblem], kind: str, index: int) -> ConstrainedProblem:
    """Problem ``index`` of a kind."""
    rng = np.random.default_rng([SEED, (*KINDS, TRAY).index(kind), index])
    while True:
        scene = scenes[int(rng.integers(len(scenes)))]
        world = scene.world()
        for _ in range(_DRAWS):
            drawn = _tray(robot, link, scene, rng) if kind == TRAY else _drawn(robot, link, scene, kind, rng)
            if drawn is not None and not robot.in_collision(drawn[1], world).any():
                return drawn[0]


def excess(problem: ConstrainedProblem, robot: ulna.Robot, path: Array, finer: float) -> float:
    """The largest share of a tolerance that a path's samples use, by Pinocchio's kinematics.

    finer: samples per radian.
    """
    model = pin.buildModelFromXML(bare_urdf(robot))
    data, frame, other = model.createData(), model.getFrameId(problem.link), model.getFrameId(OTHER_HAND)
    columns = [(joint.idx_q, robot.joint_slices[robot.joint_names.index(name)].start, joint.nq)
               for joint, name in zip(list(model.joints)[1:], model.names[1:], strict=True)]  # fmt: skip
    own, worst = np.empty(model.nq), 0.0
    for q in samples_of(path, finer):
        for at, k, width in columns:
            own[at : at + width] = (np.cos(q[k]), np.sin(q[k])) if width == 2 else q[k]
        pin.framesForwardKinematics(model, data, own)
        worst = max(worst, share_of(problem, data.oMf[frame].homogeneous))
        if problem.held is not None:
            worst = max(worst, share_of_hands(problem.held, data.oMf[frame].homogeneous, data.oMf[other].homogeneous))
    return worst


def share_of_hands(held: Array, T: Array, T_other: Array) -> float:
    """The share of TOGETHER that the poses of two hands use."""
    off = np.linalg.inv(held) @ np.linalg.inv(T) @ T_other
    return float(max(np.abs(off[:3, 3]).max() / TOGETHER[0], np.linalg.norm(pin.log3(off[:3, :3])) / TOGETHER[1]))


def share_of(problem: ConstrainedProblem, T: Array) -> float:
    """The share of the tolerance that a pose of the hand uses."""
    R = problem.T[:3, :3]
    share = float((np.abs(R.T @ (T[:3, 3] - problem.T[:3, 3])) / problem.away).max())
    if problem.kind in {"upright", TRAY}:
        up = T[:3, 2] if problem.held is None else T[:3, :3] @ UP_OF_A_HAND
        return max(share, float(np.arctan2(np.linalg.norm(np.cross(R[:, 2], up)), R[:, 2] @ up)) / TILT)
    if problem.kind == "orientation":
        return max(share, float(np.linalg.norm(pin.log3(R.T @ T[:3, :3]))) / TURN)
    return share


def _tray(
    robot: ulna.Robot, link: str, scene: PlanningProblem, rng: np.random.Generator
) -> tuple[ConstrainedProblem, list[Array]] | None:
    """A problem of two hands at a tray's ends, with facing fingers, and its ends; None out of reach."""
    ends = []
    for x, y, z, yaw in rng.uniform(NEAREST, FARTHEST, (2, 4)):
        hands = [ulna.pose((x, y, z), rpy=(0, 0, yaw)) @ ulna.pose((0, side * HALF_A_TRAY, 0), rpy=(side * np.pi / 2, 0, 0))
                 for side in (1, -1)]  # fmt: skip
        q = rng.uniform(robot.lower, robot.upper)
        for T, hand in zip(hands, (link, OTHER_HAND), strict=True):
            if q is not None:
                q = _at(robot, hand, T, q, "pose")
        if q is None:
            return None
        ends.append((q, hands))
    (start, hands), (goal, hands_there) = ends
    held = np.linalg.inv(hands[0]) @ hands[1]
    keeps = (ulna.Keep.together(link, OTHER_HAND, T=held, within=TOGETHER),
             ulna.Keep.upright(TILT, axis=UP_OF_A_HAND, link=link))  # fmt: skip
    problem = ConstrainedProblem(TRAY, scene, start, hands_there[0], link, np.eye(4), (np.inf,) * 3, keeps, held)
    return problem, [start, goal]


def _drawn(
    robot: ulna.Robot, link: str, scene: PlanningProblem, kind: str, rng: np.random.Generator
) -> tuple[ConstrainedProblem, list[Array]] | None:
    """A problem and its ends; None if the hand cannot be projected onto the constraint."""
    free, inf = (np.inf,) * 3, np.inf
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    q_a, q_b = rng.uniform(low, high, (2, robot.n_dof))
    p_a, p_b = (robot.forward_kinematics(q, link=link)[:3, 3] for q in (q_a, q_b))
    if kind in {"upright", "orientation"}:
        turns = rng.uniform(-np.pi, np.pi, 2) if kind == "upright" else np.full(2, rng.uniform(-np.pi, np.pi))
        poses = [ulna.pose(p, rpy=(np.pi, 0, turn)) for p, turn in zip((p_a, p_b), turns, strict=True)]
        ends = [_at(robot, link, pose, q, "pose") for pose, q in zip(poses, (q_a, q_b), strict=True)]
        T = ulna.pose(rpy=(np.pi, 0, turns[0]))
        keep = ulna.Keep.orientation(TURN, T=T, link=link) if kind == "orientation" else ulna.Keep.upright(
            TILT, axis=(0, 0, 1), along=(0, 0, -1), link=link)  # fmt: skip
        return _problem(kind, scene, ends, link, T, free, keep)
    if kind == "box":
        T, extents = ulna.pose(0.5 * (p_a + p_b)), np.abs(p_b - p_a) + 2 * BESIDE
        return _problem(kind, scene, [q_a, q_b], link, T, tuple(extents / 2), ulna.Keep.inside(extents, T, link=link))
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    axes *= np.sign(np.linalg.det(axes))
    if kind == "line":
        axes = ulna.Task.pointing(p_b - p_a).frame[:3, :3]
        side, keep = LINE / np.sqrt(2), ulna.Keep.on_line(p_a, p_b, within=LINE, link=link)
        return _problem(kind, scene, [q_a, q_b], link, _pose(p_a, axes), (side, side, inf), keep)
    T = _pose(p_a, axes)
    q_b = _at(robot, link, ulna.pose(p_b - axes[:, 2] * (axes[:, 2] @ (p_b - p_a))), q_b, "position")
    return _problem(kind, scene, [q_a, q_b], link, T, (inf, inf, PLANE), ulna.Keep.in_plane(T, within=PLANE, link=link))


def _problem(kind, scene, ends, link, T, away, keep) -> tuple[ConstrainedProblem, list[Array]] | None:
    return None if any(q is None for q in ends) else (ConstrainedProblem(kind, scene, *ends, link, T, away, keep), ends)


def _at(robot: ulna.Robot, link: str, T: Array, near: Array, task: str) -> Array | None:
    found = robot.inverse_kinematics(T, near, link=link, task=task)
    return found.q if found else None


def _pose(p: Array, axes: Array) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = axes, p
    return T
