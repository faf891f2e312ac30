"""Shows a slider for each entry of q with its holding torque, and a disabled slider for each mimic joint."""

from collections.abc import Callable, Sequence
from math import pi

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.robot import Robot
from ulna.viewer.html import load_bar
from ulna.viewer.session.loads import Load
from ulna.viewer.session.slides import Slide, slide_groups

_DIGITS, _DIGITS_OF_DEGREES = 3, 2  # decimals: milliradians, millimeters


class JointSliders:
    """Sliders in folders, one for each limb. ``on_event`` is called in the server's thread when a person moves one.

    Attributes:
        degrees: A checkbox: whether the sliders show angles in degrees.
        sliders: For each entry of q: its slide [rad or m] and its slider.
        bars: For each entry of q: its holding torque; hidden until ``show_loads`` has values.
    """

    def __init__(self, gui: viser.GuiApi, robot: Robot, on_event: Callable[[], None]) -> None:
        self._gui, self._on_event, self._q = gui, on_event, robot.home
        self._dirty: dict[int, float] = {}  # the entries of q that a person has set [rad or m]
        self._prefix = f"{robot.name}_"
        self.sliders: dict[int, tuple[Slide, viser.GuiSliderHandle]] = {}
        self.bars: dict[int, viser.GuiHtmlHandle] = {}
        self._followers: list[tuple[Slide, viser.GuiSliderHandle]] = []
        self._folders: list[viser.GuiFolderHandle] = []
        groups = slide_groups(robot)
        self.degrees = gui.add_checkbox("Joints in degrees", initial_value=False)
        self.degrees.on_update(lambda _: self._rescale())
        for group in groups:
            units = " or ".join(sorted({slide.unit for slide in group.slides}, reverse=True))
            title = "Joints" if len(groups) == 1 else group.name
            with gui.add_folder(f"{title} [{units}]", expand_by_default=len(groups) == 1) as folder:
                self.sliders |= {slide.column: (slide, self._add(slide)) for slide in group.slides}
                self._followers += [(slide, self._add(slide)) for slide in group.followers]
            self._folders.append(folder)

    def apply_input(self, q: NDArray[np.float64]) -> bool:
        """Write the values of moved sliders into q, within the limits. Returns whether a person has moved any."""
        dirty, self._dirty = self._dirty, {}
        for column, value in dirty.items():
            slide, _ = self.sliders[column]
            q[column] = min(max(value, slide.low), slide.high)
        return bool(dirty)

    def show(self, q: NDArray[np.float64]) -> None:
        """Set the sliders to q, shape (n_dof,), except sliders that a person has just moved."""
        self._q = q
        for slide, slider in (*self.sliders.values(), *self._followers):
            if slide.leader or slide.column not in self._dirty:
                slider.value = _rounded_within(slide.shown(q) * self._factor(slide), slider.min, slider.max)

    def show_loads(self, loads: Sequence[Load]) -> None:
        """Show the holding torque of each entry of q; hide the bars if ``loads`` is empty."""
        for column, bar in self.bars.items():
            bar.visible = bool(loads)
            if loads:
                bar.content = load_bar(self.sliders[column][0].name, loads[column])

    def relimit(self, robot: Robot) -> None:
        """Set the ranges to the limits of a robot with the same joints."""
        slides = {slide.column: slide for group in slide_groups(robot) for slide in group.slides}
        self.sliders = {column: (slides[column], slider) for column, (_, slider) in self.sliders.items()}
        for slide, slider in self.sliders.values():
            slider.min, slider.max, slider.hint = slide.low, slide.high, slide.hint
        self._rescale()

    def _factor(self, slide: Slide) -> float:
        """The factor from a position [rad or m] to the shown number."""
        return 180.0 / pi if slide.unit == "rad" and self.degrees.value else 1.0

    def _rescale(self) -> None:
        """Show the range of each slider in radians or degrees."""
        digits = _DIGITS_OF_DEGREES if self.degrees.value else _DIGITS
        for slide, slider in (*self.sliders.values(), *self._followers):
            if slide.unit == "rad":
                ends = slide.low, slide.high
                slider.min, slider.max = np.degrees(ends).round(digits).tolist() if self.degrees.value else ends
                slider.step = 10.0**-digits
        before, after = ("rad", "deg") if self.degrees.value else ("deg", "rad")
        for folder in self._folders:
            folder.label = (folder.label or "").replace(f"[{before}", f"[{after}")
        self.show(self._q)

    def _add(self, slide: Slide) -> viser.GuiSliderHandle:
        slider = self._gui.add_slider(
            slide.name.removeprefix(self._prefix),
            min=slide.low,
            max=slide.high,
            step=10.0**-_DIGITS,
            initial_value=_rounded_within(slide.shown(self._q), slide.low, slide.high),
            disabled=bool(slide.leader),
            hint=slide.hint,
        )

        async def listen(event: viser.GuiEvent) -> None:
            if event.client is not None:  # moved by a person, not by ``show``
                self._dirty[slide.column] = slider.value / self._factor(slide)
                self._on_event()

        if not slide.leader:
            slider.on_update(listen)
            self.bars[slide.column] = self._gui.add_html("", visible=False)
        return slider


def _rounded_within(value: float, low: float, high: float) -> float:
    """A value rounded to the digits of a slider, and clipped to its range."""
    return min(max(round(value, _DIGITS), low), high)
