"""Serves the demo's page: draws the scene, plays the trajectory, and reads the handles and sliders."""

import os
import time
import warnings
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import viser
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.demo.drawing import WORD_POSITION
from ulna.demo.player import Player
from ulna.demo.record_button import RecordButton
from ulna.demo.scenario import BOX, BOX_NAME, BOX_START, LIGHT, LIGHT_POSITION, Demo, light_color, light_word
from ulna.description.pose import pose
from ulna.viewer.arm import REAL_ARM, Arm
from ulna.viewer.compiler import Compiler
from ulna.viewer.html import lead, small_text, status_line
from ulna.viewer.joint_sliders import JointSliders
from ulna.viewer.loop import Loop
from ulna.viewer.nodes import Handles
from ulna.viewer.page import HOST, Page
from ulna.viewer.palette import GREEN, MOVABLE, RED, UNKNOWN
from ulna.viewer.readings import Notice
from ulna.viewer.stage import add_floor, add_light, stand_back_where_narrow

FRAMES_PER_SECOND = 30.0
STOP_WITHIN_S = 2.0
_WHAT = "Drag the orange box into the arm."
_MORE = (
    "The Panda repeats a trajectory, and the light says which of its twelve boxes touch. The box moves along the floor, with "
    "Shift up and down too. Press ? for the keys. This is a university assignment: hw2 in the repository."
)
_AROUND = "The arm moves between the corners of its trajectory by certified plans; it plans again if the box gets in its way"
_FOLLOW_S = 0.1  # [s], update interval of the sliders while the arm moves


def serve(
    demo: Demo,
    host: str = HOST,
    port: int = 8080,
    *,
    open_browser: bool = True,
    meanwhile: Callable[[], bool] = lambda: True,
) -> bool:
    """Show the demo until Ctrl-C; call ``meanwhile`` once the kernels are compiled, and end the page if it returns False.

    Returns the result of ``meanwhile``; True after an interruption.
    """
    app, passed = DemoApp(demo, host, port), True
    print(f"The Panda is at {app.url}  (Ctrl-C ends it)", flush=True)  # noqa: T201 - the address is the result
    try:
        with suppress(KeyboardInterrupt):
            if open_browser:
                app.page.open()
            app.wait_until_compiled()
            passed = meanwhile()
            if passed:
                app.wait()
    finally:
        warnings.simplefilter("ignore")  # open pages cause warnings when the server stops
        ended = app.stop()
    if not ended:
        os._exit(0 if passed else 1)  # a long compilation is running; a normal exit during it would abort
    return passed


