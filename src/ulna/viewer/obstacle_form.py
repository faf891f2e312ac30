"""Shows and edits the chosen obstacle: its name, its dimensions, its pose."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import viser
from numpy.typing import NDArray

from ulna.collision.clouds import Obstacle, PointCloud
from ulna.collision.world import World
from ulna.description.pose import pose, rpy_from_matrix
from ulna.description.shapes import Box, Capsule, Cylinder, Sphere
from ulna.errors import UlnaError
from ulna.viewer.pose_fields import retyped, rounded

_NONE: str = "none"
Known = dict[str, tuple[Obstacle, NDArray[Any]]]
Change = Callable[[str, Obstacle, NDArray[Any], str], object]


class Edit(NamedTuple):
    """The last value typed into a field, the name of its obstacle, and the tab in which it was typed."""

    field: Any
    name: str
    value: Any
    client: viser.ClientHandle


class ObstacleForm:
    """The fields of one obstacle; those that its shape does not have are hidden. Typed values are not overwritten until ``take``.

    Args:
        gui: The panel, to which the fields are added.
        world: The obstacles.
        change: Called with an obstacle's name, and its new shape, pose and name.
        moved: Called when ``take`` is to be called.
    """

    def __init__(self, gui: viser.GuiApi, world: World, change: Change, moved: Callable[[], None]) -> None:
        self._world, self._change, self._moved = world, change, moved
        self._next, self._changed = "", False
        self._edits: dict[int, Edit] = {}
        zero = (0.0, 0.0, 0.0)
        self.choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Obstacle", [_NONE], initial_value=_NONE, hint="Or click it in the scene"
        )
        self.name = gui.add_text("Name", "", visible=False)
        self.extents = gui.add_vector3("Extents [m]", zero, step=0.001, visible=False, hint="Edges along x, y, z")
        self.radius = gui.add_number("Radius [m]", 0.0, step=0.001, visible=False)
        self.length = gui.add_number("Length [m]", 0.0, step=0.001, visible=False)
        self.xyz = gui.add_vector3("Position [m]", zero, step=0.001, visible=False, hint="Of its centre, in the base frame")
        self.rpy = gui.add_vector3("Roll, pitch, yaw [rad]", zero, step=0.01, visible=False)
        self.choice.on_update(self._chosen)
        for field in (self.name, self.extents, self.radius, self.length, self.xyz, self.rpy):
            field.on_update(self._typed)

    @property
    def chosen(self) -> str:
        """The name of the chosen obstacle."""
        return self._next or self.choice.value

    def choose(self, name: str) -> None:
        """Choose an obstacle; the next ``show`` shows it."""
        self._next, self._changed = name, True

    def take(self) -> bool:
        """Apply what was typed since the last call; a refused value is reset. Returns whether another obstacle was chosen."""
        edits, self._edits = self._edits, {}
        in_turn = sorted(
            edits.values(), key=lambda edit: edit.field is self.name
        )  # the name last: the other edits have the old name
        refused = [edit for edit in in_turn if not self._apply(edit)]
        if refused:
            self.show({name: (shape, T) for name, shape, T in self._world.items()})
        changed, self._changed = self._changed, False
        return changed

    def show(self, known: Known) -> None:
        """Show the chosen obstacle as it is now."""
        options = (_NONE, *known)
        chosen = self.chosen if self.chosen in known else _NONE
        self._next = ""
        if self.choice.options != options:
            self.choice.options = options
        self.choice.value = chosen
        shape, T = known.get(chosen, (None, None))
        self._show_fields(shape)
        if shape is None or T is None:
            return
        self._write(self.name, chosen)
        for field, value in self._sizes(shape):
            self._write(field, value)
        self._write(self.xyz, rounded(T[:3, 3]))
        self._write(self.rpy, rounded(rpy_from_matrix(T)))

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
            case Sphere(radius=radius) | PointCloud(radius=radius):
                return [(self.radius, radius)]
            case Cylinder(radius, length) | Capsule(radius, length):
                return [(self.radius, radius), (self.length, length)]
        return []

    def _write(self, field: Any, value: Any) -> None:
        if id(field) not in self._edits:
            field.value = value

    async def _chosen(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._changed = True
            self._moved()

    async def _typed(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._edits[id(event.target)] = Edit(event.target, self.chosen, event.target.value, event.client)
            self._moved()

    def _apply(self, edit: Edit) -> bool:
        """Apply one typed value. Returns whether it was accepted: a dimension may be negative, or a name taken."""
        known = {name: (shape, T) for name, shape, T in self._world.items()}
        if edit.name not in known:
            return True
        field, (shape, T) = edit.field, known[edit.name]
        name = (edit.value.strip() if field is self.name else "") or edit.name
        try:
            if field is self.xyz:
                T[:3, 3] = retyped(T[:3, 3], edit.value)
            elif field is self.rpy:
                T[:3, :3] = pose(rpy=retyped(rpy_from_matrix(T), edit.value))[:3, :3]
            self._change(edit.name, self._shape(shape, field, edit.value), T, name)
        except UlnaError as error:
            edit.client.add_notification("Not changed", str(error), color="red")
            return False
        return True

    def _shape(self, shape: Obstacle, field: Any, value: Any) -> Obstacle:
        """The shape with one dimension changed; unchanged if the field is not a dimension."""
        if field is self.extents and isinstance(shape, Box):
            return Box(value)
        if field is self.radius and isinstance(shape, PointCloud):
            return PointCloud(shape.points, value)
        if field is self.radius and isinstance(shape, Sphere | Cylinder | Capsule):
            return replace(shape, radius=value)
        if field is self.length and isinstance(shape, Cylinder | Capsule):
            return replace(shape, length=value)
        return shape
