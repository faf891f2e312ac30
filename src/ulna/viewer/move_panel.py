"""The tab Move: drags the hand, and sets q to home, a named configuration or one of a file.

The hand's mark is red if the hand cannot follow, and orange if it stops before a collision.
"""

from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.columns import Head, columns_of, fields_of, head_of, number_of, text_of
from ulna.errors import InputError, count_of
from ulna.robot import Robot
from ulna.robot.joint_columns import joint_columns
from ulna.viewer.html import copy_button, status_line
from ulna.viewer.nodes import Handles, paint
from ulna.viewer.palette import GREEN, HOLLOW, RED, STOPPED, is_in_the_way
from ulna.viewer.session.first_configuration import configurations_of
from ulna.viewer.session.session import Session
from ulna.viewer.typed_fields import HandPose, refusals_shown

_RESTING = (120, 128, 138)
_MAX_BYTES = 1_000_000  # of a file


class HandPanel:
    """Pulls the hand of a session to its handles. ``on_event`` is called after each event. size: of the robot [m]."""

    def __init__(self, server: viser.ViserServer, session: Session, size: float, on_event: Callable[[], None]) -> None:
        self._session, self._on_event = session, on_event
        self.handles = Handles(server.scene, "/hand", 0.25 * size, on_event)
        self.mark = server.scene.add_icosphere("/hand/mark", 0.03 * size, _RESTING, cast_shadow=False)
        self.reason = server.scene.add_label(
            "/hand/reason", "", position=(0.0, 0.0, 0.0), anchor="bottom-center", visible=False, font_screen_scale=1.1
        )
        gui = server.gui
        self.link = gui.add_dropdown(
            "Hand", _choices(session.robot), initial_value=session.link, hint="The link that the handles pull"
        )
        self.avoiding = gui.add_checkbox(
            "Avoid collisions",
            initial_value=False,
            disabled=bool(session.unchecked),
            hint=session.unchecked or "The hand stops before the arm touches an obstacle or itself",
        )
        self.pose = HandPose(gui, session, on_event)
        self.status = gui.add_html("")
        self._shown = session.link
        self.link.on_update(self._choose)
        self.avoiding.on_update(self._avoid)

    def apply_input(self) -> None:
        """Pull the hand to the pose of the dragged handles, or release it."""
        self.pose.apply_input()
        released = self.handles.pop_released()  # before ``pop_moved``, since the last move of a drag comes before its end
        if self.handles.pop_moved():
            self._session.pull(self.handles.pose)
        if released:
            self._session.release()

    def show(self) -> None:
        """Show the state of the hand. While it is not pulled, the handles move to it."""
        session, trouble = self._session, self._session.trouble or self._session.send_failure
        pulled = session.target is not None
        if not pulled:
            self.handles.put(session.hand_pose)
        color = STOPPED if session.stopped else RED if trouble else GREEN if pulled else _RESTING
        words = trouble or (
            "waiting for the motion of the hand to compile"
            if session.waiting
            else "the hand is moving to its target"
            if session.moving
            else "the hand follows"
            if pulled
            else "drag the handles to move the hand"
        )
        label = "stopped" if session.stopped else trouble.partition(":")[0]
        paint(self.mark, color, None if is_in_the_way(color) else HOLLOW)
        self.reason.text, self.reason.visible = label, bool(session.trouble)
        self.status.content = status_line(words, color)
        self.pose.show()
        if session.link != self._shown:  # the program chose it; a choice of a person reaches the session later
            self._shown = self.link.value = session.link

    def _choose(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._session.link = self.link.value
            self._on_event()

    def _avoid(self, _: viser.GuiEvent) -> None:
        self._session.avoiding = self.avoiding.value
        self._on_event()


def _choices(robot: Robot) -> list[str]:
    """The links that a joint moves, the leaves first; the base if there are none."""
    moving = [name for name in robot.link_names if robot.tree.link_row[name] >= 0]
    leaves = [name for name in moving if name in robot.tree.leaves]
    return [*leaves, *(name for name in moving if name not in leaves)] or [robot.base]


class ConfigurationPanel:
    """Buttons of named configurations, and q as text. ``on_event`` is called when q was changed."""

    def __init__(self, gui: viser.GuiApi, session: Session, on_event: Callable[[], None]) -> None:
        self._session, self._on_event = session, on_event
        self._known = configurations_of(session.robot)
        self.names = gui.add_button_group("Go to", tuple(self._known))
        with gui.add_folder("Copy, save, load q", expand_by_default=False):
            self.text = gui.add_html("")
            self.save = gui.add_button("Save q", hint="Download q as a .csv file of one row")
            self.load = gui.add_upload_button("Load q", hint="Go to the first row of a .csv file", mime_type="text/csv")
        self.names.on_click(lambda event: self._go(self._known[event.target.value]))
        self.save.on_click(self._download)
        self.load.on_upload(self._upload)
        self._shown = b""

    def show(self, q: NDArray[np.float64]) -> None:
        """Show q, shape (n_dof,), as text that can be copied."""
        if q.tobytes() != self._shown:
            self._shown, words = q.tobytes(), as_text(q)
            self.text.content = copy_button(", ".join(f"{value:.4g}" for value in q), "Copy q", words)

    def _go(self, q: NDArray[np.float64]) -> None:
        self._session.q = q
        self._on_event()

    def _download(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            content = f"{as_text(self._session.q)}\n".encode()
            event.client.send_file_download(f"{self._session.robot.name}_q.csv", content, save_immediately=True)

    def _upload(self, event: viser.GuiEvent) -> None:
        with refusals_shown(event.client, "q was not loaded"):
            self._go(first_row(self.load.value.content, self._session.robot))


def as_text(q: NDArray[np.float64]) -> str:
    """The text of q, shape (n_dof,), with all digits, as the option ``--q`` reads it."""
    return ", ".join(repr(float(value)) for value in q)


def first_row(content: bytes, robot: Robot) -> NDArray[np.float64]:
    """The first row of a .csv file as q, shape (n_dof,). Columns with names are matched to the joints."""
    lines = text_of(content[:_MAX_BYTES]).splitlines()
    joints, n_dof = joint_columns(robot), robot.n_dof
    try:
        head = head_of(lines, joints.known) or Head(None, 0, None, decimal_comma=False, first=0)
        columns, units = (range(head.n_columns), [1.0]) if head.names is None else columns_of(head.names, joints)
        fields = fields_of(lines[head.first], head.separator) if head.n_columns else []
        q = np.array([number_of(fields[column], head) for column in columns]) * units
    except (ValueError, IndexError) as error:
        raise InputError("q", f"{str(error)[:200]}; comma-separated numbers are expected") from None
    if len(q) != n_dof:
        expected = f"{n_dof} comma-separated {'number is' if n_dof == 1 else 'numbers are'} expected"
        raise InputError("q", f"{count_of(len(q), 'number')}, but {expected}")
    return q
