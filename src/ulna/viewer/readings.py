"""Shows readings of the robot and of the page.

These are the nearest pair, the manipulability ellipsoid and singular values, running compilations, and errors of frames.
"""

import html

import numpy as np
import viser
from trimesh.geometry import align_vectors

from ulna.description.pose import quaternion_from_matrix
from ulna.viewer.html import STYLE, mobility_html, small_text, status_line
from ulna.viewer.palette import GREEN, RED, SLATE, UNKNOWN
from ulna.viewer.session.clearance import Clearance
from ulna.viewer.session.ellipsoid import mobility
from ulna.viewer.session.session import Session

COLOR = (124, 92, 200)
_NAME = "the manipulability"
_SECONDS = 0.25  # [s] a half axis is drawn as long as the path of the link in this time
_THINNEST = 1e-3  # [m] minimum half axis, so that a flat ellipsoid is drawn as a disc


class ClearancePanel:
    """The text at the top of the panel, and the line between the nearest points. size: of the robot [m]."""

    def __init__(self, server: viser.ViserServer, size: float) -> None:
        self.state = server.gui.add_html(status_line("checking ...", UNKNOWN))
        self.nearest = server.gui.add_html("")
        point = np.zeros(3)
        self.line = server.scene.add_cylinder("/nearest/line", 0.004 * size, 1.0, SLATE, visible=False, cast_shadow=False)
        self.ends = [
            server.scene.add_icosphere(f"/nearest/end{k}", 0.012 * size, SLATE, position=point, visible=False, cast_shadow=False)
            for k in (0, 1)
        ]
        self.label = server.scene.add_label("/nearest/label", "", visible=False, anchor="bottom-left", font_screen_scale=1.2)

    def show(self, clearance: Clearance) -> None:
        """Show the contacts and the nearest pair."""
        color = {"free": GREEN, "collision": RED}.get(clearance.state, UNKNOWN)
        pair = clearance.nearest
        words = clearance.refusal if pair is None else f"{clearance.distance} between {clearance.nearest_text}"
        self.state.content = status_line(str(clearance), color)
        self.nearest.content = small_text(words) if words else ""
        for node in (self.line, self.label, *self.ends):
            node.visible = pair is not None
        if pair is None:
            return
        middle, between = (pair.witness_a + pair.witness_b) / 2, pair.witness_b - pair.witness_a
        length = float(np.linalg.norm(between))
        turn = align_vectors((0.0, 0.0, 1.0), between if length > 0.0 else pair.normal)
        self.line.position, self.line.wxyz = middle, quaternion_from_matrix(turn)
        self.line.scale = (1.0, 1.0, max(length, 1e-6))
        self.line.color = RED if pair.signed_distance <= 0 else SLATE
        for end, place in zip(self.ends, (pair.witness_a, pair.witness_b), strict=True):
            end.position = place
        self.label.position, self.label.text = middle, clearance.distance


class EllipsoidPanel:
    """A checkbox (off at first) that shows the manipulability ellipsoid and the singular values."""

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        self._session = session
        self.node = server.scene.add_icosphere("/ellipsoid", 1.0, COLOR, opacity=0.35, visible=False, cast_shadow=False)
        self.on = server.gui.add_checkbox(
            "Manipulability",
            initial_value=False,
            hint="Ellipsoid of the hand's linear velocities for joint velocities of norm 1; a half axis of 0.25 m means 1 m/s",
        )
        self.numbers = server.gui.add_html("", visible=False)
        self.on.on_update(lambda _: self.show())

    def show(self) -> None:
        """Draw the ellipsoid at the hand if the checkbox is on."""
        session, found = self._session, None
        if self.on.value:
            found = session.ask(_NAME, mobility, session.robot, session.q, session.link)
        self.node.visible = self.numbers.visible = found is not None
        if found is None:
            return
        self.node.position, self.node.wxyz = found.T[:3, 3], quaternion_from_matrix(found.T)
        x, y, z = np.maximum(_SECONDS * found.radii, _THINNEST).tolist()
        self.node.scale = (x, y, z)
        self.numbers.content = mobility_html(found)


class Notice:
    """A line of the panel, hidden while it is empty."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._element = gui.add_html("", visible=False)
        self._compiling: tuple[str, ...] = ()
        self._failure = ""

    @property
    def text(self) -> str:
        """The text of the line; empty if there is nothing to report."""
        if self._failure:
            return f"This picture is out of date: {self._failure}"
        if self._compiling:
            first, *rest = self._compiling
            more = f"; {len(rest)} more to come" if rest else ""
            return f"Compiling for this machine (once): {first}{more}"
        return ""

    def show_compiling(self, names: tuple[str, ...]) -> None:
        """Show the names of the running and waiting compilations."""
        self._compiling = names
        self._write()

    def show_failure(self, error: Exception | None) -> None:
        """Show the error of the last frame; None if it succeeded."""
        self._failure = "" if error is None else f"{type(error).__name__}: {error}"
        self._write()

    def _write(self) -> None:
        role = "alert" if self._failure else "log"
        self._element.content = f'<div role="{role}" style="{STYLE};font-size:0.85em">{html.escape(self.text)}</div>'
        self._element.visible = bool(self.text)
