"""Shows and hides visuals, collision shapes, frames and names; and shows the tree."""

import viser

from ulna.viewer.arm import Arm
from ulna.viewer.html import listed, plain, tree_html

REAL_ARM = "Drawn as plain tubes. For the real arm: pip install example-robot-data (131 MB, 431 MB unpacked), and start again."


class VisibilityPanel:
    """Checkboxes, the tree, and the missing meshes."""

    def __init__(self, gui: viser.GuiApi, arm: Arm, *, solids: bool) -> None:
        self.looks = gui.add_checkbox("Visuals", initial_value=True, hint="What the robot looks like")
        self.solids = gui.add_checkbox(
            "Collision shapes", initial_value=solids, disabled=not arm.solids, hint="What it collides as"
        )
        self.frames = gui.add_checkbox("Link frames", initial_value=False, hint="x red, y green, z blue")
        self.names = gui.add_checkbox("Link names", initial_value=False)
        self.looks.on_update(lambda _: arm.show_looks(visible=self.looks.value))
        self.solids.on_update(lambda _: arm.show_solids(visible=self.solids.value))
        self.frames.on_update(lambda _: arm.show_frames(visible=self.frames.value))
        self.names.on_update(lambda _: arm.show_names(visible=self.names.value))
        arm.show_solids(visible=solids)
        if arm.missing:
            with gui.add_folder(f"Missing meshes ({len(arm.missing)})", expand_by_default=False):
                if arm.robot.name == "panda":
                    gui.add_html(plain(REAL_ARM))
                gui.add_html(listed(arm.missing))
        with gui.add_folder(f"Tree ({len(arm.robot.link_names)} links)", expand_by_default=False):
            gui.add_html(tree_html(arm.robot))
