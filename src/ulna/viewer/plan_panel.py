"""The tab Plan: takes a goal and constraints, shows the plan or why there is none, and plays its motion."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.pose import quaternion_from_matrix
from ulna.ik.task import Task
from ulna.viewer.arm import Arm
from ulna.viewer.html import bullet_list, copy_button, small_text, status_line
from ulna.viewer.nodes import Handles, add_triangles, offset_mesh, paint
from ulna.viewer.palette import GREEN, HOLLOW, RED, TRAIL, UNKNOWN, Color, is_in_the_way
from ulna.viewer.plots import Plots
from ulna.viewer.session.changes import Changes
from ulna.viewer.session.export import as_commands, as_program, motion_file
from ulna.viewer.session.first_configuration import configurations_of
from ulna.viewer.session.planned_motion import JERK, Curve, Goals, Planning
from ulna.viewer.session.scene_history import SceneHistory
from ulna.viewer.session.session import Session
from ulna.viewer.session.waypoints import ASIDE, TILT
from ulna.viewer.typed_fields import HandPose, refusals_shown

_HOLD_HINT = "This joint keeps its position"
_WHAT = (
    "Drag the goal of the hand, and the page plans a collision-free motion to it. It plans again whenever you move the goal "
    "or an obstacle."
)
_PLAY, _PAUSE = "Play", "Pause"
_FORMS = "CSV", "JSON"
_OPENINGS = {"as it is": None, "closed": 0.0, "half open": 0.5, "open": 1.0}
_NO_CURVES: dict[str, Curve] = {}
_GHOST_OPACITY = 0.3
_BAND_OPACITY = 0.35
_CORNERS = 32  # of the rim of a cone
_LONGEST_FRAME = 0.1  # [s] so that the arm does not jump after a pause


class Ghost:
    """The visuals of the moving links at another configuration. Its nodes are added when it is first shown."""

    def __init__(self, server: viser.ViserServer, arm: Arm, root: str) -> None:
        self._scene, self._arm, self._root = server.scene, arm, root
        self._nodes: dict[str, Any] = {}

    def show(self, q: NDArray[np.float64] | None, color: Color, now: NDArray[np.float64]) -> None:
        """Show the ghost at q, shape (n_dof,), without the links that have the same pose at ``now``.

        q is None to hide it.
        """
        robot = self._arm.robot
        if q is not None and not self._nodes:
            look = {"opacity": _GHOST_OPACITY, "cast_shadow": False, "receive_shadow": False}
            for k, (link, visual) in enumerate(self._arm.visuals.items()):
                if robot.tree.link_row[link] < 0:
                    continue
                self._nodes[link] = add_triangles(
                    self._scene, f"{self._root}/{k}", offset_mesh(visual.to_mesh(), 3e-3 * self._arm.extent.radius), color, **look
                )
        if q is not None:
            poses = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
            still = dict(zip(robot.link_names, robot.link_poses(now), strict=True))
            for link, node in self._nodes.items():
                node.position, node.wxyz, node.color = poses[link][:3, 3], quaternion_from_matrix(poses[link]), color
                node.visible = not np.allclose(poses[link], still[link], atol=1e-3)
        if q is None:
            for node in self._nodes.values():
                node.visible = False


class Bands:
    """The constraints of a motion: a bar around its line, and cones around the vertical. size: the robot's [m]."""

    def __init__(self, scene: viser.SceneApi, size: float) -> None:
        look = {"opacity": _BAND_OPACITY, "visible": False, "cast_shadow": False, "receive_shadow": False}
        side = np.sqrt(2.0) * ASIDE  # of a square whose corners are at the tolerance from the line
        self.bar = scene.add_box("/plan/bar", TRAIL, (side, side, 1.0), **look)
        angle, height = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False), 0.3 * size
        rim = height * np.stack([np.cos(angle) * np.tan(TILT), np.sin(angle) * np.tan(TILT), np.ones(_CORNERS)], axis=1)
        vertices = np.concatenate([rim, -rim, np.zeros((1, 3))])  # above the hand, and below it, where the arm does not hide it
        k = np.arange(_CORNERS)
        upper = np.stack([np.full(_CORNERS, 2 * _CORNERS), k, (k + 1) % _CORNERS], axis=1)
        faces = np.concatenate([upper, upper + np.array([0, _CORNERS, _CORNERS])])
        self.cone = scene.add_mesh_simple("/plan/cone", vertices, faces, color=TRAIL, side="double", **look)

    def show_line(self, ends: NDArray[np.float64] | None, color: Color) -> None:
        """Show the bar around the line between two points [m], shape (2, 3); hide it for None."""
        self.bar.visible = ends is not None
        if ends is not None:
            along = ends[1] - ends[0]
            length = float(np.linalg.norm(along))
            side = self.bar.dimensions[0]
            self.bar.dimensions, self.bar.color = (side, side, length), color
            self.bar.position = ends.mean(axis=0)
            self.bar.wxyz = quaternion_from_matrix(Task.pointing(along / length).frame)

    def show_tilt(self, point: NDArray[np.float64] | None) -> None:
        """Show the cones above and below a point [m], shape (3,); hide them for None."""
        self.cone.visible = point is not None
        if point is not None:
            self.cone.position = point


