"""Makes arms with goals out of reach for servos, and judges how the arm stops at its limit of reach."""

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

import ulna
from robot_files import RTB
from two_arms import two_pandas

RATE = 1000
ACCELERATION = 10.0  # [rad/s^2]
DIRECTIONS = [np.array(d, float) / np.linalg.norm(d) for d in product((-1, 0, 1), repeat=3) if any(d)]
SLOW = 0.1  # [rad/s]
AT_END = 1e-3  # [rad]: a joint that is no farther from its end is there
CLEARANCE = 0.01  # [m]
RESERVE = 3e-3  # [m]: a pair that is no more than this farther apart than the clearance holds the arm
HELD, STUCK = 500, 1e-3  # ticks, [m]: a hand is held that came no farther than this along its line in so long
# x y z, roll pitch yaw of the joints' origins, published by Kinova for the Gen3 of seven joints; the greatest angle, the speed.
_GEN3 = [
    ((0, 0, 0.15643), (np.pi, 0, 0), None, 1.3963),
    ((0, 0.005375, -0.12838), (np.pi / 2, 0, 0), 2.41, 1.3963),
    ((0, -0.21038, -0.006375), (-np.pi / 2, 0, 0), None, 1.3963),
    ((0, 0.006375, -0.21038), (np.pi / 2, 0, 0), 2.66, 1.3963),
    ((0, -0.20843, -0.006375), (-np.pi / 2, 0, 0), None, 1.2218),
    ((0, 0.00017505, -0.10593), (np.pi / 2, 0, 0), 2.23, 1.2218),
    ((0, -0.10593, -0.00017505), (-np.pi / 2, 0, 0), None, 1.2218),
]


class Arm(NamedTuple):
    """A robot, where it starts, and the links that are steered."""

    robot: ulna.Robot
    start: np.ndarray
    links: tuple[str, ...]


def gen3():
    """A Kinova Gen3 of cylinders, by its published numbers."""
    foot = '<origin xyz="0 0 0.06"/><geometry><cylinder radius="0.045" length="0.12"/></geometry>'
    parts = f'<link name="link0"><collision>{foot}</collision></link>'
    places = [*(origin for origin, *_ in _GEN3[1:]), (0, 0, -0.061525)]
    for k, ((x, y, z), rpy, most, speed) in enumerate(_GEN3, start=1):
        end = np.array(places[k - 1], float)
        length = np.linalg.norm(end)
        turn = Rotation.align_vectors(end[None] / length, [[0, 0, 1]])[0].as_euler("xyz")
        parts += f'<link name="link{k}"><collision><origin xyz="{_text(end / 2)}" rpy="{_text(turn)}"/><geometry>'
        parts += f'<cylinder radius="0.035" length="{length - 0.02}"/></geometry></collision></link>'
        kind, ends = ("continuous", "") if most is None else ("revolute", f'lower="{-most}" upper="{most}"')
        limit = f'<limit {ends} velocity="{speed}" effort="1"/>'
        parts += f'<joint name="joint{k}" type="{kind}"><parent link="link{k - 1}"/><child link="link{k}"/>'
        parts += f'<origin xyz="{x} {y} {z}" rpy="{_text(rpy)}"/><axis xyz="0 0 1"/>{limit}</joint>'
    parts += '<link name="tool"/><joint name="flange" type="fixed"><parent link="link7"/><child link="tool"/>'
    return ulna.load(f'<robot name="gen3">{parts}<origin xyz="0 0 -0.061525" rpy="{np.pi} 0 0"/></joint></robot>')


