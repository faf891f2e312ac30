"""Draws the pictures, and the films, of the pages.

    .venv/bin/python docs/pictures/draw.py            # all; or the names of some

It needs the extras ``viewer``, ``meshes`` and ``reach``, and Matplotlib (group ``docs``). The scenes are those of the pages'
first examples.
"""

import runpy
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import ulna

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.depth_camera import Camera as DepthCamera

from ulna.description.names.by_name import known_robots
from ulna.kernels.servo.braking import write_velocity_box
from ulna.reachability.plot import draw
from ulna.servo.entries.tick import APPROACH_TIME, RESERVE
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.film import Film, write_film
from ulna.viewer.film.painter import Ground, Painter, Picture
from ulna.viewer.film.skin import Model
from ulna.viewer.palette import GREEN, INK, MOVABLE, RED, Solid, collision_solids

Pixels = NDArray[np.uint8]
SIZE, SIZE_OF_FILM = (960, 540), (640, 360)
GAP = 4  # pixels of white between the parts of a picture
NOTHING = """<robot name="nothing"><link name="{}">
  <visual><origin xyz="0 0 -1"/><geometry><box size="0.001 0.001 0.001"/></geometry></visual></link></robot>"""
MIN = 6  # of 255, by which a pixel differs from the background
FAINT = 0.35  # the part of an earlier configuration in a picture of several
AXES = ((210, 40, 40), (40, 150, 60), (50, 90, 220))  # x red, y green, z blue


class Scene:
    """A robot, what is drawn around it, and a camera."""

    def __init__(
        self, robot: ulna.Robot, eye: tuple[float, float, float], middle: tuple[float, float, float], size: tuple[int, int]
    ) -> None:
        self.robot, self.size, self.middle = robot, size, middle
        self.camera = Camera(eye, middle, fov=0.6)
        self.solids: list[Solid] = []

    def put(
        self, shape: ulna.Box | ulna.Cylinder | ulna.PointCloud, T: NDArray, color: tuple[int, int, int], opacity: float = 1.0
    ) -> None:
        """Add a shape at T_base_shape."""
        self.solids.append(Solid(f"solid {len(self.solids)}", self.robot.base, T, shape, color, opacity))

    def put_world(self, world: ulna.World, touching: Sequence[str] = (), opacity: float = 1.0) -> None:
        """Add the obstacles of a world."""
        for name, shape, T in world.items():
            self.put(shape, T, RED if name in touching else MOVABLE, opacity)

    def put_line(self, a: NDArray, b: NDArray, color: tuple[int, int, int], radius: float = 0.004) -> None:
        """Add a straight line from a point to another [m]."""
        along = (b - a) / np.linalg.norm(b - a)
        across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
        across /= np.linalg.norm(across)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = np.column_stack([across, np.cross(along, across), along]), (a + b) / 2
        self.put(ulna.Cylinder(radius=radius, length=float(np.linalg.norm(b - a))), T, color)

    def put_frame(self, T: NDArray, length: float = 0.12) -> None:
        """Add the axes of a pose."""
        for axis, color in enumerate(AXES):
            self.put_line(T[:3, 3], T[:3, 3] + length * T[:3, axis], color, 0.005)

    def put_way(self, q: NDArray, color: tuple[int, int, int]) -> None:
        """Add the way of the hand through rows of q."""
        places = self.robot.forward_kinematics(q)[:, :3, 3]
        for a, b in pairwise(places):
            if np.linalg.norm(b - a) > 0.0:
                self.put_line(a, b, color)

    def paint(self, q: NDArray) -> Pixels:
        """The robot at q, shape (n_dof,)."""
        return self._pictures(self.robot, q[None])[0]

    def paint_several(self, q: NDArray) -> Pixels:
        """The robot at the last row of q, and faintly at the others."""
        nothing = ulna.load(NOTHING.format(self.robot.base))
        background = self._pictures(nothing, np.empty((1, 0)))[0].astype(float)
        result = background
        for share, picture in zip([FAINT] * (len(q) - 1) + [1.0], self._pictures(self.robot, q), strict=True):
            differs = np.abs(picture - background).max(axis=2, keepdims=True) > MIN
            result = np.where(differs, share * picture + (1 - share) * result, result)
        return result.round().astype(np.uint8)

    def _pictures(self, robot: ulna.Robot, q: NDArray) -> list[Pixels]:
        """A robot with the base of this one, at each row of q."""
        solids = tuple(self.solids)
        painter = Painter(Model(robot), self.size, Ground(self.middle, 1.6), samples=4)
        return [painter.paint(Picture(row, self.camera, solids)) for row in q]