class WayPanel:
    """The list of waypoints, and fields for the approach, retract and gripper opening of the next one.

    ``do`` runs an action of a person.
    """

    def __init__(self, gui: viser.GuiApi, planning: Planning, do: Callable[[Callable[[], object]], None]) -> None:
        self._planning, self._shown = planning, None
        with gui.add_folder("Waypoints", expand_by_default=False, visible=False) as self.folder:
            self.list = gui.add_html("")
            hint = "Length of the straight {} along the z axis of the hand"
            self.approach = gui.add_number("Approach [mm]", 0.0, min=0.0, step=1.0, hint=hint.format("approach"))
            self.retract = gui.add_number("Retract [mm]", 0.0, min=0.0, step=1.0, hint=hint.format("retreat"))
            hint = "Opening of the gripper at the waypoint"
            self.opening = gui.add_dropdown("Gripper", tuple(_OPENINGS), visible=planning.has_gripper, hint=hint)
            hint = "Adds the goal, or the present pose of the arm without a goal; the next goal comes after it"
            self.add = gui.add_button("Add as a waypoint", hint=hint)
            self.remove = gui.add_button("Remove the last waypoint", color="gray", disabled=True)
        self.add.on_click(lambda _: do(self._add))
        self.remove.on_click(lambda _: do(planning.remove_waypoint))

    def show(self) -> None:
        """List the waypoints."""
        if self._shown is self._planning.waypoints:
            return
        self._shown = self._planning.waypoints
        self.folder.label = f"Waypoints ({len(self._shown)})"
        self.remove.disabled = not self._shown
        self.list.content = bullet_list(self._planning.describe_waypoint(stop) for stop in self._shown)

    def _add(self) -> None:
        self._planning.add_waypoint(self.approach.value / 1e3, self.retract.value / 1e3, _OPENINGS[self.opening.value])


class KeepPanel:
    """Saves the planned motion as a file, and copies it as a program and as shell commands."""

    def __init__(self, gui: viser.GuiApi, session: Session, planning: Planning) -> None:
        self._session, self._planning = session, planning
        self._shown_copy: tuple[object, object] = None, None
        self.save = gui.add_button_group("Save motion", _FORMS, visible=False)
        self.copies = gui.add_html("", visible=False)
        self.changes: Changes = Changes()
        self.save.on_click(self._save)

    def show(self) -> None:
        """Show the buttons to save and copy the motion, if there is one."""
        planning, shown = self._planning, self._planning.shown
        motion = None if shown is None or not planning.on else shown.motion
        self.save.visible = self.copies.visible = motion is not None
        if shown is None or motion is None or self._shown_copy == (shown, self.changes):
            return
        self._shown_copy = shown, self.changes
        robot, world, legs, settings = self._session.robot, self._session.world.snapshot(), shown.legs, planning.settings
        changes = [f"robot = {self.changes.as_expression()}"] if self.changes.describe() else []
        program, commands = as_program(robot, changes, world, legs, settings), as_commands(robot, world, legs, settings)
        self.copies.content = copy_button("", "Copy as Python", program) + copy_button("", "Copy as a command", commands)

    def _save(self, event: viser.GuiEvent) -> None:
        shown = self._planning.shown
        if event.client is not None and shown is not None and shown.motion is not None:
            with refusals_shown(event.client, "The motion was not saved"):
                ending = event.target.value.lower()
                name = f"{self._session.robot.name}_motion.{ending}"
                event.client.send_file_download(name, motion_file(shown.motion, ending), save_immediately=True)