def _text(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def iiwa14():
    folder = RTB / "xacro" / "kuka_description"
    text = (folder / "kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf").read_text(encoding="utf-8")
    text = text.replace("package://kuka_lbr_iiwa_support", "package://kuka_lbr_iiwa")
    return ulna.load(text, base="base_link", tip="tool0", package_dirs=[folder]).with_convex_hulls()


def arm(name):
    """An arm from a start at which the least singular value of its Jacobian is at least 0.1."""
    if name == "two hands":
        panda = ulna.load("panda")
        robot = ulna.load(two_pandas(panda, waist=True))
        return Arm(robot, np.concatenate([[0.0], panda.home, panda.home]), ("left_ee", "right_ee"))
    if name == "panda":
        robot = ulna.load(name)
        return Arm(robot, robot.home, ("panda_ee",))
    if name == "fr3":
        robot = ulna.load(name, meshes="hulls")
        return Arm(robot, robot.home, (robot.tip,))
    if name in {"ur5", "ur10"}:
        return Arm(ulna.load(name, meshes="hulls", tip="tool0"), np.array([0.0, -1.2, 1.5, -1.8, -1.5, 0.0]), ("tool0",))
    if name == "iiwa14":
        return Arm(iiwa14(), np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0]), ("tool0",))
    return Arm(gen3(), np.array([0.0, 0.26, np.pi, -2.27, 0.0, 0.96, np.pi / 2]), ("tool",))


ARMS = ("panda", "fr3", "ur5", "ur10", "iiwa14", "gen3", "two hands")


class Run(NamedTuple):
    """The record of a servo: joint positions and velocities, the hands' poses, and the status and the limit of each tick."""

    q: np.ndarray
    qd: np.ndarray
    hands: np.ndarray
    statuses: list
    limiting: list


def held(arm, seconds, **goal):
    """The commands of a servo that is held at a goal."""
    robot = arm.robot
    options = goal.pop("options", {})
    servo = robot.servo(acceleration=ACCELERATION, rate=RATE, link=arm.links if len(arm.links) > 1 else arm.links[0], **options)
    servo.start(arm.start)
    n = int(seconds * RATE)
    commands = [servo.step(**goal) for _ in range(n)]
    q = np.array([c.q for c in commands])
    hands = np.array([robot.forward_kinematics(q, link=link)[:, :3, 3] for link in arm.links])
    return Run(q, np.array([c.qd for c in commands]), hands, [c.status for c in commands], [c.limiting for c in commands])


def reversals(qd):
    """The number of times that each joint reverses, above SLOW both before and after."""
    return [int(np.count_nonzero(np.diff(np.sign(v[np.abs(v) > SLOW])))) for v in qd.T]


def share_possible(arm, q, twist, *, ends=True, body=True):
    """The greatest share of a twist of every hand that the joint velocities allow at q, ends of joints and own body in mind."""
    robot = arm.robot
    n = robot.n_dof
    J = np.vstack([robot.jacobian(q, link=link) for link in arm.links])
    V = np.tile(twist, len(arm.links))
    limits = robot.velocity_limits
    low = np.where(ends & (q - robot.lower < AT_END), 0.0, -limits)
    high = np.where(ends & (robot.upper - q < AT_END), 0.0, limits)
    rows = {}
    near = robot.distances(q, within=CLEARANCE + RESERVE).gradient if body else np.empty((0, n))
    if len(near):
        rows = {"A_ub": np.c_[-near, np.zeros(len(near))], "b_ub": np.zeros(len(near))}
    found = linprog(np.r_[np.zeros(n), -1.0], A_eq=np.c_[J, -V], b_eq=np.zeros(len(V)), **rows, method="highs",
                    bounds=[*zip(low, high, strict=True), (0, 1)])  # fmt: skip
    return float(found.x[-1]) if found.status == 0 else 0.0


def farthest(arm, direction, link, *, step=2e-3, most=3.0):
    """The distance that a hand gets along a line without turning, by small damped least-squares steps, collision-free [m]."""
    robot, q = arm.robot, arm.start.copy()
    T = robot.forward_kinematics(q, link=link)
    reached = 0.0
    while reached < most:
        goal = T[:3, 3] + (reached + step) * direction
        for _ in range(60):
            here = robot.forward_kinematics(q, link=link)
            e = np.r_[goal - here[:3, 3], Rotation.from_matrix(T[:3, :3] @ here[:3, :3].T).as_rotvec()]
            if np.abs(e).max() < 2e-4:
                break
            J = robot.jacobian(q, link=link)
            free = np.ones(robot.n_dof, bool)
            for _ in range(3):
                Jf = J * free
                change = Jf.T @ np.linalg.solve(Jf @ Jf.T + 1e-6 * np.eye(6), e)
                out = ((q + change > robot.upper) & (change > 0)) | ((q + change < robot.lower) & (change < 0))
                free &= ~out
            q = np.clip(q + np.clip(change, -0.1, 0.1), robot.lower, robot.upper)
        else:
            return reached
        reached += step
    return reached