class DemoApp:
    """A running demo: the server, its scene, its widgets and the thread that moves the arm."""

    def __init__(self, demo: Demo, host: str = HOST, port: int = 8080) -> None:
        self.demo = demo
        self.page = Page(host, port, title=f"{demo.robot.name} - Ulna demo")
        self.server, self.url = self.page.server, self.page.url
        self._loop = Loop("ulna-demo", self._frame, lambda: 1.0 / FRAMES_PER_SECOND, self._failed)
        self.compiler = Compiler(self._loop.wake)
        self.player = Player(demo, self, self.compiler.ask)
        self._last = self._followed = time.perf_counter()
        self._shown = self.player.q  # q shown by the sliders
        with self.page.ending_if_it_fails():
            self._build()
        self._loop.start()

    def _build(self) -> None:
        self.scene = DemoScene(self.server, self.demo, self._loop.wake)
        add_floor(self.page, -2e-3, 0.1, 9.0)
        self._add_widgets()
        self.player.move_to(self.player.q)

    def wait(self) -> None:
        """Wait for Ctrl-C."""
        self._loop.wait()

    def wait_until_compiled(self) -> None:
        """Wait until the collision check and the trajectory are compiled."""
        while not (self._loop.ended or (self.player.report is not None and not self.compiler.names)):
            time.sleep(0.05)

    def stop(self) -> bool:
        """End the loop and the server. Returns whether compilation has ended."""
        self._loop.stop(STOP_WITHIN_S)
        self.recording.close()
        self.compiler.stop(STOP_WITHIN_S)
        self.page.stop()
        return self.compiler.ended

    def set_configuration(self, q: NDArray[np.float64]) -> None:
        """Stop at q."""
        with self.player.lock, self.server.atomic():
            self.playing.value = False
            self.player.move_to(q)
            self._follow(self._last)

    def put_box(self, T_base_box: ArrayLike) -> None:
        """Put the box at a pose, shape (4, 4), unless it is being dragged."""
        with self.player.lock:
            self.scene.handles.put(np.asarray(T_base_box))
            self.player.drag(self.scene.handles.pose)

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Draw the arm at q, shape (n_dof,)."""
        self.scene.arm.move_to(q)

    def draw_report(self, report: Report | None) -> None:
        """Set the colors of the light and the boxes, and the text; gray while the check is compiled."""
        self.scene.draw_report(report)
        self.verdict.content = status_line(light_word(report), light_color(report))

    def _failed(self, error: Exception | None) -> None:
        self.notice.show_failure(error)  # the notice is created after the loop

    # ---- widgets ------------------------------------------------------------------------------------------------------

    def _add_widgets(self) -> None:
        gui = self.server.gui
        gui.add_html(lead(_WHAT) + small_text(_MORE))
        if self.scene.arm.missing:
            gui.add_html(small_text(REAL_ARM))
        self.verdict = gui.add_html(status_line(light_word(None), light_color(None)))
        self.notice = Notice(gui)
        self.avoiding = gui.add_checkbox("Plan around the box", initial_value=False, hint=_AROUND)
        self.avoiding.on_update(lambda _: self._avoid())
        self.way = gui.add_html("", visible=False)
        self.playing = gui.add_checkbox("Play", initial_value=True, hint="The arm repeats its trajectory")
        self.speed = gui.add_slider("Speed", min=0.0, max=3.0, step=0.1, initial_value=1.0, hint="1 is real time")
        self.show_boxes = gui.add_checkbox("Boxes", initial_value=True, hint="The twelve collision boxes of the arm")
        self.show_boxes.on_update(lambda _: self.scene.arm.show_solids(visible=self.show_boxes.value))
        self.page.add_dark_button()
        gui.add_button("Put the box back", hint="Move the box to its initial pose").on_click(
            lambda _: self.put_box(pose(BOX_START))
        )
        self.recording = RecordButton(self.server, self.player, lambda: self.show_boxes.value)
        self.joints = JointSliders(gui, self.demo.robot, self._loop.wake)

    # ---- motion --------------------------------------------------------------------------------------------------------

    def _frame(self) -> None:
        now = time.perf_counter()
        seconds, self._last = now - self._last, now
        with self.player.lock, self.server.atomic():
            if self.scene.handles.pop_moved():
                self.player.drag(self.scene.handles.pose)
            q = self.player.q.copy()
            if self.joints.apply_input(q):  # moving a slider stops the trajectory
                self.set_configuration(q)
            elif self.playing.value and self.speed.value > 0.0:
                self.player.advance(seconds * self.speed.value)
            if self.compiler.pop_finished() or self.player.report is None:
                self.player.check()
            self.notice.show_compiling(self.compiler.names)
            self._show_way()
            self._follow(now)
            self.recording.take(now)

    def _avoid(self) -> None:
        with self.player.lock:
            self.player.avoiding = self.avoiding.value
            self.player.around.begin()
        self._loop.wake()

    def _show_way(self) -> None:
        """Show whether a way around the box exists, while "Plan around the box" is on."""
        around = self.player.around
        self.way.visible = self.player.avoiding
        if self.player.avoiding:
            color = UNKNOWN if around.plan is None else GREEN if around.plan else RED
            self.way.content = status_line(around.sentence, color)

    def _follow(self, now: float) -> None:
        """Set the sliders to the arm's q; a number that is being typed in a tab is kept (``viewer.typed``)."""
        if self._shown is not self.player.q and (now - self._followed >= _FOLLOW_S or not self.playing.value):
            self._shown, self._followed = self.player.q, now
            self.joints.show(self.player.q)


class DemoScene:
    """The scene. ``arm.move_to`` and ``draw_report`` update it in each frame."""

    def __init__(self, server: viser.ViserServer, demo: Demo, moved: Callable[[], None]) -> None:
        scene = server.scene
        scene.set_up_direction("+z")
        server.initial_camera.position = (1.75, -1.45, 1.0)
        server.initial_camera.look_at = (0.2, 0.0, 0.36)
        server.initial_camera.fov = 0.7
        stand_back_where_narrow(server, 0.9)
        self.arm = Arm(server, demo.robot, "/arm")
        add_light(scene, self.arm.extent.center, self.arm.extent.radius)
        self.light = scene.add_cylinder("/light", LIGHT.radius, LIGHT.length, light_color(None), position=LIGHT_POSITION)
        self.word = scene.add_label(
            "/light/word", light_word(None), position=WORD_POSITION, anchor="top-center", font_screen_scale=1.3
        )
        self.handles = Handles(scene, "/movable", 0.22, moved)
        self.handles.put(demo.world.pose(BOX_NAME))
        self.handles.make_draggable(scene.add_box("/movable/box", MOVABLE, BOX.extents))

    def draw_report(self, report: Report | None) -> None:
        """Set the color of the light, its text, and the boxes in contact; gray while the report is unknown."""
        if self.word.text != light_word(report):
            self.light.color = light_color(report)
            self.word.text = light_word(report)
            self.arm.mark_touching(report.touching if report is not None else ())
