"""Draws a robot in the scene, and shows or hides its visuals, collision shapes, link frames and link names."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.meshes.mesh_files import MeshFiles
from ulna.description.names.panda import INSTALL_MESHES
from ulna.description.pose import quaternion_from_matrix
from ulna.description.robot_description import Body
from ulna.description.shapes import Mesh, UnknownShape
from ulna.errors import FileError, count_of
from ulna.robot import Robot
from ulna.viewer.html import bullet_list, small_text, tree_html
from ulna.viewer.nodes import add_shape, add_triangles, offset_mesh
from ulna.viewer.palette import FAINT, FREE, PALE, STRONG, TINT, TOUCHING
from ulna.viewer.visuals import glb_of, link_visuals, links_moving_with, read_mesh, tinted

_OFFSET = 3e-3  # share of the robot's size: the offset of a surface drawn over another one, against flicker
_MIN_MOTION = 1e-6  # [m or 1] the pose of a link is not sent to the page for a smaller change


@dataclass(frozen=True, eq=False)
class Extent:
    """The AABB of a robot at home: its lowest and highest corner in the base frame [m], shape (3,) each."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def center(self) -> NDArray[np.float64]:
        """The center of the AABB [m], shape (3,)."""
        return (self.low + self.high) / 2

    @property
    def radius(self) -> float:
        """Half the diagonal of the AABB [m], at least 0.05."""
        return max(float(np.linalg.norm(self.high - self.low)) / 2, 0.05)