class Found(NamedTuple):
    """The findings of the judge for a twist that is held."""

    last: float
    """The last moment at which half of the twist was possible [s]."""
    reversals: int
    """The most of any joint after it."""
    rest: float
    """Time after which all joints stay slow [s]."""
    off: float
    """Largest distance of the hand from its line until then [m]."""
    along: float
    """Distance that it came along the line [m]."""
    unnamed: float
    """Time for which the hand, held by an end or its body, still moved or had a status that did not name it [s]."""
    singular: bool
    """Whether the status was near a singularity where it was well conditioned."""
    final: str


def judge_twist(arm, run, twist, every=100):
    """The findings of the judge, who asks the linear program every so many ticks."""
    n, v = len(run.q), twist[:3]
    looks = range(0, n, every)
    share = np.array([share_possible(arm, run.q[k], twist) for k in looks])
    last = int(np.flatnonzero(share >= 0.5).max(initial=0)) * every
    after = run.qd[last:]
    fast = np.flatnonzero(np.abs(after).max(axis=1) > SLOW)
    moved = run.hands - run.hands[:, :1]
    unit = v / np.linalg.norm(v)
    along = moved @ unit
    off = np.linalg.norm(moved - along[..., None] * unit, axis=-1)
    speed, unnamed = np.linalg.norm(v), 0
    for k, possible in zip(looks, share, strict=True):
        is_stuck = k >= HELD and (along[:, k] - along[:, k - HELD]).min() < STUCK
        if possible < 0.5 and is_stuck and share_possible(arm, run.q[k], twist, ends=False, body=False) >= 0.5:
            named = run.statuses[k] in {"limited by position", "limited by clearance"}
            unnamed += np.abs(run.qd[k]).max() > SLOW or not named
    jacobians = [np.vstack([arm.robot.jacobian(run.q[k], link=link) for link in arm.links]) for k in looks]
    well = [k for k, J in zip(looks, jacobians, strict=True) if np.linalg.svd(J, compute_uv=False)[-1] >= 0.1]
    return Found(
        last / RATE, max(reversals(after)), (fast.max() + 1) / RATE if len(fast) else 0.0, float(off[:, : last + 1].max()),
        float(along[:, -1].min()), unnamed * every / RATE, any(run.statuses[k] == "near a singularity" for k in well),
        f"{run.statuses[-1]} {run.limiting[-1].joint or run.limiting[-1].pair or ''} at {speed:g}, off {off.max():.3f}",
    )  # fmt: skip


class FoundOfPose(NamedTuple):
    """The findings of the judge for a pose out of reach, from the nearest approach on."""

    nearest: float
    """The moment of it [s]."""
    reversals: int
    rest: float
    """Time after which all joints stay slow [s]."""
    miss: float
    """The pose error where it ends, m and rad in one."""


def judge_pose(arm, direction, beyond, seconds):
    """Send each hand beyond the farthest place along a line [m]."""
    goal = {}
    for link in arm.links:
        goal[link] = arm.robot.forward_kinematics(arm.start, link=link).copy()
        goal[link][:3, 3] += DIRECTIONS[direction] * (farthest(arm, DIRECTIONS[direction], link) + beyond)
    run = held(arm, seconds, pose=goal if len(arm.links) > 1 else goal[arm.links[0]])
    miss = np.zeros(len(run.q))
    for link, T in goal.items():
        T_base_hand = arm.robot.forward_kinematics(run.q, link=link)
        turn = Rotation.from_matrix(T[:3, :3] @ np.swapaxes(T_base_hand[:, :3, :3], 1, 2)).magnitude()
        miss += ((T_base_hand[:, :3, 3] - T[:3, 3]) ** 2).sum(axis=1) + turn**2
    miss = np.sqrt(miss)
    nearest = int(np.flatnonzero(miss <= miss.min() + 1e-3)[0])  # near it as good as rests
    after = run.qd[nearest:]
    fast = np.flatnonzero(np.abs(after).max(axis=1) > SLOW)
    return FoundOfPose(nearest / RATE, max(reversals(after)), (fast.max() + 1) / RATE if len(fast) else 0.0, float(miss[-1]))
