"""The form of the chosen obstacle: its name, its sizes, its place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import viser
from numpy.typing import NDArray

from ulna.errors import UlnaError
from ulna.model.clouds import Obstacle
from ulna.model.pose import pose, rpy_from_matrix
from ulna.model.shapes import Box, Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from ulna.viewer.obstacles import Obstacles

_NONE: str = "none"
_DIGITS = 4  # behind the point: tenths of millimetres
Known = dict[str, tuple[Obstacle, "NDArray[Any]"]]


class ObstacleForm:
    """The fields of one obstacle; those that it has not are hidden."""

    def __init__(self, gui: viser.GuiApi, obstacles: Obstacles) -> None:
        self._obstacles, self._next, self._changed = obstacles, "", False
        zero = (0.0, 0.0, 0.0)
        self.choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Obstacle", [_NONE], initial_value=_NONE, hint="Or click it in the scene"
        )
        self.name = gui.add_text("Name", "", visible=False)
        self.extents = gui.add_vector3("Extents [m]", zero, min=zero, step=0.001, visible=False, hint="Edges along x, y, z")
        self.radius = gui.add_number("Radius [m]", 0.0, min=0.0, step=0.001, visible=False)
        self.length = gui.add_number("Length [m]", 0.0, min=0.0, step=0.001, visible=False)
        self.xyz = gui.add_vector3("Position [m]", zero, step=0.001, visible=False, hint="Of its middle, in the base frame")
        self.rpy = gui.add_vector3("Roll, pitch, yaw [rad]", zero, step=0.01, visible=False)
        self.choice.on_update(self._chosen)
        for field in (self.name, self.extents, self.radius, self.length, self.xyz, self.rpy):
            field.on_update(self._typed)

    @property
    def chosen(self) -> str:
        """The name that is chosen."""
        return self._next or self.choice.value

    def choose(self, name: str) -> None:
        """Choose an obstacle that the next ``show`` finds."""
        self._next, self._changed = name, True

    def take(self) -> bool:
        """Whether another one was chosen since the last call."""
        changed, self._changed = self._changed, False
        return changed

    def show(self, known: Known) -> None:
        """Tell of the chosen obstacle as it is now."""
        options = (_NONE, *known)
        chosen = self.chosen if self.chosen in known else _NONE
        self._next = ""
        if self.choice.options != options:
            self.choice.options = options
        if self.choice.value != chosen:
            self.choice.value = chosen
        shape, T = known.get(chosen, (None, None))
        self._show_fields(shape)
        if shape is None or T is None:
            return
        self._write(self.name, chosen)
        for field, value in self._sizes(shape):
            self._write(field, value)
        self._write(self.xyz, _rounded(T[:3, 3]))
        self._write(self.rpy, _rounded(rpy_from_matrix(T)))

    def _show_fields(self, shape: Obstacle | None) -> None:
        sized = [field for field, _ in self._sizes(shape)]
        for field in (self.extents, self.radius, self.length):
            field.visible = field in sized
        for field in (self.name, self.xyz, self.rpy):
            field.visible = shape is not None

    def _sizes(self, shape: Obstacle | None) -> list[tuple[Any, Any]]:
        match shape:
            case Box(extents):
                return [(self.extents, extents)]
            case Sphere(radius):
                return [(self.radius, radius)]
            case Cylinder(radius, length) | Capsule(radius, length):
                return [(self.radius, radius), (self.length, length)]
        return []

    @staticmethod
    def _write(field: Any, value: Any) -> None:
        if field.value != value:
            field.value = value

    def _chosen(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._changed = True
            self._obstacles.moved()

    def _typed(self, event: viser.GuiEvent) -> None:
        """A person has typed: the obstacle becomes what the form says."""
        if event.client is None or self.chosen not in self._obstacles.world.names:
            return
        name, world = self.chosen, self._obstacles.world
        shape, T = world.shape(name), world.pose(name)
        if event.target in (self.xyz, self.rpy):
            T = pose(self.xyz.value, self.rpy.value)
        try:
            self._obstacles.change(name, self._shape(shape), T, self.name.value.strip() or name)
        except UlnaError as error:
            event.client.add_notification("That cannot be", str(error), color="red")

    def _shape(self, shape: Obstacle) -> Obstacle:
        """The shape that the sizes say; the same one if they say nothing new."""
        match shape:
            case Box():
                new: Obstacle = Box(self.extents.value)
            case Sphere():
                new = Sphere(self.radius.value)
            case Cylinder() | Capsule():
                new = type(shape)(self.radius.value, self.length.value)
            case _:
                return shape
        return shape if new == shape else new


def _rounded(values: NDArray[Any]) -> tuple[float, ...]:
    return tuple(float(value) + 0.0 for value in values.round(_DIGITS))
