"""An arm for each simulator, what is around it, and its description."""

import pytest

import ulna
from simulators import ADDRESS, simulator
from ulna.arms import Franka


@pytest.fixture(scope="session")
def fr3():
    return ulna.load("fr3")


@pytest.fixture(scope="session")
def world():
    """Boxes around the arm, which leave its start free."""
    world = ulna.World()
    for k, (x, y, z) in enumerate(((0.6, 0.35, 0.3), (0.6, -0.4, 0.5), (-0.3, 0.5, 0.4), (0.0, -0.6, 0.3), (0.75, 0.0, 0.1))):
        world.add(f"box {k}", ulna.Box((0.15, 0.15, 0.5 if k < 4 else 0.2)), ulna.pose((x, y, z)))
    world.add("table", ulna.Box((2.0, 2.0, 0.02)), ulna.pose((0.0, 0.0, -0.02)))
    return world


@pytest.fixture(scope="module", params=["franka-sim", "franky-sim"])
def arm(request, fr3, tmp_path_factory):
    with simulator(request.param, tmp_path_factory.mktemp("simulator")), Franka(ADDRESS, robot=fr3) as arm:
        arm.simulator = request.param
        yield arm
