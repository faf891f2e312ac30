"""Shows the obstacles, and lets a person add, edit, drag, delete, save and load them."""

import threading
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.grids import Obstacle
from ulna.collision.scene_file import world_from_json, world_to_json
from ulna.collision.world import World, exchange
from ulna.description.pose import pose, quaternion_from_matrix
from ulna.description.shapes import HalfSpace
from ulna.errors import InputError
from ulna.viewer.nodes import Handles, add_shape, paint, reshape
from ulna.viewer.obstacle_form import ObstacleForm
from ulna.viewer.palette import GROUND, OBSTACLES, PALE, TOUCHING, Color
from ulna.viewer.primitives import LOOKS
from ulna.viewer.session.scene_history import Entry, Scene, SceneHistory, scene_of, world_of
from ulna.viewer.typed_fields import refusals_shown
from ulna.viewer.uploads import ENDINGS, shapes_of_file

_EDGE = 0.15  # the edge of a new obstacle, as a share of the robot's size
_NEW = {kind.__name__: looks.new for kind, looks in LOOKS.items()}
_UNITS = {"m": 1.0, "mm": 1e-3}  # [m]


class Obstacles:
    """The objects of a world as nodes of the scene. The chosen one has handles and a form.

    Args:
        server: The page.
        world: The obstacles. The program may change it too; the next ``show`` draws the change.
        place: The position of a new obstacle in the base frame [m], shape (3,).
        size: The robot's size [m].
        on_event: Called when the obstacles were changed.
        reserved: Names that no obstacle can have: those of the robot's links and shapes.

    Attributes:
        history: The undo history of the page.
        is_picked: Whether the chosen obstacle was clicked or dragged in the scene, and so has handles in any tab.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        world: World,
        place: NDArray[np.float64],
        size: float,
        on_event: Callable[[], None],
        reserved: Collection[str] = (),
    ) -> None:
        self._server, self.world, self._place, self.on_event, self._reserved = server, world, place, on_event, reserved
        self._edge, self._reach = round(_EDGE * size, 2) or 0.01, 0.25 * size
        self.nodes: dict[str, Any] = {}
        self._drawn: dict[str, tuple[Obstacle, NDArray[np.float64]]] = {}
        self._colors: dict[str, Color] = {}  # of every obstacle that was drawn; kept after its deletion, which may be undone
        self._count = 0
        self.lock, self.history = threading.RLock(), SceneHistory(world)
        self._scene_before_drag: Scene = {}  # the dragged obstacle as it was before the drag
        self.is_picked = False
        gui = server.gui
        self.handles = Handles(server.scene, "/chosen", 0.25 * size, on_event, visible=False)
        self.add_buttons = gui.add_button_group("Add", tuple(_NEW))
        with gui.add_folder("Add a mesh or point cloud", expand_by_default=False):
            self.unit = gui.add_dropdown("Unit of the file", tuple(_UNITS))
            self.pieces = gui.add_checkbox(
                "Split the mesh into convex pieces",
                initial_value=False,
                disabled=find_spec("coacd") is None,
                hint="CoACD takes seconds to minutes; each piece is an obstacle. Without splitting, the convex hull is added",
            )
            self.file = gui.add_upload_button("Choose a file", hint=", ".join(ENDINGS), mime_type=",".join(ENDINGS))
        self.form = ObstacleForm(gui, world, self.change, on_event)
        self.delete = gui.add_button("Delete", hint="Delete the chosen obstacle", visible=False)
        self.save = gui.add_button("Save scene", hint="Download the obstacles as a JSON file")
        self.load = gui.add_upload_button(
            "Load scene", hint="Replace all obstacles with those of a saved file", mime_type="application/json"
        )
        self.add_buttons.on_click(lambda event: self.add(event.target.value))
        self.delete.on_click(lambda _: self.remove())
        self.save.on_click(self._download)
        self.load.on_upload(self._load)
        self.file.on_upload(self._add_file)

    @property
    def chosen(self) -> str | None:
        """The name of the chosen obstacle."""
        return self.form.chosen if self.form.chosen in self.world.names else None

    def add(self, kind: str) -> None:
        """Add an obstacle and choose it. kind: a key of ``_NEW``."""
        stem = f"new {kind.lower()}" if f"{kind.lower()} 1" in self._reserved else kind.lower()
        with self.changing():
            name = self._free_name(f"{stem} {n}" for n in count(1))
            self.world.add(name, _NEW[kind](self._edge), pose(self._free_place()))
            self.form.choose(name)

    def covers(self, point: NDArray[np.float64]) -> bool:
        """Whether the handles of the chosen obstacle would overlap handles at a point [m], shape (3,)."""
        chosen = self.chosen
        return chosen is not None and float(np.linalg.norm(self.world.pose(chosen)[:3, 3] - point)) < self._reach

    def remove(self) -> None:
        """Delete the chosen obstacle."""
        with self.changing():
            if self.chosen is not None:
                self.world.remove(self.chosen)

    def change(self, name: str, shape: Obstacle, T: NDArray[np.float64], new_name: str) -> None:
        """Change the shape, the pose T, shape (4, 4), or the name of an obstacle."""
        if new_name != name and new_name in self._reserved:
            raise InputError("name", f"{new_name!r} is the name of a part of the robot; choose another name")
        with self.changing():
            if new_name != name and new_name in self.world.names:
                raise InputError("name", f"the world already has an object {new_name!r}; choose another name")
            now = Entry(shape, T, self.world.touch_links(name), self.world.speed(name))
            exchange(self.world, () if new_name == name else (name,), world_of({new_name: now}))
            if new_name != name:
                self.form.choose(new_name)

    def replace(self, world: World) -> None:
        """Replace all objects by those of another world."""
        with self.changing():
            exchange(self.world, self.world.names, world.snapshot())

    @contextmanager
    def changing(self) -> Iterator[None]:
        """A context whose changes of the obstacles are one step to undo."""
        with self.lock, self.history.step():
            yield
        self.on_event()

    def apply_input(self) -> bool:
        """Move the chosen obstacle to its dragged handles. Returns whether another obstacle was chosen."""
        with self.lock:
            other = self.form.apply_input()
            dragged = self.handles.pop_moved()
            if dragged and not other and self.chosen is not None:  # with another choice, the drag was of the obstacle before
                self._scene_before_drag = self._scene_before_drag or {self.chosen: scene_of(self.world)[self.chosen]}
                self.world.move(self.chosen, self.handles.pose)
            if self._scene_before_drag and not self.handles.dragged:
                now = scene_of(self.world)
                self.history.add(self._scene_before_drag, {name: now[name] for name in self._scene_before_drag if name in now})
                self._scene_before_drag = {}
            return other

    def show(self, touching: set[str], *, handled: bool = True) -> None:
        """Draw the present world, with the obstacles of the names in ``touching`` in red.

        handled: whether the chosen obstacle may have handles.
        """
        with self.lock:
            known = {name: (shape, T) for name, shape, T in self.world.items()}
            for name, (shape, at) in [*self._drawn.items()]:
                now = known[name][0] if name in known else None
                if now is shape:
                    continue
                if now is not None and reshape(self.nodes[name], shape, now):
                    self._drawn[name] = (now, at)
                else:
                    self.nodes.pop(name).remove()
                    del self._drawn[name]
            for name, (shape, at) in known.items():
                self._draw(name, shape, at, red=name in touching)
            self.form.show(known)
            _, at = known.get(self.form.chosen, (None, None))
            self.delete.visible = at is not None
            self.handles.show(visible=at is not None and handled)
            if at is not None:
                self.handles.put(at)

    def _draw(self, name: str, shape: Obstacle, T: NDArray[np.float64], *, red: bool) -> None:
        own = self._colors.setdefault(name, OBSTACLES[len(self._colors) % len(OBSTACLES)])
        color, opacity = TOUCHING if red else own, None  # viser sorts a node with opacity 1.0 among the translucent ones
        if isinstance(shape, HalfSpace):  # translucent, so that it hides nothing
            color, opacity = TOUCHING if red else GROUND, PALE
        if name not in self._drawn:
            self._count += 1
            node = self.nodes[name] = add_shape(self._server.scene, f"/obstacles/{self._count}", shape, color, opacity, T)
            if not isinstance(shape, PointCloud):  # viser sends no clicks on point clouds
                node.on_click(lambda _: self._pick(name))
                if not isinstance(shape, HalfSpace):
                    self.handles.make_draggable(node, lambda: self._grab(name))
        elif not np.array_equal(self._drawn[name][1], T):
            self.nodes[name].position, self.nodes[name].wxyz = T[:3, 3], quaternion_from_matrix(T)
        paint(self.nodes[name], color, opacity)
        self._drawn[name] = (shape, T)

    def _grab(self, name: str) -> NDArray[np.float64] | None:
        """Choose an obstacle at the start of its drag. Returns its pose, shape (4, 4)."""
        with self.lock:
            self.is_picked = True
            if self.form.chosen != name:
                self.form.choose(name)
                self.form.apply_input()
            return self.world.pose(name) if name in self.world.names else None

    def _pick(self, name: str) -> None:
        with self.lock:
            self.is_picked = True
            self.form.choose(name)
        self.on_event()

    def _download(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            with refusals_shown(event.client, "The scene was not saved"):
                event.client.send_file_download("scene.json", world_to_json(self.world).encode(), save_immediately=True)

    def step(self, act: Callable[[], tuple[str, ...]]) -> None:
        """Undo or redo a step, unless an obstacle is being dragged, and choose an obstacle that it changed."""
        with self.lock:
            names = () if self._scene_before_drag else act()
            if names:
                self.form.choose(names[-1])
        self.on_event()

    def _load(self, event: viser.GuiEvent) -> None:
        with refusals_shown(event.client, "The scene was not loaded"):
            self.replace(world_from_json(self.load.value.content, self.load.value.name))

    def _add_file(self, event: viser.GuiEvent) -> None:
        """Add the shapes of a mesh or point cloud file, whose frame is taken as the base, and choose one."""
        file = self.file.value

        def announce(_: str) -> None:
            if event.client is not None:
                event.client.add_notification("Decomposing", f"{file.name} will be added once it is split", color="blue")

        scale, stem = _UNITS[self.unit.value], Path(file.name).stem or "file"
        with refusals_shown(event.client, "Nothing was added"):
            shapes = shapes_of_file(file.name, file.content, scale=scale, pieces=self.pieces.value, announce=announce)
            with self.changing():
                for k, shape in enumerate(shapes, start=1):
                    own = stem if len(shapes) == 1 else f"{stem} piece {k}"
                    name = self._free_name(f"{own} {n}" if n > 1 else own for n in count(1))
                    self.world.add(name, shape)
                    self.form.choose(name)

    def _free_place(self) -> NDArray[np.float64]:
        """A position for a new obstacle beside the present ones [m], shape (3,)."""
        others = np.array([T[:3, 3] for _, _, T in self.world.items()]).reshape(-1, 3)
        ways = [
            np.array([0.0, 0.0, 0.0]),
            *(2.0 * self._edge * np.array([0.0, side * k, 0.0]) for k in range(1, 9) for side in (1, -1)),
        ]
        free = (place for place in self._place + ways if not (np.abs(others - place).max(axis=1) < self._edge).any())
        return next(free, self._place)

    def _free_name(self, names: Iterable[str]) -> str:
        """The first name that no obstacle and no part of the robot has."""
        return next(name for name in names if name not in self.world.names and name not in self._reserved)