def part_of(size: tuple[int, int], columns: int, rows: int = 1) -> tuple[int, int]:
    """The size of each of several parts of a picture, with gaps between them."""
    return (size[0] - (columns - 1) * GAP) // columns, (size[1] - (rows - 1) * GAP) // rows


def beside(parts: Sequence[Pixels], size: tuple[int, int], columns: int) -> Pixels:
    """Parts of one size in rows, with a letter in each: (a), (b) and so on."""
    sheet, font = Image.new("RGB", size, (255, 255, 255)), max(6, size[1] / 27)
    height, width, _ = parts[0].shape
    for number, part in enumerate(parts):
        tile = Image.fromarray(part)
        ImageDraw.Draw(tile).text((0.6 * font, 0.5 * font), f"({chr(ord('a') + number)})", fill=INK, font_size=font)
        sheet.paste(tile, (number % columns * (width + GAP), number // columns * (height + GAP)))
    return np.asarray(sheet)


def planning(size: tuple[int, int]) -> Pixels:
    """The Panda goes round a post and under a shelf."""
    robot, world = ulna.load("panda"), ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    world.add("shelf", ulna.Box((0.5, 2, 0.05)), ulna.pose((0.6, 0, 0.95)))
    left, right = robot.home.copy(), robot.home.copy()
    left[0], right[0] = 1, -1
    plan = robot.plan(left, right, world).improve(3000)
    scene = Scene(robot, (-1.7, -1.1, 1.5), (0.25, 0.0, 0.55), size)
    scene.put_world(world, opacity=0.45)
    scene.put_way(plan.at(np.linspace(0, 1, 80)), GREEN)
    return scene.paint_several(plan.at(np.linspace(0, 1, 7)))


def following(size: tuple[int, int]) -> Pixels:
    """The Panda's hand goes along a straight line."""
    robot = ulna.load("panda")
    T_path = np.repeat(robot.forward_kinematics(robot.home)[None], 60, axis=0)
    T_path[:, :3, 3] = [0.45, 0.0, 0.5]
    T_path[:, 1, 3] = np.linspace(-0.3, 0.4, 60)
    path = robot.follow(T_path)
    scene = Scene(robot, (1.8, -0.9, 0.8), (0.2, 0.05, 0.42), size)
    scene.put_way(path.q, GREEN)
    for T in T_path[::10]:
        scene.put_frame(T, 0.06)
    return scene.paint_several(path.q[[0, 10, 20, 30, 40, 50, 59]])


def collision(size: tuple[int, int]) -> Pixels:
    """The Panda at a distance from a crate, and touching it."""
    robot = ulna.load("panda")
    halves = []
    for place in ((0.5, 0.0, 0.21), (0.4, 0.0, 0.45)):
        world = ulna.World()
        world.add("crate", ulna.Box(extents=(0.15, 0.09, 0.126)), ulna.pose(xyz=place))
        report = robot.check_collision(robot.home, world, max_distance=0.5)
        touching = [pair for pair in report.pairs if pair.link_b is None and pair.signed_distance <= 0]
        scene = Scene(robot, (1.55, -1.05, 0.8), (0.15, 0.0, 0.4), part_of(size, 2))
        scene.put_world(world, [pair.name_b for pair in touching])
        scene.solids += collision_solids(robot, [pair.name_a for pair in touching])
        nearest = next(pair for pair in report.pairs if pair.link_b is None)
        if not touching:
            scene.put_line(nearest.witness_a, nearest.witness_b, INK)
        halves.append(scene.paint(robot.home))
    return beside(halves, size, 2)


def inverse_kinematics(size: tuple[int, int]) -> Pixels:
    """The eight configurations in which a UR5 reaches one pose."""
    robot = ulna.load("ur5", tip="tool0")
    T = robot.forward_kinematics([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])
    found = robot.all_solutions(T)
    tiles = []
    for q in found.q[found.valid][:8]:
        scene = Scene(robot, (1.2, -1.35, 0.9), (0.22, 0.1, 0.28), part_of(size, 4, 2))
        scene.put_frame(T, 0.15)
        tiles.append(scene.paint(q))
    return beside(tiles, size, 4)


def arms(size: tuple[int, int], columns: int = 8, rows: int = 3) -> Pixels:
    """Every arm that is bundled, at its home, with its name; each as large as fits."""
    width, height = size[0] // columns, size[1] // rows
    names = [robot.name for robot in known_robots() if robot.package == "bundled"]
    sheet = Image.new("RGB", (columns * width, rows * height), (255, 255, 255))
    for number, name in enumerate(names):
        robot = ulna.load(name)
        places = robot.link_poses(robot.home)[:, :3, 3]
        middle, extent = (places.min(axis=0) + places.max(axis=0)) / 2, float(np.linalg.norm(np.ptp(places, axis=0)))
        eye = middle + extent * np.array([1.35, -1.85, 0.7])
        scene = Scene(robot, tuple(eye.tolist()), tuple(middle.tolist()), (width, height))
        tile = Image.fromarray(scene.paint(robot.home))
        ImageDraw.Draw(tile).text((width / 2, 0.93 * height), name, fill=INK, anchor="mm", font_size=max(6, height / 14))
        sheet.paste(tile, (number % columns * width, number // columns * height))
    return np.asarray(sheet)


def camera_sees(size: tuple[int, int]) -> Pixels:
    """What a depth camera sees of a bin and the Panda, with the Panda's own points red; and what is thinned, and not seen."""
    robot, T = ulna.load("panda"), ulna.pose((0.6, 0, 0.15))
    q = robot.home.copy()
    q[0] = 0.4
    boxes = [(np.array(extents) / 2, ulna.pose(place)) for extents, place in BIN]
    own = [body.shape for link in robot.description.links for body in link.collisions]
    boxes += [(np.array(shape.half_extents), pose) for shape, pose in zip(own, robot.collision_poses(q), strict=True)]
    image = CAMERA.image(boxes)
    cloud = CAMERA.cloud(image, 0.004).cropped(ulna.Box((1.7, 1.4, 2)), ulna.pose((0, 0, 0.985)))
    rest = cloud.without(robot, q, padding=0.02)
    owned = cloud.points[robot.links_near(cloud, q, within=0.02)[1] >= 0]
    hidden = ulna.VoxelGrid.unseen(image, CAMERA.intrinsics, CAMERA.pose, ulna.Box((0.44, 0.8, 0.3)), 0.02, pose=T)
    scenes = [Scene(robot, (-0.5, -1.75, 1.1), (0.35, 0.0, 0.28), part_of(size, 2)) for _ in range(2)]
    scenes[0].put(rest, np.eye(4), MOVABLE)
    scenes[0].put(ulna.PointCloud(owned, 0.006), np.eye(4), RED)
    scenes[1].put(rest.thinned(0.02), np.eye(4), MOVABLE)
    for middle, half in zip(*hidden.without(robot, q, padding=0.02, pose=T).boxes, strict=True):
        scenes[1].put(ulna.Box(2 * half), T @ ulna.pose(middle), SHADE)
    return beside([scene.paint(q) for scene in scenes], size, 2)


def camera_into_bin(size: tuple[int, int]) -> Pixels:
    """The first motion of the example of the same name, among the points that the plan knew."""
    example = _example("13_camera_into_bin.py")
    motion, robot = example["motions"][0], example["robot"]
    q = motion.at(np.linspace(0, motion.duration, 100)).q
    scene = Scene(robot, (1.5, -1.1, 1.0), (0.4, 0.0, 0.25), size)
    scene.put(example["clouds"][0], np.eye(4), MOVABLE)
    scene.put_way(q, GREEN)
    return scene.paint_several(q[[0, 40, 60, 99]])


def loop(size: tuple[int, int], rate: int = 10) -> Film:
    """A box is dragged into the way of the Panda, whose motion is planned anew meanwhile, and then played; and so back."""
    robot, world, pictures = ulna.load("panda"), ulna.World(), []
    camera, box = Camera((1.75, 0.35, 0.95), (0.12, 0.0, 0.42), fov=0.5), ulna.Box((0.14, 0.14, 0.62))
    world.add("box", box, ulna.pose((0.45, -0.75, 0.31)))
    down = (np.pi, 0.0, 0.0)
    ends = [robot.inverse_kinematics(ulna.pose((0.42, y, 0.4), down), robot.home).q for y in (0.42, -0.42)]
    track = np.array([(0.45, -0.75), (0.45, 0.02), (0.45, -0.75)])
    shown = Scene(robot, camera.position, camera.look_at, size)

    def add(q: NDArray, plan: ulna.Plan) -> None:
        shown.solids.clear()
        shown.put_way(plan.at(np.linspace(0, 1, 40)), GREEN)
        shown.put_world(world, () if not robot.in_collision(q, world) else ("box",))
        pictures.append(Picture(q, camera, tuple(shown.solids)))

    for k, (start, goal) in enumerate((ends, ends[::-1])):
        plan = robot.plan(start, goal, world)
        for share in np.linspace(0.0, 1.0, round(1.7 * rate)):
            eased = share * share * (3.0 - 2.0 * share)
            x, y = (1.0 - eased) * track[k] + eased * track[k + 1]
            world.move("box", ulna.pose((x, y, 0.31)))
            plan = robot.plan(start, goal, world, clearance=0.02) or plan
            add(start, plan)
        motion = plan.improve(2000).trajectory(acceleration=3.0)
        for t in np.linspace(0.0, motion.duration, round(2.3 * rate)):
            add(motion.at(t).q, plan)
    return Film(Model(robot), pictures, size, rate, Ground((0.2, 0.0, 0.35), 1.5), samples=2)


def camera_into_bin_film(size: tuple[int, int], rate: int = 10) -> Film:
    """The motions of the same example at half their speed, each among the points of the image that it was planned in."""
    example = _example("13_camera_into_bin.py")
    robot, motions, pictures = example["robot"], example["motions"], []
    camera = Camera((1.65, -1.25, 1.15), (0.38, 0.0, 0.33), fov=0.6)
    for cloud, motion in zip(example["clouds"], motions, strict=True):
        seen = (Solid("seen", robot.base, np.eye(4), cloud, MOVABLE),)
        end = motion.duration if motion is motions[-1] else example["SHARE"] * motion.duration
        pictures += [Picture(motion.at(t).q, camera, seen) for t in np.arange(0, end, 0.5 / rate)]
    rest = [pictures[-1]] * rate
    return Film(Model(robot), [*pictures, *rest], size, rate, Ground((0.4, 0.0, 0.25), 1.6), samples=3)


def _example(name: str) -> dict:
    return runpy.run_path(str(Path(__file__).parents[2] / "examples" / name))


def tray(size: tuple[int, int]) -> Pixels:
    """Two arms carry a tray over a wall, as in the example of the same name; the lines are the ways of the hands."""
    example = _example("14_tray.py")
    robot, q = example["loaded"], example["samples"]
    scene = Scene(robot, (2.0, -1.3, 1.1), (0.35, 0.0, 0.3), size)
    for name, shape, T in example["world"].items():
        if name == "wall":
            scene.put(shape, T, MOVABLE, 0.6)
    for held in robot.attached:
        scene.solids.append(Solid(held.name, held.link, held.T_link_object, held.shape, SHADE if held.name == "tray" else RED))
    for hand in ("left_ee", "right_ee"):
        for a, b in pairwise(robot.forward_kinematics(q[::25], link=hand)[:, :3, 3]):
            scene.put_line(a, b, GREEN)
    return scene.paint(q[np.argmax(robot.forward_kinematics(q, link="left_ee")[:, 2, 3])])


class ServoMoment:
    """One tick of a servo of two bars that move towards a post and a limit; of 20 ms, so that all rows are seen.

    rows: what a velocity x has to keep, g x >= b: its name, g and b.
    """

    q, qd, desired = np.array([0.25, 0.62]), np.array([0.5, 0.3]), np.array([0.63, 0.54])
    tick, acceleration, speed, clearance = 0.02, 10.0, 0.64, 0.02
    lengths, width, post, upper = (
        (0.6, 0.5),
        0.04,
        (0.706, 0.607, 0.14),
        0.645,
    )  # [m]; the post's place and side; [rad], of the elbow

    def __init__(self) -> None:
        links = joints = ""
        for k, (parent, name) in enumerate((("base", "upper"), ("upper", "lower"))):
            solid = f'<geometry><box size="{self.lengths[k]} {self.width} {self.width}"/></geometry>'
            links += f'<link name="{name}"><collision><origin xyz="{self.lengths[k] / 2} 0 0"/>{solid}</collision></link>'
            ends = f'<parent link="{parent}"/><child link="{name}"/><origin xyz="{k * self.lengths[0]} 0 0"/><axis xyz="0 0 1"/>'
            limit = f'<limit lower="-3" upper="{(3.0, self.upper)[k]}" velocity="{self.speed}" effort="1"/>'
            joints += f'<joint name="joint {k + 1}" type="revolute">{ends}{limit}</joint>'
        self.robot, self.world = ulna.load(f'<robot name="bars"><link name="base"/>{links}{joints}</robot>'), ulna.World()
        self.world.add("post", ulna.Box((self.post[2], self.post[2], 0.2)), ulna.pose((*self.post[:2], 0)))
        servo = self.robot.servo(self.world, rate=1 / self.tick, acceleration=self.acceleration, clearance=self.clearance)
        servo.start(self.q, self.qd)
        box, change = np.empty(4), self.acceleration * self.tick
        now, limits, settings = servo._now, servo._limits, servo._settings[0]  # noqa: SLF001
        self.ticks = write_velocity_box(now.joints, now.counters[0], limits, settings, box)
        of_stop = np.ceil(np.abs(self.qd).max() / change)  # ticks
        self.stop, certified = self.qd * (1 - 1 / of_stop), self.q + self.qd * self.tick * of_stop / 2
        g = self.robot.distance_gradient(certified, self.world, self_collision=False)
        excess = float(self.robot.signed_distance(certified, self.world, self_collision=False)) - self.clearance
        nearer = -self.tick / (self.tick + APPROACH_TIME) * max(excess - RESERVE, 0.0)
        one = np.eye(2)
        rest = self.q + self.tick * self.qd / 2
        self.rows = [("acceleration", -one[j], -self.qd[j] - change) for j in (0, 1)]
        self.rows += [("acceleration", one[j], self.qd[j] - change) for j in (0, 1)]
        self.rows += [("speed", -one[0], -self.speed), ("position", -one[1], (rest[1] - self.upper) / self.way)]
        self.rows += [("post", g, (nearer + g @ (certified - rest)) / self.way)]
        self.box, self.command = box, servo.step(velocity=self.desired)

    @property
    def way(self) -> float:
        """How far a velocity at the end of the tick moves a joint until it rests [s]."""
        return 0.5 * self.tick * (1 + self.ticks)

    def rest(self, x: NDArray) -> NDArray:
        """Where the arm rests after a tick that ends with x, shape (..., 2)."""
        return self.q + self.tick * self.qd / 2 + self.way * x


def servo_rows(size: tuple[int, int]) -> Pixels:
    """Draw the constraints of a servo's quadratic program in one tick of a two-joint arm, and its solution."""
    moment, scale = ServoMoment(), size[0] / SIZE[0]
    figure = Figure(figsize=(9.6, 5.4), dpi=100 * scale, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=(0.8, 1.0))
    _draw_bars(left, moment)
    _draw_rows(right, moment)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def reachability(size: tuple[int, int]) -> Pixels:
    """The figure of the Panda's map; a small one is of fewer voxels."""
    with TemporaryDirectory() as folder:
        voxel = 0.05 if size[0] >= SIZE[0] else 0.2
        found = ulna.reachability_map(ulna.load("panda"), Path(folder) / "panda.zarr", voxel=voxel, orientations=48)
        figure = draw(found)
    figure.set_size_inches(12, 12 * size[1] / size[0])
    figure.set_dpi(size[0] / 12)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _draw_bars(axes: Axes, moment: ServoMoment) -> None:
    """Draw the arm now, and where it would come to rest."""
    x, y, side = moment.post
    axes.add_patch(Rectangle((x - side / 2, y - side / 2), side, side, color="0.6"))
    allowed = np.clip(moment.desired, moment.box[:2], moment.box[2:])
    for q, color, label in (
        (moment.q, "black", "now"),
        (moment.rest(allowed), "tab:red", "at rest, without the post's constraint"),
        (moment.rest(moment.command.qd), "tab:green", "at rest after a tick with x"),
    ):
        elbow = moment.lengths[0] * np.array([np.cos(q[0]), np.sin(q[0])])
        hand = elbow + moment.lengths[1] * np.array([np.cos(q.sum()), np.sin(q.sum())])
        axes.plot(*np.array([(0, 0), elbow, hand]).T, "-o", color=color, linewidth=4, markersize=4, alpha=0.8, label=label)
    axes.set(aspect="equal", xlim=(0.5, 1.0), ylim=(0.1, 0.75), xlabel="x [m]", ylabel="y [m]", title="the arm and a post")
    axes.legend(loc="lower right", fontsize=8)


def _draw_rows(axes: Axes, moment: ServoMoment) -> None:
    """Draw the plane of velocities at the end of the tick: constraints, desired velocity and solution."""
    low, high = (0.2, -0.1), (0.8, 0.6)
    u, v = np.meshgrid(np.linspace(low[0], high[0], 301), np.linspace(low[1], high[1], 351))
    plane = np.stack([u, v], axis=-1)
    for name, g, b in moment.rows:
        axes.contourf(u, v, plane @ g - b, levels=[-9, 0], colors=[ROWS[name][0]], alpha=0.28)
        axes.contour(u, v, plane @ g - b, levels=[0], colors=[ROWS[name][0]], linewidths=1.5)
    for radius in np.linalg.norm(moment.command.qd - moment.desired) * np.array([0.5, 1.0]):
        axes.add_patch(Circle(moment.desired, radius, fill=False, color="0.4", linewidth=0.8, linestyle="--"))
    for color, text in ROWS.values():
        axes.plot([], [], color=color, linewidth=6, alpha=0.5, label=text)
    axes.plot(*moment.desired, "x", color="tab:red", markersize=9, markeredgewidth=2, label="desired")
    axes.plot(*moment.stop, "s", color="black", label="current braking trajectory")
    axes.plot(*moment.command.qd, "o", color="tab:green", markersize=9, label="x: nearest that satisfies all constraints")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), title="velocities at the end of the tick")
    axes.set(xlabel="joint 1 [rad/s]", ylabel="joint 2 [rad/s]")
    axes.legend(loc="lower right", fontsize=7)


ROWS = {  # of the quadratic program: color and label of each constraint
    "acceleration": ("tab:blue", "limit of acceleration"),
    "speed": ("tab:purple", "limit of velocity, joint 1"),
    "position": ("tab:orange", "limit of position, joint 2"),
    "post": ("tab:brown", "near pair: arm and post"),
}
SHADE = 150, 155, 165
BIN = [  # extents and place [m]: the floor, the table, the bin's walls, two parts
    ((9, 9, 0.02), (0, 0, -0.04)),
    ((0.7, 1.0, 0.02), (0.6, 0, -0.01)),
    ((0.02, 0.4, 0.15), (0.45, 0, 0.075)),
    ((0.02, 0.4, 0.15), (0.75, 0, 0.075)),
    ((0.3, 0.02, 0.15), (0.6, -0.2, 0.075)),
    ((0.3, 0.02, 0.15), (0.6, 0.2, 0.075)),
    ((0.06, 0.08, 0.06), (0.55, 0.05, 0.03)),
    ((0.08, 0.05, 0.1), (0.66, -0.08, 0.05)),
]
CAMERA = DepthCamera(160, 120, (150, 150, 79.5, 59.5), ulna.pose((1.35, -0.3, 1.1), (-2.35, 0.0, 1.2)))


PICTURES: dict[str, Callable[[tuple[int, int]], Pixels]] = {
    "planning": planning,
    "following": following,
    "collision": collision,
    "inverse_kinematics": inverse_kinematics,
    "arms": arms,
    "camera_sees": camera_sees,
    "camera_into_bin": camera_into_bin,
    "tray": tray,
    "servo_rows": servo_rows,
    "reachability": reachability,
}

FEW_COLORS = {"arms": 96, "reachability": 256}  # a third of the bytes

FILMS: dict[str, Callable[[tuple[int, int]], Film]] = {"camera_into_bin_film": camera_into_bin_film, "loop": loop}
SIZES_OF_PICTURES, SIZES_OF_FILMS = {"reachability": (1440, 840)}, {"loop": (760, 300)}

if __name__ == "__main__":
    for name in sys.argv[1:] or (*PICTURES, *FILMS):
        if name in FILMS:
            write_film(Path(__file__).with_name(f"{name}.gif"), FILMS[name](SIZES_OF_FILMS.get(name, SIZE_OF_FILM)))
        else:
            picture = Image.fromarray(PICTURES[name](SIZES_OF_PICTURES.get(name, SIZE)))
            if name in FEW_COLORS:
                picture = picture.quantize(FEW_COLORS[name], dither=Image.Dither.NONE)
            picture.save(Path(__file__).with_name(f"{name}.png"), optimize=True)
