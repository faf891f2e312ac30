"""Draws the demo on a page: the arm, its boxes, the movable box with its handles, the light with its text."""

from collections.abc import Callable

import viser

from ulna.collision.report import Report
from ulna.demo.drawing import WORD_POSITION
from ulna.demo.scenario import BOX, BOX_NAME, LIGHT, LIGHT_POSITION, Demo, light_color, light_word
from ulna.viewer.arm import Arm
from ulna.viewer.nodes import Handles
from ulna.viewer.palette import MOVABLE
from ulna.viewer.stage import stand_back_where_narrow


class DemoScene:
    """The scene. ``arm.move_to`` and ``draw_report`` update it in each frame.

    Args:
        server: The page.
        demo: The demo that is drawn.
        moved: Called when a person has moved the box's handles.
    """

    def __init__(self, server: viser.ViserServer, demo: Demo, moved: Callable[[], None]) -> None:
        scene = server.scene
        scene.set_up_direction("+z")
        scene.add_grid("/floor", width=2.4, height=2.4, cell_size=0.1, section_size=0.6, cell_color=(225, 228, 232))
        server.initial_camera.position = (1.75, -1.45, 1.0)
        server.initial_camera.look_at = (0.2, 0.0, 0.36)
        server.initial_camera.fov = 0.7
        stand_back_where_narrow(server, 0.9)
        self.arm = Arm(server, demo.robot, "/arm")
        self.light = scene.add_cylinder("/light", LIGHT.radius, LIGHT.length, light_color(None), position=LIGHT_POSITION)
        self.word = scene.add_label(
            "/light/word", light_word(None), position=WORD_POSITION, anchor="top-center", font_screen_scale=1.3
        )
        self.handles = Handles(scene, "/movable", 0.22, moved)
        self.handles.put(demo.world.pose(BOX_NAME))
        scene.add_box("/movable/box", MOVABLE, BOX.extents)

    def draw_report(self, report: Report | None) -> None:
        """Set the colour of the light, its text, and the boxes that touch; grey while the report is not known."""
        if self.word.text != light_word(report):
            self.light.color = light_color(report)
            self.word.text = light_word(report)
            self.arm.mark_touching(report.touching if report is not None else ())
