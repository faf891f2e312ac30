"""Shows the chosen link, and lets a person change its contacts, its joint's limits and its attached objects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from ulna.collision.attached import Attached
from ulna.description.pose import rpy_from_matrix
from ulna.description.robot_description import Joint, JointType
from ulna.errors import count_of
from ulna.robot import Robot
from ulna.viewer.html import facts
from ulna.viewer.session.changes import QUANTITIES, limits_of
from ulna.viewer.session.session import Session
from ulna.viewer.typed_fields import TypedFields, refusals_shown

_NONE = "none"
_OF_ONE = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)
_LABELS = "Lower limit", "Upper limit", "Velocity limit", "Acceleration limit"
_PLURALS = {"box": "boxes", "mesh": "meshes", "convexmesh": "convex meshes"}
Act = Callable[[str], object]


class LinkPanel:
    """The folder of one link; hidden while none is chosen.

    Args:
        gui: The panel, to which the folder is added.
        session: The session of the robot.
        set_limit: Called with a joint, a quantity and its new limit.
        set_mass: Called with a link and the new mass of its attached object [kg].
        acts: For each button, a function that gives its label for a link (empty to hide the button), and its action on the link.
        on_event: Called when another link is chosen, or a value was typed.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        set_limit: Callable[[str, str, float], object],
        set_mass: Callable[[str, float], object],
        acts: tuple[tuple[Callable[[str], str], Act], ...],
        on_event: Callable[[], None],
    ) -> None:
        self._session, self._set_limit, self._set_mass, self._on_event, self.chosen = session, set_limit, set_mass, on_event, ""
        self._acts = acts
        robot = session.robot
        self._joints = {joint.child: joint for joint in robot.description.joints}
        with gui.add_folder("Link", visible=False) as self.folder:
            self.facts = gui.add_html("")
            self.buttons = [gui.add_button(" ", visible=False) for _ in acts]
            self.mass = gui.add_number("Mass", 0.0, min=0.0, step=0.001, visible=False, hint="Counts in torques; 0 for none")
            self.close = gui.add_button("Close", color="gray")
            with gui.add_folder("Limits of its joint", expand_by_default=False) as self.limits:
                hint = "In rad or m, and s; 0 means no velocity or acceleration limit"
                self.fields: dict[str, Any] = {
                    quantity: gui.add_number(label, 0.0, step=0.001, visible=False, hint=hint)
                    for quantity, label in zip(QUANTITIES, _LABELS, strict=True)
                }
        self._typed = TypedFields((*self.fields.values(), self.mass), on_event, lambda: self.chosen)
        for button, (_, act) in zip(self.buttons, acts, strict=True):
            button.on_click(lambda event, act=act: self._do(act, event.client))
        self.close.on_click(lambda _: self.choose(""))

    def add_choice(self, gui: viser.GuiApi) -> None:
        """Add a list of the links at the present place of the panel, for people without a pointer."""
        names = (_NONE, *self._session.robot.link_names)
        self.choice = gui.add_dropdown("Link", names, initial_value=_NONE, hint="Or click it in the scene")
        self.choice.on_update(lambda event: None if event.client is None else self.choose(self.choice.value.replace(_NONE, "")))

    def choose(self, link: str) -> None:
        """Choose a link by its name; empty for none. The next ``show`` shows it."""
        self.chosen = link
        self._on_event()

    def apply_input(self) -> bool:
        """Apply the typed values. Returns whether there were any."""
        typed = self._typed.pop_values()
        for edit in typed:
            joint = self._joints.get(edit.chosen)
            quantity = next((name for name, field in self.fields.items() if field is edit.field), None)
            with refusals_shown(edit.client, "Not changed"):
                if quantity is None:
                    self._set_mass(edit.chosen, edit.value)
                elif joint is not None:
                    is_none = edit.value == 0.0 and quantity in QUANTITIES[2:]
                    self._set_limit(joint.name, quantity, np.inf if is_none else edit.value)
        return bool(typed)

    def show(self) -> None:
        """Show the present values of the chosen link."""
        session, robot, link = self._session, self._session.robot, self.chosen
        self.folder.visible = bool(link)
        self.choice.value = link or _NONE
        if not link:
            return
        self.folder.label = link
        joint = self._joints.get(link)
        self.facts.content = facts(_facts_of(robot, session.q, link, joint))
        held = held_by(robot, link)
        self.mass.visible = held is not None
        if held is not None:
            self.mass.label = f"Mass of {held.name} [kg]"
            self._typed.write(self.mass, 0.0 if held.inertia is None else round(held.inertia.mass, 4))
        column = robot.joint_slices[robot.joint_names.index(joint.name)].start if _is_limited(robot, joint) else None  # type: ignore[union-attr]
        limits = {} if column is None else limits_of(robot, column)
        self.limits.visible = bool(limits)
        for quantity, field in self.fields.items():
            value = limits.get(quantity, np.nan)
            field.visible = bool(np.isfinite(value)) or bool(quantity in QUANTITIES[2:] and np.isposinf(value))
            if field.visible:
                self._typed.write(field, round(value, 4) if np.isfinite(value) else 0.0)
        for button, (label, _) in zip(self.buttons, self._acts, strict=True):
            words = label(link)
            button.visible = bool(words)
            button.label = words or " "

    def _do(self, act: Act, client: viser.ClientHandle | None) -> None:
        with refusals_shown(client, "Not changed"):
            if self.chosen:
                act(self.chosen)
        self._on_event()


def held_by(robot: Robot, link: str) -> Attached | None:
    """The last object attached to a link; None if there is none."""
    return next((one for one in reversed(robot.attached) if one.link == link), None)


def _is_limited(robot: Robot, joint: Joint | None) -> bool:
    return joint is not None and joint.type in _OF_ONE and joint.name in robot.joint_names


def _facts_of(robot: Robot, q: Any, link: str, joint: Joint | None) -> list[tuple[str, str]]:
    """The facts about a link at q, as pairs of a name and a value."""
    T = robot.forward_kinematics(q, link=link)
    own = next(one for one in robot.description.links if one.name == link)
    kinds = Counter(type(body.shape).__name__.lower() for body in own.collisions)
    shapes = ", ".join(
        count_of(n, kind.replace("convexmesh", "convex mesh"), _PLURALS.get(kind, "")) for kind, n in kinds.items()
    )
    held = ", ".join(one.name for one in robot.attached if one.link == link)
    found = [
        ("moved by", "nothing" if joint is None else f"{joint.name} ({joint.type})"),
        ("xyz [m]", " ".join(f"{value + 0.0:.4f}" for value in T[:3, 3].round(4))),
        ("rpy [rad]", " ".join(f"{value + 0.0:.4f}" for value in rpy_from_matrix(T).round(4))),
        ("shapes", shapes or "none"),
    ]
    return [*found, ("holds", held)] if held else found
