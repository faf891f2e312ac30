"""Shows the hand: handles, a mark (red if it cannot follow, orange if it stops before a collision), text."""

from collections.abc import Callable

import viser

from ulna.robot import Robot
from ulna.viewer.html import marked
from ulna.viewer.nodes import Handles
from ulna.viewer.palette import GREEN, RED, STOPPED
from ulna.viewer.session.session import Session
from ulna.viewer.typed_fields import HandPose

_RESTING = (120, 128, 138)


class HandPanel:
    """Pulls the hand of a session to its handles. ``moved`` is called after each event. ``size`` is that of the robot [m]."""

    def __init__(self, server: viser.ViserServer, session: Session, size: float, moved: Callable[[], None]) -> None:
        self._session, self._moved = session, moved
        self.handles = Handles(server.scene, "/hand", 0.25 * size, moved)
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
            hint=session.unchecked or "The hand stops rather than touch the obstacles or the robot itself",
        )
        self.pose = HandPose(gui, session, moved)
        self.status = gui.add_html("")
        self._shown = session.link
        self.link.on_update(self._choose)
        self.avoiding.on_update(self._avoid)

    def take(self) -> None:
        """Pull the hand to where a person has dragged the handles, or release it."""
        self.pose.take()
        released = self.handles.take_release()  # read first: the last move comes before the end of a drag
        if self.handles.take():
            self._session.pull(self.handles.pose)
        if released:
            self._session.let_go()

    def show(self) -> None:
        """Show the state of the hand; while it is not pulled, the handles are moved to it."""
        session, trouble = self._session, self._session.trouble or self._session.missed
        pulled = session.target is not None
        if not pulled:
            self.handles.put(session.hand_pose)
        color = STOPPED if session.stopped else RED if trouble else GREEN if pulled else _RESTING
        words = trouble or (
            "the hand waits for the compiler"
            if session.waiting
            else "the hand is on its way"
            if session.moving
            else "the hand follows"
            if pulled
            else "drag the handles to move the hand"
        )
        label = "stopped" if session.stopped else trouble.partition(":")[0]
        self.mark.color, self.reason.text, self.reason.visible = color, label, bool(session.trouble)
        self.status.content = marked(words, color, filled=bool(trouble))
        self.pose.show()
        if session.link != self._shown:  # otherwise a person has chosen another link, which the session does not have yet
            self._shown = self.link.value = session.link

    def _choose(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._session.link = self.link.value
            self._moved()

    def _avoid(self, _: viser.GuiEvent) -> None:
        self._session.avoiding = self.avoiding.value
        self._moved()


def _choices(robot: Robot) -> list[str]:
    """Every link that a joint moves, the leaves first; the base if there is none."""
    moved = [name for name in robot.link_names if robot.tree.link_row[name] >= 0]
    return [name for name in moved if name in robot.tree.leaves] + [name for name in moved if name not in robot.tree.leaves] or [
        robot.base
    ]
