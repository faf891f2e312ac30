"""Shows the manipulability ellipsoid in the scene and the singular values in the panel. Used by ``view``."""

import numpy as np
import viser

from ulna.description.pose import quaternion_from_matrix
from ulna.viewer.html import mobility_html
from ulna.viewer.session.ellipsoid import mobility
from ulna.viewer.session.session import Session

COLOR = (124, 92, 200)
_NAME = "the manipulability"
_SECONDS = 0.25  # the half axes are the distances that the link moves in this time [s]
_THINNEST = 1e-3  # [m] so that a flat ellipsoid is drawn as a disc


class EllipsoidPanel:
    """A checkbox, which is off at first, the ellipsoid, and the singular values."""

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        self._session = session
        self.node = server.scene.add_icosphere("/ellipsoid", 1.0, COLOR, opacity=0.35, visible=False, cast_shadow=False)
        self.on = server.gui.add_checkbox(
            "Manipulability",
            initial_value=False,
            hint="The hand's linear velocities for joint velocities of norm 1: 0.25 m of a half axis are 1 m/s",
        )
        self.numbers = server.gui.add_html("", visible=False)
        self.on.on_update(lambda _: self.show())

    def show(self) -> None:
        """Draw it at the hand, if the checkbox is on."""
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
