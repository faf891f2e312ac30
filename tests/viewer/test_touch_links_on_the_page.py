"""The links that may touch an obstacle stay with it as the page renames, loads and saves it; without a browser."""

import numpy as np
import pytest

import ulna
from ulna.viewer.obstacles import Obstacles
from ulna.viewer.page import Page


@pytest.fixture
def obstacles():
    page, world = Page(port=0), ulna.World()
    world.add("floor", ulna.HalfSpace(), touch_links=["panda_link1"])
    yield Obstacles(page.server, world, np.zeros(3), 1.0, lambda: None)
    page.stop()


def test_a_renamed_obstacle_keeps_its_links(obstacles):
    obstacles.change("floor", ulna.HalfSpace(), np.eye(4), "ground")
    assert obstacles.world.touch_links("ground") == {"panda_link1"}


def test_a_scene_that_is_loaded_brings_its_links(obstacles):
    other = ulna.World()
    other.add("table", ulna.Box((1, 1, 0.1)), touch_links=["panda_hand"])
    obstacles.replace(other)
    assert obstacles.world.names == ("table",)
    assert obstacles.world.touch_links("table") == {"panda_hand"}
