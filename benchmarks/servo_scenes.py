"""Makes arms, scenes and hostile goals for servos, each from a seed."""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ulna
from ulna.bench.arms import ARMS, load_arm, longest_reach

Array = NDArray[np.float64]
RATE = 1000  # [1/s]
ACCELERATION = 10.0  # [rad/s^2], of every joint
CLEARANCE = 0.01  # [m]
AIMS_FOR, STATED_EVERY = 50, 33  # ticks
SPEED = 0.3  # [m/s], of the moving ball
SPARE = 0.02  # [m], minimum distance of an arm's start from everything
HELD_FOR = (13, 97, 997)  # ticks for which a goal is held
KINDS = ("jump", "through", "spin", "noise", "inside", "q", "velocity", "twist", "rest")
POSES = KINDS[:5]
KINDS_OF_SCENES = "shapes", "cloud", "moving"
_EASE = 0.5  # [s], until a path of ``paced`` reaches its speed
_SWING = 0.4  # [rad], of that path, to each side
TWO_ARMS_APART = 0.6  # [m]
CLOUD, BALL = (300, 0.015), 0.06  # points and their radius [m]; the radius of the moving ball [m]
_SIGMA = 0.1  # [m], the minimum singular value of the Jacobian along it


def arm(name: str) -> ulna.Robot:
    """An arm with the shapes of its description: boxes for the Panda, convex hulls of meshes for others."""
    if name == "panda":
        return ulna.load(name)
    if name == "two_pandas":
        return two_arms()
    if name != "iiwa14":
        return load_arm(name).with_convex_hulls()
    _, base, tip = ARMS[name]  # the package of its meshes is called otherwise than in its text
    folder = next(Path(entry, "rtbdata/xacro/kuka_description") for entry in sys.path if Path(entry, "rtbdata").is_dir())
    text = (folder / "kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf").read_text(encoding="utf-8")
    text = text.replace("package://kuka_lbr_iiwa_support", "package://kuka_lbr_iiwa")
    return ulna.load(text, base=base, tip=tip, package_dirs=[folder]).with_convex_hulls()


def two_arms() -> ulna.Robot:
    """Two Pandas side by side as one robot of 14 joints."""
    text = ulna.load("panda").to_urdf()
    text = text[text.index("<link") : text.index("</robot>")]
    parts = '<robot name="two arms"><link name="table"/>'
    for side, y in (("left", TWO_ARMS_APART / 2), ("right", -TWO_ARMS_APART / 2)):
        mount = f'<parent link="table"/><child link="{side}_link0"/><origin xyz="0 {y} 0"/>'
        parts += text.replace('"panda_', f'"{side}_') + f'<joint name="{side}_mount" type="fixed">{mount}</joint>'
    return ulna.load(parts + "</robot>")


def hand_of(robot: ulna.Robot) -> str:
    """The steered link: the tip, or the last one of a robot of several arms."""
    return robot.tip or robot.link_names[-1]


def start_of(robot: ulna.Robot, world: ulna.World | None = None) -> Array:
    """The start of the arm: home, or a configuration far enough from itself and the world, shape (n_dof,)."""
    candidates = np.concatenate([[robot.home], robot.random(1000, seed=0)])
    far = robot.signed_distance(candidates, world) > SPARE
    return candidates[np.argmax(far)]


