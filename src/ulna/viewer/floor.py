"""Adds a floor under the robot as an obstacle, and removes it."""

from collections.abc import Callable

import numpy as np
import viser

from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import HalfSpace, Mesh
from ulna.robot import Robot
from ulna.viewer.visuals import triangles

NAME = "floor"
_BELOW = 1e-3  # [m] below the lowest point of the fixed links, so that they do not touch it


class Floor:
    """A checkbox. ``moved`` is called when the floor was added or removed."""

    def __init__(self, gui: viser.GuiApi, world: World, height: float, moved: Callable[[], None]) -> None:
        self._world, self._height, self._moved = world, height, moved
        self.on = gui.add_checkbox("Floor", initial_value=NAME in world.names, hint=f"An obstacle: all below z = {height:.3f} m")
        self.on.on_update(self._set)

    def show(self) -> None:
        """Set the checkbox: the floor may have been deleted like any obstacle."""
        self.on.value = NAME in self._world.names

    async def _set(self, event: viser.GuiEvent) -> None:
        if event.client is None:
            return
        if self.on.value and NAME not in self._world.names:
            self._world.add(NAME, HalfSpace(), pose((0.0, 0.0, self._height)))
        elif not self.on.value and NAME in self._world.names:
            self._world.remove(NAME)
        self._moved()


def floor_height(robot: Robot, drawn: float) -> float:
    """The height of a floor [m] that the fixed links do not touch: at most ``drawn``, the height of the drawn one [m]."""
    places = dict(zip(robot.link_names, robot.link_poses(robot.home), strict=True))
    lowest = [drawn]
    for link in robot.description.links:
        for body in link.collisions if robot.tree.link_row[link.name] < 0 else ():
            if not isinstance(body.shape, Mesh | HalfSpace):
                T = places[link.name] @ body.pose
                lowest.append(float((triangles(body.shape).vertices @ T[2, :3] + T[2, 3]).min()) - _BELOW)
    return float(np.min(lowest))