class PlanPanel:
    """The tab Plan. ``on_event`` is called after each event."""

    def __init__(self, server: viser.ViserServer, session: Session, arm: Arm, on_event: Callable[[], None]) -> None:
        size = arm.extent.radius
        self._session, self._on_event, self.planning = session, on_event, Planning(session)
        self._known = configurations_of(session.robot)
        self.handles = Handles(server.scene, "/goal", 0.25 * size, on_event, visible=False)
        self.ghost = Ghost(server, arm, "/plan/ghost")
        self.mark = server.scene.add_icosphere("/goal/mark", 0.03 * size, UNKNOWN, visible=False, cast_shadow=False)
        nothing = np.zeros((1, 2, 3))
        self.line = server.scene.add_line_segments("/plan/line", nothing, TRAIL, thickness=0.008 * size, visible=False)
        gui = server.gui
        refusal = session.unchecked
        gui.add_html(small_text(_WHAT))
        self.begin = gui.add_button("Plan a motion", disabled=bool(refusal), hint=refusal or None)
        self.sentence = gui.add_html(small_text(refusal) if refusal else "")
        self.known = gui.add_button_group("Plan to", tuple(self._known), visible=False)
        self.pose = HandPose(gui, self.planning, on_event, "Goal", visible=False)
        self.play = gui.add_button(_PLAY, hint="Move the arm along the plan", visible=False)
        self.along = gui.add_slider("Along the plan", min=0.0, max=1.0, step=0.001, initial_value=0.0, visible=False)
        self.here = gui.add_button("Start here", hint="Plan from where the arm is now", visible=False)
        self.smooth = gui.add_checkbox(
            "Limit the jerk", initial_value=False, hint=f"At most {JERK:g} rad/s³ or m/s³ in every joint", visible=False
        )
        self.upright = gui.add_checkbox(
            "Keep upright",
            initial_value=False,
            hint=f"The direction of the hand that points up at the start stays within {np.degrees(TILT):.0f}° of vertical",
            visible=False,
        )
        self.on_line = gui.add_checkbox(
            "Keep on the line",
            initial_value=False,
            hint=f"The hand stays within {ASIDE * 1e3:g} mm of the straight line to the goal",
            visible=False,
        )
        with gui.add_folder("Held joints", expand_by_default=False, visible=False) as self.held:
            names = (name for name in session.robot.joint_names if name not in session.held)
            self.holds = {name: gui.add_checkbox(f"Hold {name}", initial_value=False, hint=_HOLD_HINT) for name in names}
        self.ways = WayPanel(gui, self.planning, self._do)
        self.kept = KeepPanel(gui, session, self.planning)
        self.end = gui.add_button("End planning", color="gray", visible=False)
        self.bands = Bands(server.scene, size)
        self.plots = Plots(gui, session.robot, lambda: self._do(lambda: None))
        self._last, self._acted = time.perf_counter(), False
        self._noted_goals, self._was_on = self.planning.goals, False  # at the last call of ``note_goals``
        for button, on in ((self.begin, True), (self.end, False)):
            button.on_click(lambda _, on=on: self._do(lambda: self.planning.turn(on=on)))
        self.known.on_click(lambda event: self._do(lambda: self.planning.send_configuration(self._known[event.target.value])))
        self.smooth.on_update(lambda _: self._do(self._limit_jerk))
        self.upright.on_update(lambda _: self._do(self._keep))
        self.on_line.on_update(lambda _: self._do(self._keep))
        for box in self.holds.values():
            box.on_update(lambda _: self._do(self._hold))
        self.play.on_click(lambda _: self._do(self.planning.play))
        self.here.on_click(lambda _: self._do(self.planning.start_here))
        self.along.on_update(self._scrub)

    @property
    def moving(self) -> bool:
        """Whether the arm moves along a plan."""
        return self.planning.playing

    def apply_input(self) -> bool:
        """Plan and move the arm as a person has asked. Returns whether the content of the tab has changed."""
        planning = self.planning
        now = time.perf_counter()
        seconds, self._last = min(now - self._last, _LONGEST_FRAME), now
        self.handles.pop_released()
        if planning.on:
            self.pose.apply_input()
            if self.handles.pop_moved():
                planning.send(self.handles.pose)
        acted, self._acted = self._acted, False
        return planning.frame(seconds) or acted

    def note_goals(self, history: SceneHistory) -> None:
        """Add a change of the goal or of the waypoints to the undo history."""
        before, now, went_on = self._noted_goals, self.planning.goals, self.planning.on and self._was_on
        self._was_on = self.planning.on
        if self.handles.dragged or (before[0] is now[0] and before[1] is now[1]):
            return
        self._noted_goals = now
        if went_on:
            history.add_acts(partial(self._set_goals, before), partial(self._set_goals, now))

    def _set_goals(self, goals: Goals) -> tuple[str, ...]:
        self.planning.goals = self._noted_goals = goals
        self._acted = True
        return ()

    def show(self, *, handled: bool = True) -> None:
        """Show the goal, the path, the status and the position along it. handled: whether the goal may have handles."""
        planning, shown = self.planning, self.planning.shown
        fields = (
            self.known,
            self.play,
            self.along,
            self.here,
            self.smooth,
            self.upright,
            self.on_line,
            self.held,
            self.ways.folder,
        )
        for element in (*fields, self.mark, self.end):
            element.visible = planning.on
        self.begin.visible = not planning.on
        self.handles.show(visible=planning.on and handled)
        self.ways.show()
        self.kept.show()
        motion = None if shown is None else shown.motion
        self.play.disabled = self.along.disabled = motion is None
        self.pose.show(visible=planning.on)
        if planning.on:
            self.handles.put(planning.hand_pose)
            color = UNKNOWN if shown is None else GREEN if motion is not None else RED
            paint(self.mark, color, None if is_in_the_way(color) else HOLLOW)
            self.sentence.content = status_line(planning.sentence, color)
        elif not self._session.unchecked:
            self.sentence.content = ""
        self.play.label = _PAUSE if planning.playing else _PLAY
        self.along.value = round(planning.share, 3)
        end = shown.end if shown is not None and planning.on else None
        self.ghost.show(end, GREEN if motion is not None else RED, self._session.q)
        self.plots.show(_NO_CURVES if shown is None or not planning.on else shown.curves)
        self.line.visible = motion is not None
        if shown is not None and motion is not None:
            self.line.points = np.stack([shown.line[:-1], shown.line[1:]], axis=1).astype(np.float32)

        kept = shown.kept_line if shown is not None and planning.on else None
        self.bands.show_line(kept, GREEN if motion is not None else RED)
        self.bands.show_tilt(self._session.hand_pose[:3, 3] if planning.on and planning.upright else None)

    def _keep(self) -> None:
        self.planning.upright, self.planning.on_line = self.upright.value, self.on_line.value

    def _hold(self) -> None:
        self.planning.held = tuple(name for name, box in self.holds.items() if box.value)

    def _limit_jerk(self) -> None:
        self.planning.jerk = JERK if self.smooth.value else None

    def _do(self, act: Callable[[], object]) -> None:
        with self._session.lock:
            act()
            self._acted = True
        self._on_event()

    async def _scrub(self, event: viser.GuiEvent) -> None:
        if event.client is not None:  # moved by a person, not by ``show``
            self._do(lambda: self.planning.scrub(self.along.value))
