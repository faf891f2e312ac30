"""Shows the joints: a slider for each entry of q, and a disabled one for each mimic joint."""

from collections.abc import Callable
from math import pi

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.robot import Robot
from ulna.viewer.session.slides import Follower, Slide, SlideGroup, slide_groups

_DIGITS, _DIGITS_OF_DEGREES = 3, 2  # decimals: milliradians, millimetres


class JointSliders:
    """Sliders in folders, one for each limb. ``moved`` is called, in the server's thread, when a person moves one.

    Attributes:
        degrees: A checkbox, whether they show angles in degrees.
        sliders: By entry of q: its slide [rad or m], and its slider.
    """

    def __init__(self, gui: viser.GuiApi, robot: Robot, moved: Callable[[], None]) -> None:
        self._moved, self._dirty = moved, dict[int, float]()  # what a person has set entries of q to [rad or m]
        self._prefix = f"{robot.name}_"
        self.sliders: dict[int, tuple[Slide, viser.GuiSliderHandle]] = {}
        self._followers: list[tuple[Follower, viser.GuiSliderHandle]] = []
        self._angles: list[tuple[viser.GuiSliderHandle, float, float]] = []  # sliders of angles, with their ranges [rad]
        self._folders: list[viser.GuiFolderHandle] = []
        self._q = robot.home
        groups = slide_groups(robot)
        self.degrees = gui.add_checkbox("Joints in degrees", initial_value=False)
        self.degrees.on_update(lambda _: self._rescale())
        for group in groups:
            units = {slide.unit for slide in group.slides}
            title = "Joints" if len(groups) == 1 else group.name
            with gui.add_folder(
                f"{title} [{' or '.join(sorted(units, reverse=True))}]", expand_by_default=len(groups) == 1
            ) as folder:
                self._add_group(gui, group, robot.home)
            self._folders.append(folder)

    def take(self, q: NDArray[np.float64]) -> bool:
        """Write the values of sliders that a person has moved into q, within the limits. Returns whether there were any."""
        dirty, self._dirty = self._dirty, {}
        for column, value in dirty.items():
            slide, _ = self.sliders[column]
            q[column] = min(max(value, slide.low), slide.high)
        return bool(dirty)

    def show(self, q: NDArray[np.float64]) -> None:
        """Set the sliders to q, shape (n_dof,), except those that a person has just moved."""
        self._q = q
        for column, (slide, slider) in self.sliders.items():
            if column not in self._dirty:
                slider.value = _rounded_within(slide.shown(q) * self._factor(slide.unit), slider.min, slider.max)
        for follower, slider in self._followers:
            slider.value = _rounded_within(follower.position(q) * self._factor(follower.unit), slider.min, slider.max)

    def _factor(self, unit: str) -> float:
        """What an entry of q in this unit is multiplied by where it is shown."""
        return 180.0 / pi if unit == "rad" and self.degrees.value else 1.0

    def _rescale(self) -> None:
        """Show the range of each slider in radians, or in degrees."""
        digits = _DIGITS_OF_DEGREES if self.degrees.value else _DIGITS
        for slider, low, high in self._angles:
            slider.min, slider.max = np.degrees([low, high]).round(digits).tolist() if self.degrees.value else (low, high)
            slider.step = 10.0**-digits
        before, after = ("rad", "deg") if self.degrees.value else ("deg", "rad")
        for folder in self._folders:
            folder.label = (folder.label or "").replace(f"[{before}", f"[{after}")
        self.show(self._q)

    def _add_group(self, gui: viser.GuiApi, group: SlideGroup, home: NDArray[np.float64]) -> None:
        for slide in group.slides:
            slider = gui.add_slider(
                slide.name.removeprefix(self._prefix),
                min=slide.low,
                max=slide.high,
                step=10.0**-_DIGITS,
                initial_value=_rounded_within(slide.shown(home), slide.low, slide.high),
                hint=f"{slide.name}, {slide.low:.4g} to {slide.high:.4g} {slide.unit}",
            )
            slider.on_update(self._listener(slide.column))
            self.sliders[slide.column] = (slide, slider)
            if slide.unit == "rad":
                self._angles.append((slider, slide.low, slide.high))
        for follower in group.followers:
            self._add_follower(gui, follower, home)

    def _add_follower(self, gui: viser.GuiApi, follower: Follower, home: NDArray[np.float64]) -> None:
        slide = next(slide for slide, _ in self.sliders.values() if slide.column == follower.drive.column)
        ends = [follower.drive.ratio * bound + follower.drive.offset for bound in (slide.low, slide.high)]
        low, high = min(ends), max(*ends, min(ends) + 10.0**-_DIGITS)
        slider = gui.add_slider(
            follower.name.removeprefix(self._prefix),
            min=low,
            max=high,
            step=10.0**-_DIGITS,
            initial_value=_rounded_within(follower.position(home), low, high),
            disabled=True,
            hint=f"It follows: {follower} [{follower.unit}]",
        )
        self._followers.append((follower, slider))
        if follower.unit == "rad":
            self._angles.append((slider, low, high))

    def _listener(self, column: int) -> Callable:
        async def listen(event: viser.GuiEvent) -> None:
            if event.client is not None:  # moved by a person, not by ``show``
                slide, slider = self.sliders[column]
                self._dirty[column] = slider.value / self._factor(slide.unit)
                self._moved()

        return listen


def _rounded_within(value: float, low: float, high: float) -> float:
    """A value rounded to the digits of a slider, and kept between its limits."""
    return min(max(round(value, _DIGITS), low), high)
