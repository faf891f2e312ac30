"""The page keeps an obstacle's touch_links when it renames or loads it; without a browser."""

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


def test_a_renamed_obstacle_keeps_its_touch_links(obstacles):
    obstacles.change("floor", ulna.HalfSpace(), np.eye(4), "ground")
    assert obstacles.world.touch_links("ground") == {"panda_link1"}


def test_a_loaded_scene_has_its_touch_links(obstacles):
    other = ulna.World()
    other.add("table", ulna.Box((1, 1, 0.1)), touch_links=["panda_hand"])
    obstacles.replace(other)
    assert obstacles.world.names == ("table",)
    assert obstacles.world.touch_links("table") == {"panda_hand"}