class Arm:
    """A robot as nodes of the scene, below the node ``root``. ``move_to`` and ``mark_touching`` update it in each frame.

    Attributes:
        missing: The meshes that are not shown, each with the reason.
        visuals: The triangles of each link that has any, in its own frame.
        frames: The nodes of the links.
        looks: The nodes of the visuals, by link.
        names: The nodes of the labels.
        hidden: The links whose visuals are hidden.
        solids, attached: The nodes of the collision shapes and of the attached objects, by their names in reports.
        extent: The robot's AABB at home.
    """

    def __init__(self, server: viser.ViserServer, robot: Robot, root: str = "/robot") -> None:
        self.robot, self._scene, self._root = robot, server.scene, root
        visuals = link_visuals(robot)
        self.missing, self.visuals = visuals.missing, visuals.scenes
        self.extent = _extent(robot, visuals.scenes)
        self.frames = [
            self._scene.add_frame(
                f"{root}/{k}", show_axes=False, axes_length=0.2 * self.extent.radius, axes_radius=0.007 * self.extent.radius
            )
            for k in range(len(robot.link_names))
        ]
        self._places = np.zeros((len(self.frames), 4, 4))
        number = {name: k for k, name in enumerate(robot.link_names)}
        self.looks = {
            name: self._scene.add_glb(f"{root}/{number[name]}/body", glb_of(scene)) for name, scene in visuals.scenes.items()
        }
        self.hidden: frozenset[str] = frozenset()
        self.names = [
            self._scene.add_label(f"{root}/{k}/name", name, visible=False, font_screen_scale=0.9, anchor=f"bottom-{side}")  # type: ignore[arg-type]
            for (k, name), side in zip(_names_by_origin(robot), cycle(("right", "left")), strict=False)
        ]
        self._link_of = {held.name: held.link for held in robot.attached}  # by the name of the shape
        self.solids = self._add_solids(number)
        self.attached: dict[str, Any] = {}
        self._looks_shown, self._n_held = True, 0
        self._clicked: Callable[[str], None] = lambda _: None
        self.attach(robot)
        self._touching: tuple[str, ...] = ()
        self._red: frozenset[str] = frozenset()  # the links that are shown in red
        self._tints: dict[str, Any] = {}  # the red mesh of each link that was in contact once
        self._nearest, self._solids_shown = "", True

    def move_to(self, q: NDArray[np.float64]) -> None:
        """Move every link to its pose at q, shape (n_dof,)."""
        places = self.robot.link_poses(q)
        moved = np.flatnonzero(np.abs(places - self._places).max(axis=(1, 2)) > _MIN_MOTION)
        turns = quaternion_from_matrix(places)
        for k in moved:
            self.frames[k].position, self.frames[k].wxyz = places[k, :3, 3], turns[k]
        self._places[moved] = places[moved]

    def attach(self, robot: Robot) -> None:
        """Draw the attached objects of a robot with the same links."""
        held = {one.name: one for one in robot.attached}
        known = {one.name: one for one in self.robot.attached}
        for name in [name for name in self.attached if held.get(name) is not known.get(name)]:
            self.attached.pop(name).remove()
            self._link_of.pop(name)
        self.robot = robot
        for name in held.keys() - self.attached.keys():
            one, self._n_held = held[name], self._n_held + 1
            place = f"{self._root}/{robot.link_names.index(one.link)}/held{self._n_held}"
            self.attached[name] = add_shape(self._scene, place, one.shape, FREE, STRONG, one.T_link_object)
            self._link_of[name] = one.link

    def show_looks(self, *, visible: bool | None = None, hidden: frozenset[str] | None = None) -> None:
        """Show or hide the visuals: all of them, or those of single links."""
        self._looks_shown = self._looks_shown if visible is None else visible
        self.hidden = self.hidden if hidden is None else hidden
        self._show_links()
        for node in self.attached.values():
            node.visible = self._looks_shown

    def on_click(self, clicked: Callable[[str], None]) -> None:
        """Call a function with the name of each link that a person clicks."""
        self._clicked = clicked
        for link, node in self.looks.items():
            node.on_click(lambda _, link=link: clicked(link))

    def mark_touching(self, names: Collection[str]) -> None:
        """Show collision shapes and their links in red, by the names of the shapes; all other shapes pale blue."""
        for name, node in (self.solids | self.attached).items():
            if (name in self._touching) != (name in names):
                node.color = TOUCHING if name in names else FREE
        self._touching = tuple(names)
        self._set_opacities()
        hit = (self._link_of[name] for name in names if name in self._link_of)
        red = links_moving_with(self.robot, hit) & self.visuals.keys()
        for link in red - self._tints.keys():
            glb = glb_of(tinted(self.visuals[link], TOUCHING, TINT))
            tint = self._tints[link] = self._scene.add_glb(f"{self._root}/{self.robot.link_names.index(link)}/touching", glb)
            tint.on_click(lambda _, link=link: self._clicked(link))
        self._red = red
        self._show_links()

    def _show_links(self) -> None:
        """Show each link in red or in its own colors. Links in contact are shown even without visuals."""
        for link, node in self.looks.items():
            node.visible = self._looks_shown and link not in self.hidden and link not in self._red
        for link, node in self._tints.items():
            node.visible = link in self._red and link not in self.hidden

    def show_nearest(self, name: str) -> None:
        """Show the shape of a name, faintly if collision shapes are hidden: the one nearest to an obstacle."""
        if name != self._nearest and not self._solids_shown:
            for shape, visible in ((self._nearest, False), (name, True)):
                if shape in self.solids:
                    self.solids[shape].visible = visible
        self._nearest = name
        self._set_opacities()

    def show_solids(self, *, visible: bool) -> None:
        """Show or hide the collision shapes."""
        self._solids_shown = visible
        for name, node in self.solids.items():
            node.visible = visible or name == self._nearest
        self._set_opacities()

    def _set_opacities(self) -> None:
        """Set the opacities of the collision shapes.

        Shapes in contact and attached objects are strong, the others pale. If the others are hidden, the nearest one is faint.
        """
        for name, node in (self.solids | self.attached).items():
            is_strong = name in self._touching or name in self.attached
            opacity = STRONG if is_strong else FAINT if name == self._nearest and not self._solids_shown else PALE
            if node.opacity != opacity:
                node.opacity = opacity

    def _add_solids(self, number: dict[str, int]) -> dict[str, Any]:
        """Add the collision shapes, pale. Returns their nodes by name, and adds unreadable meshes to ``missing``."""
        files, found = MeshFiles(self.robot.description), {}
        bodies = [(link.name, body) for link in self.robot.description.links for body in link.collisions]
        look = {"cast_shadow": False, "receive_shadow": False}
        for n, ((link, body), name) in enumerate(zip(bodies, self._solid_names(bodies), strict=True)):
            place = f"{self._root}/{number[link]}/solid{n}"
            self._link_of[name] = link
            if isinstance(body.shape, UnknownShape):
                continue
            if not isinstance(body.shape, Mesh):
                found[name] = add_shape(self._scene, place, body.shape, FREE, PALE, body.pose, **look)
                continue
            try:
                mesh = read_mesh(body.shape, files).apply_transform(body.pose).to_mesh()
                mesh = offset_mesh(mesh, _OFFSET * self.extent.radius)
            except FileError as error:
                self.missing = tuple(dict.fromkeys((*self.missing, str(error))))
            else:
                found[name] = add_triangles(self._scene, place, mesh, FREE, opacity=PALE, **look)
        return found

    def _solid_names(self, bodies: list[tuple[str, Body]]) -> list[str]:
        """The names of collision shapes in reports; numbered names for a robot whose shapes cannot be checked."""
        if any(isinstance(body.shape, Mesh | UnknownShape) for _, body in bodies) or not bodies:
            return [f"{link}/{body.name} ({n})" for n, (link, body) in enumerate(bodies)]
        return list(self.robot.collision_names[: len(bodies)])


