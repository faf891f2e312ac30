"""An arm for each simulator, what is around it, and its description."""

import os
from pathlib import Path

import numpy as np
import pytest
from benchmarks.vamp_problems import read_problems

import ulna
from simulators import ADDRESS, simulator
from ulna.arms import Franka

VAMP = os.environ.get("FRANKA_SCENES")  # the folder resources/panda of VAMP; boxes of our own without it
OFF = 0.05  # [rad]: within this of a limit the arm, which rests beside its command, may be beyond it
EVERY = 4  # of VAMP's problems, so that a hundred are of every kind
FLOOR = ulna.Box((4.0, 4.0, 0.02)), ulna.pose((0.0, 0.0, -0.01))  # franka-sim has one, which holds an arm that is sent through it


@pytest.fixture(scope="session")
def fr3():
    return ulna.load("fr3")


@pytest.fixture(scope="session")
def world():
    """Boxes around the arm, which leave its start free."""
    world = ulna.World()
    for k, (x, y, z) in enumerate(((0.6, 0.35, 0.3), (0.6, -0.4, 0.5), (-0.3, 0.5, 0.4), (0.0, -0.6, 0.3), (0.75, 0.0, 0.1))):
        world.add(f"box {k}", ulna.Box((0.15, 0.15, 0.5 if k < 4 else 0.2)), ulna.pose((x, y, z)))
    return with_floor(world)


@pytest.fixture(scope="session")
def floor():
    """The floor alone."""
    return with_floor(ulna.World())


def with_floor(world):
    """The world, with the floor on which the base stands."""
    world.add("floor", *FLOOR, touch_links=("fr3_link0",))
    return world


@pytest.fixture(scope="session")
def problems(fr3, world):
    """A function of problems without end: a start, or None for where the arm is, a goal, and a world in which both are free."""

    def among_boxes():
        rng = np.random.default_rng(36)
        while True:
            goal = rng.uniform(fr3.lower, fr3.upper) * 0.9 + fr3.home * 0.1
            if not fr3.in_collision(goal, world):
                yield None, goal, world

    def of_vamp():
        given = read_problems(Path(VAMP), tuple(f"panda_joint{k}" for k in range(1, 8)))
        for each in [each for first in range(EVERY) for each in given[first::EVERY]]:
            ends, scene = np.stack([each.start, each.goal]), each.world()
            pairs = [pair for q in ends for pair in fr3.check_collision(q, scene).pairs]
            for name in {pair.name_b for pair in pairs if pair.name_a == "fingers"}:
                scene.remove(name)  # what the hand takes: the box of the FR3's fingers holds them at every opening
            with_floor(scene)
            inside = (ends > fr3.lower + OFF).all() and (ends < fr3.upper - OFF).all()
            if inside and not fr3.in_collision(ends, scene).any():
                yield each.start, each.goal, scene

    return of_vamp if VAMP else among_boxes


@pytest.fixture(scope="module", params=["franka-sim", "franky-sim"])
def arm(request, fr3, tmp_path_factory):
    with simulator(request.param, tmp_path_factory.mktemp("simulator")), Franka(ADDRESS, robot=fr3) as arm:
        arm.simulator = request.param
        yield arm
