"""Shows and edits the name, the dimensions and the pose of the chosen obstacle."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import viser
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.grids import Obstacle
from ulna.collision.world import World
from ulna.description.shapes import KINDS
from ulna.viewer.typed_fields import Typed, TypedFields, refusals_shown, retype_angles, retype_position

_NONE: str = "none"
Objects = dict[str, tuple[Obstacle, NDArray[Any]]]
Change = Callable[[str, Obstacle, NDArray[Any], str], object]


def _size_field(gui: viser.GuiApi, name: str, count: int) -> Any:
    """A hidden field of a dimension that has one number, or three along x, y and z."""
    label = f"{name.capitalize()} [m]"
    if count == 1:
        return gui.add_number(label, 0.0, step=0.001, visible=False)
    return gui.add_vector3(label, (0.0, 0.0, 0.0), step=0.001, visible=False, hint="Along x, y, z")


class ObstacleForm:
    """The fields of one obstacle. Fields that its shape does not have are hidden.

    Typed values are not overwritten until ``apply_input``.

    Args:
        gui: The panel, to which the fields are added.
        world: The obstacles.
        change: Called with an obstacle's name, and its new shape, pose and name.
        on_event: Called after an event, for which ``apply_input`` is to be called.

    Attributes:
        sizes: The field of each dimension that some kind of shape has, by the attribute of the shape.
    """

    def __init__(self, gui: viser.GuiApi, world: World, change: Change, on_event: Callable[[], None]) -> None:
        self._world, self._change, self._on_event = world, change, on_event
        self._requested, self._changed = "", False
        zero = (0.0, 0.0, 0.0)
        self.choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Obstacle", [_NONE], initial_value=_NONE, hint="Or click it in the scene"
        )
        self.name = gui.add_text("Name", "", visible=False)
        sizes = {name: n for kind in KINDS for name, n in kind.sizes.items()}
        self.sizes = {name: _size_field(gui, name, n) for name, n in sizes.items()}
        self.xyz = gui.add_vector3(
            "Position [m]", zero, step=0.001, visible=False, hint="Position of its center in the base frame"
        )
        self.rpy = gui.add_vector3("Roll, pitch, yaw [rad]", zero, step=0.01, visible=False)
        self._fields = TypedFields((self.name, *self.sizes.values(), self.xyz, self.rpy), on_event, lambda: self.chosen)
        self.choice.on_update(self._chosen)

    @property
    def chosen(self) -> str:
        """The name of the chosen obstacle."""
        return self._requested or self.choice.value

    def choose(self, name: str) -> None:
        """Choose an obstacle by its name; the next ``show`` shows it."""
        self._requested, self._changed = name, True

    def apply_input(self) -> bool:
        """Apply the values typed since the last call, and reset invalid ones. Returns whether another obstacle was chosen."""
        typed = self._fields.pop_values()
        for edit in sorted(typed, key=lambda edit: edit.field is self.name):  # the name last: the others refer to the old one
            with refusals_shown(edit.client, "Not changed"):
                self._apply(edit)
        if typed:
            self.show(self._objects())
        changed, self._changed = self._changed, False
        return changed

    def show(self, known: Objects) -> None:
        """Show the present values of the chosen obstacle."""
        options = (_NONE, *known)
        chosen = self.chosen if self.chosen in known else _NONE
        self._requested = ""
        if self.choice.options != options:
            self.choice.options = options
        self.choice.value = chosen
        shape, T = known.get(chosen, (None, None))
        for field in (self.name, self.xyz, self.rpy):
            field.visible = shape is not None
        for name, field in self.sizes.items():
            field.visible = hasattr(shape, name)
            if field.visible:
                self._fields.write(field, getattr(shape, name))
        if T is not None:
            self._fields.write(self.name, chosen)
            self._fields.write_pose(self.xyz, self.rpy, T)

    def _objects(self) -> Objects:
        return {name: (shape, T) for name, shape, T in self._world.items()}

    async def _chosen(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._changed = True
            self._on_event()

    def _apply(self, edit: Typed) -> None:
        """Apply one typed value."""
        known = self._objects()
        if edit.chosen not in known:
            return
        (shape, T), name = known[edit.chosen], edit.chosen
        if edit.field is self.name:
            name = edit.value.strip() or name
        elif edit.field is self.xyz:
            retype_position(T, edit.value)
        elif edit.field is self.rpy:
            retype_angles(T, edit.value)
        elif isinstance(shape, PointCloud):
            shape = PointCloud(shape.points, edit.value)
        else:
            size = next(name for name, field in self.sizes.items() if field is edit.field)
            shape = replace(shape, **{size: edit.value})
        self._change(edit.chosen, shape, T, name)