def _names_by_origin(robot: Robot) -> list[tuple[int, str]]:
    """The labels of links: for each origin, the number of its first link and the names of all its links.

    Origins that coincide at two configurations share a label.
    """
    places = np.hstack([robot.link_poses(q)[:, :3, 3] for q in (robot.home, np.clip(robot.home + 0.1, robot.lower, robot.upper))])
    together: dict[bytes, list[int]] = {}
    for k, place in enumerate(places.round(6) + 0.0):
        together.setdefault(place.tobytes(), []).append(k)
    return [(links[0], ", ".join(robot.link_names[k] for k in links)) for links in together.values()]


def _extent(robot: Robot, scenes: dict[str, Any]) -> Extent:
    """The AABB of the visuals and of the origins of the links, at home."""
    places = dict(zip(robot.link_names, robot.link_poses(robot.home), strict=True))
    points = [T[:3, 3] for T in places.values()]
    for name, scene in scenes.items():
        corners = scene.bounding_box.vertices
        points += list(corners @ places[name][:3, :3].T + places[name][:3, 3])
    return Extent(np.min(points, axis=0), np.max(points, axis=0))


REAL_ARM = f"This arm is drawn from its joints alone. For its real meshes (4.3 MB) run {INSTALL_MESHES}, and restart."


def _show_all(nodes: Collection[Any], attribute: str, event: viser.GuiEvent) -> None:
    """Set an attribute of nodes to the value of a checkbox."""
    for node in nodes:
        setattr(node, attribute, event.target.value)


class VisibilityPanel:
    """Checkboxes that show parts of the robot, its kinematic tree, and the list of missing meshes."""

    def __init__(self, gui: viser.GuiApi, arm: Arm) -> None:
        for name, hint, nodes, attribute in (
            ("Visuals", "The robot's visual meshes", (*arm.looks.values(), *arm.attached.values()), "visible"),
            ("Collision shapes", "The shapes for collision checking", arm.solids.values(), "visible"),
            ("Link frames", "x red, y green, z blue", arm.frames, "show_axes"),
            ("Link names", None, arm.names, "visible"),
        ):
            box = gui.add_checkbox(name, initial_value=name == "Visuals", disabled=not nodes, hint=hint)
            if name == "Collision shapes":
                box.on_update(lambda event: arm.show_solids(visible=event.target.value))
            elif name == "Visuals":
                box.on_update(lambda event: arm.show_looks(visible=event.target.value))
            else:
                box.on_update(partial(_show_all, nodes, attribute))
        arm.show_solids(visible=False)
        if arm.missing:
            with gui.add_folder(f"Missing meshes ({len(arm.missing)})", expand_by_default=False):
                if arm.robot.name == "panda":
                    gui.add_html(small_text(REAL_ARM))
                gui.add_html(bullet_list(arm.missing))
        with gui.add_folder(f"Tree ({count_of(len(arm.robot.link_names), 'link')})", expand_by_default=False):
            gui.add_html(tree_html(arm.robot))
