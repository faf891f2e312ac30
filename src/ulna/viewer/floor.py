"""Puts a floor under the robot as an obstacle, and takes it away. Used by ``view``."""

from collections.abc import Callable

import numpy as np
import viser

from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import HalfSpace, Mesh
from ulna.robot import Robot
from ulna.viewer.visuals import triangles

NAME = "floor"
_BELOW = 1e-3  # [m] under the lowest point of what does not move, so that the base does not touch it


class Floor:
    """A checkbox. ``moved`` is called when there is something to do."""

    def __init__(self, gui: viser.GuiApi, world: World, height: float, moved: Callable[[], None]) -> None:
        self._world, self._height, self._moved = world, height, moved
        self.on = gui.add_checkbox("Floor", initial_value=NAME in world.names, hint=f"An obstacle: all below z = {height:.3f} m")
        self.on.on_update(self._set)

    def show(self) -> None:
        """Whether there is one: it may be deleted like any obstacle."""
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
    """The height of a floor [m] that the base does not touch: that which is drawn, or lower."""
    places = dict(zip(robot.link_names, robot.link_poses(robot.home), strict=True))
    lowest = [drawn]
    for link in robot.description.links:
        for body in link.collisions if robot.tree.link_row[link.name] < 0 else ():
            if not isinstance(body.shape, Mesh | HalfSpace):
                T = places[link.name] @ body.pose
                lowest.append(float((triangles(body.shape).vertices @ T[2, :3] + T[2, 3]).min()) - _BELOW)
    return float(np.min(lowest))