def scene(robot: ulna.Robot, n: int, seed: int, kind: str = "shapes") -> ulna.World:
    """Boxes, balls and cylinders around an arm, a third each, none nearer to its start than SPARE.

    The kind ``cloud`` has a cloud with points in five cubes of 0.3 m; the kind ``moving`` has a ball with a stated speed.
    """
    rng, start, reach = np.random.default_rng(seed), start_of(robot), 0.7 * longest_reach(robot, hand_of(robot))
    world = ulna.World()
    while len(world.names) < n:
        k = len(world.names)
        place = ulna.pose(rng.uniform((-reach, -reach, 0.0), reach), rng.uniform(-3, 3, 3))
        small, size = rng.uniform(0.03, 0.12), rng.uniform(0.05, 0.3, 3)
        shape = (ulna.Box(size), ulna.Sphere(small), ulna.Cylinder(small, size[2] + 0.2))[k % 3]
        world.add(f"{type(shape).__name__.lower()} {k}", shape, place)
        if robot.signed_distance(start, world) < SPARE:
            world.remove(world.names[-1])
    if kind == "cloud":
        middles = rng.uniform((-reach, -reach, 0.0), reach, (5, 1, 3))
        points = (middles + 0.15 * rng.uniform(-1, 1, (5, CLOUD[0] // 5, 3))).reshape(-1, 3)
        points = [p for p in points if _is_far(robot, start, ulna.Sphere(CLOUD[1]), p)]
        world.add("cloud", ulna.PointCloud(points, CLOUD[1]))
    if kind == "moving":
        place = np.array([reach, 0.0, 0.6])
        while not _is_far(robot, start, ulna.Sphere(BALL), place):
            place[0] += 0.05
        world.add("ball", ulna.Sphere(BALL), ulna.pose(place), speed=SPEED)
    return world


def _is_far(robot: ulna.Robot, q: Array, shape: ulna.Sphere, place: Array) -> bool:
    alone = ulna.World()
    alone.add("one", shape, ulna.pose(place))
    return robot.signed_distance(q, alone, self_collision=False) > SPARE


class Chaser:
    """The ball of a ``moving`` scene: it chases the arm at its speed, and hits it unless it rests.

    From time to time the world gets its position. ``places`` are the positions at the ends of ticks, from the start on.
    """

    def __init__(self, robot: ulna.Robot, world: ulna.World, seed: int) -> None:
        self._robot, self._world, self._rng = robot, world, np.random.default_rng(seed)
        self.places, self._towards = [world.pose("ball")[:3, 3]], np.zeros(3)

    def move(self, q: Array, *, rests: bool) -> None:
        """Move for one tick, next to an arm at q."""
        k, at = len(self.places), self.places[-1]
        if k % AIMS_FOR == 1:
            aim = self._rng.normal(size=3)
            if self._rng.random() < 0.7:
                aim = self._robot.forward_kinematics(q, link=str(self._rng.choice(self._robot.link_names[3:])))[:3, 3] - at
            self._towards = SPEED * aim / max(np.linalg.norm(aim), 1e-9)
        there = at + self._towards / RATE
        if rests and not _is_far(self._robot, q, ulna.Sphere(BALL), there):
            there, self._towards = at, np.zeros(3)
        self.places.append(there)
        if k % STATED_EVERY == 0:
            self._world.move("ball", ulna.pose(there))


def hostile(robot: ulna.Robot, n: int, seed: int, kinds: tuple[str, ...] = KINDS) -> Iterator[dict]:
    """The goals of n ticks, as arguments of ``Servo.step``.

    Poses that jump, pass through everything at up to 3 m/s, spin at 20 rad/s, are noise, or lie in the arm's own base;
    configurations, maximum velocities, twists, and none.
    """
    rng, k = np.random.default_rng(seed), 0
    while k < n:
        ticks = min(int(rng.choice(HELD_FOR)), n - k)
        k += ticks
        far = robot.random(2, seed=int(rng.integers(2**31)))
        yield from _held(robot, rng, str(rng.choice(kinds)), far, ticks)


def _held(robot: ulna.Robot, rng: np.random.Generator, kind: str, far: Array, ticks: int) -> Iterator[dict]:
    T_a, T_b = robot.forward_kinematics(far, link=hand_of(robot))
    inside = ulna.pose(rng.uniform((-0.15, -0.15, 0.0), (0.15, 0.15, 0.3)), rng.uniform(-3, 3, 3))
    way, axis = T_b[:3, 3] - T_a[:3, 3], rng.normal(size=3)
    velocity = rng.choice([-1.0, 1.0], robot.n_dof) * rng.choice([0.5, 100.0])
    twist = rng.normal(size=6) * rng.choice([0.3, 3.0])
    frame = str(rng.choice(["base", "link", "spatial"]))
    for t in np.arange(ticks) / RATE:
        match kind:
            case "jump":
                yield {"pose": T_b}
            case "through":
                share = 0.5 - 0.5 * np.cos(2 * np.pi * t / max(np.linalg.norm(way), 0.1))
                yield {"pose": ulna.pose(share * way) @ T_a}
            case "spin":
                yield {"pose": T_a @ ulna.pose(rpy=20 * t * axis / np.linalg.norm(axis))}
            case "noise":
                yield {"pose": T_a @ ulna.pose(0.05 * rng.normal(size=3), 0.3 * rng.normal(size=3))}
            case "inside":
                yield {"pose": inside}
            case "q":
                yield {"q": far[1]}
            case "velocity":
                yield {"velocity": velocity + rng.normal(size=robot.n_dof)}
            case "twist":
                yield {"twist": twist, "expressed_in": frame}
            case _:
                yield {}


def paced(robot: ulna.Robot, ticks: int, seed: int) -> Array:
    """A smooth joint path from rest, away from limits, singularities and self-collision, shape (ticks, n_dof).

    Its speeds are at most a radian per second, and its accelerations at most a fifth of the allowed ones.
    """
    seconds = np.arange(ticks) / RATE
    eased = np.where(seconds < _EASE, seconds**3 / _EASE**2 * (1 - 0.5 * seconds / _EASE), seconds - 0.5 * _EASE)
    rng = np.random.default_rng(seed)
    for middle in np.concatenate([[robot.home], robot.random(1000, seed=seed)]):
        turns, phases = rng.uniform(0.5, 2.0, robot.n_dof), rng.uniform(0, 2 * np.pi, robot.n_dof)
        q = middle + _SWING * np.sin(turns * eased[:, None] + phases)
        sampled = q[::20]
        sigma = np.linalg.svd(robot.jacobian(sampled), compute_uv=False)[:, -1]
        within = ((q > robot.lower + _SWING) & (q < robot.upper - _SWING)).all()
        if within and sigma.min() > _SIGMA and robot.signed_distance(sampled).min() > SPARE:
            return q
    raise AssertionError("no path keeps away from all that")
