"""Writes a motion that was planned on a page as a program, as shell commands, and as files."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.pose import rpy_from_matrix
from ulna.description.shapes import KINDS, HalfSpace
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot
from ulna.viewer.session.waypoints import ASIDE, TILT, Leg, MotionSettings, rates_of

PERIOD = 0.01  # [s] between two rows of a file
_SCENE = "scene.json"
_DIGITS = 12
_PLAIN = {kind.shape: tuple(kind.sizes) for kind in KINDS} | {HalfSpace: ()}
Array = NDArray[np.float64]


def motion_file(motion: Trajectory, ending: str) -> bytes:
    """The content of a file, ``"csv"`` or ``"json"``, from which ``robot.motion_from_file`` reads a motion."""
    with TemporaryDirectory(prefix="ulna-") as folder:
        path = Path(folder, f"motion.{ending}")
        (motion.to_csv if ending == "csv" else motion.to_json)(path, period=PERIOD)
        return path.read_bytes()


def name_of(robot: Robot) -> str:
    """The name or path with which ``ulna.load`` loads a robot."""
    description = robot.description
    return Path(description.source).stem if description.folder is None else str(Path(description.folder, description.source))


def as_program(robot: Robot, changes: Iterable[str], world: World, legs: Sequence[Leg], settings: MotionSettings) -> str:
    """A Python program that makes a motion of legs and writes it to a file.

    changes: lines that change the robot as the page did.
    """
    velocity, acceleration = rates_of(robot)
    rates = f"acceleration={_rates(acceleration)}"
    if not np.array_equal(velocity, robot.velocity_limits):
        rates = f"velocity={_rates(velocity)}, {rates}"
    if settings.jerk is not None:
        rates += f", jerk={settings.jerk!r}"
    lines = ["import ulna", "", _robot_line(robot), *changes, *_world_lines(world)]
    for k, leg in enumerate(legs):
        goal = _numbers(leg.goal) if leg.goal.ndim == 1 else _pose(leg.goal)
        options = [f"link={settings.link!r}"] if leg.goal.ndim == 2 else []
        keeps = [f"ulna.Keep.upright({TILT!r}, link={settings.link!r})"] if settings.upright else []
        if leg.line is not None:
            ends = ", ".join(map(_numbers, leg.line))
            keeps.append(f"ulna.Keep.on_line({ends}, within={ASIDE!r}, link={settings.link!r})")
        options += [f"held={list(settings.held)!r}"] if settings.held else []
        options += [f"keep=[{', '.join(keeps)}]"] if keeps else []
        start = _numbers(leg.start) if k == 0 else "motion.q[-1]"
        lines.append(f"plan = robot.plan({', '.join([start, goal, 'world', *options])})")
        motion = f"plan.trajectory({rates})"
        lines.append(f"motion = motion.then({motion})" if k else f"motion = {motion}")
    lines += ["print(plan, motion, sep='\\n')", f"motion.to_csv('motion.csv', period={PERIOD!r})"]
    return "\n".join(lines) + "\n"


def as_commands(robot: Robot, world: World, legs: Sequence[Leg], settings: MotionSettings) -> str:
    """Shell commands that make a motion: one for each leg, which writes its own file."""
    around = ["--scene", _SCENE] if world.names else []
    acceleration = rates_of(robot)[1]
    lines = [f"# {_SCENE}: Save scene, in the tab Obstacles"] if world.names else []
    for k, leg in enumerate(legs, start=1):
        words = ["ulna", "plan", name_of(robot), "--from", _csv(leg.start)]
        if leg.goal.ndim == 1:
            words += ["--to", _csv(leg.goal)]
        else:
            words += ["--xyz", _csv(leg.goal[:3, 3]), "--rpy", _csv(rpy_from_matrix(leg.goal)), "--link", settings.link]
        words += [word for joint in settings.held for word in ("--held", joint)]
        words += ["--keep", f"{settings.link}:upright={TILT!r}rad"] if settings.upright else []
        if leg.line is not None:
            words += ["--keep", f"{settings.link}:line={_csv(leg.line.ravel())},{ASIDE!r}m"]
        words += [*around, "--acceleration", repr(float(acceleration.min()))]
        words += [] if settings.jerk is None else ["--jerk", repr(settings.jerk)]
        lines.append(shlex.join([*words, "--csv", "motion.csv" if len(legs) == 1 else f"motion{k}.csv"]))
    return "\n".join(lines) + "\n"


def _robot_line(robot: Robot) -> str:
    """The line that loads the robot, without the changes that a program made before it showed the robot."""
    if not robot.description.text or not Path(robot.description.source).suffix:
        return "robot = ...  # the robot of the page, which cannot be loaded by a name or from one file"
    return f"robot = ulna.load({name_of(robot)!r})  # add the arguments, tools and attached objects of the page's robot"


def _world_lines(world: World) -> list[str]:
    """The lines that make a world, or load the page's scene file if it has more than plain shapes."""
    items = list(world.items())
    if any(type(shape) not in _PLAIN or world.touch_links(name) or world.speed(name) for name, shape, _ in items):
        return [f"world = ulna.load_world({_SCENE!r})  # Save scene, in the tab Obstacles"]
    lines = ["world = ulna.World()"]
    for name, shape, T in items:
        sizes = ", ".join(_numbers(getattr(shape, size)) for size in _PLAIN[type(shape)])
        lines.append(f"world.add({name!r}, ulna.{type(shape).__name__}({sizes}), {_pose(T)})")
    return lines


def _pose(T: Array) -> str:
    return f"ulna.pose({_numbers(T[:3, 3])}, {_numbers(rpy_from_matrix(T))})"


def _rates(values: Array) -> str:
    """The limits of all joints: one number if they are equal."""
    return _numbers(values[0] if len(values) and (values == values[0]).all() else values)


def _numbers(values: ArrayLike) -> str:
    """One number, or several in brackets."""
    return repr(_rounded(values).tolist())


def _rounded(values: ArrayLike) -> Array:
    """Numbers rounded to twelve digits, with -0 as 0."""
    return np.asarray(values, dtype=np.float64).round(_DIGITS) + 0.0


def _csv(values: Array) -> str:
    return ", ".join(map(repr, _rounded(values).tolist()))
