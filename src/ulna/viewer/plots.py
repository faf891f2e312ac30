"""Plots the curves of a planned motion: all joints relative to their limits, or one in its units."""

import html
from collections.abc import Callable, Mapping
from itertools import cycle, islice

import numpy as np
import viser

from ulna.planning.timing import QUANTITIES
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of
from ulna.viewer.html import STYLE
from ulna.viewer.palette import CURVES, RED, SLATE
from ulna.viewer.session.planned_motion import Curve

_ALL = "all joints, relative to their limits"
_PER = ("", "/s", "/s²", "/s³")
_HEIGHT_PX = 150
_SHARES = (-1.1, 1.1)


class Plots:
    """A chart for each quantity, with dashed lines at the limits; hidden while there is no motion.

    ``chosen`` is called when a person has chosen a joint, after which ``show`` is to be called.
    """

    def __init__(self, gui: viser.GuiApi, robot: Robot, chosen: Callable[[], None]) -> None:
        self._entries = coordinates_of(robot)
        self._colors = [f"rgb{color}" for color in islice(cycle(CURVES), len(self._entries))]
        self._shown: tuple[Mapping[str, Curve], str] = {}, ""
        self.folder = gui.add_folder("Curves", visible=False)
        with self.folder:
            self.joint = gui.add_dropdown("Joint", (_ALL, *(entry.name for entry in self._entries)))
            self.legend = gui.add_html("")
            nothing = (np.zeros(2), np.zeros(2))
            self.charts = {
                name: gui.add_uplot(nothing, ({}, {}), height=_HEIGHT_PX, legend={"show": False}, visible=False)
                for name in QUANTITIES
            }
        self.joint.on_update(lambda _: chosen())

    def show(self, curves: Mapping[str, Curve]) -> None:
        """Plot the curves of the chosen joint, by quantity; hide the charts if there are none."""
        joint = self.joint.value
        if curves is self._shown[0] and joint == self._shown[1]:
            return
        self._shown, self.folder.visible = (curves, joint), bool(curves)
        k = None if joint == _ALL else [entry.name for entry in self._entries].index(joint)
        for (name, chart), per in zip(self.charts.items(), _PER, strict=True):
            chart.visible = name in curves
            if chart.visible:
                self._draw(chart, name, curves[name], k, per)
        dots = (
            f'<span style="white-space:nowrap"><span style="color:{color}">&#9632;</span> {html.escape(entry.name)}</span>'
            for n, (entry, color) in enumerate(zip(self._entries, self._colors, strict=True))
            if k in (None, n)
        )
        self.legend.content = f'<div style="{STYLE};font-size:0.75em">{" &ensp; ".join(dots)}</div>'

    def _draw(self, chart: viser.GuiUplotHandle, name: str, curve: Curve, k: int | None, per: str) -> None:
        if k is None:
            columns = [n for n, values in enumerate(curve.shares.T) if np.isfinite(values).all()]
            values, ends, color, label = curve.shares, [-1.0, 1.0] if columns else [], SLATE, name
        else:
            columns, color, label = [k], RED, f"{name} [{self._entries[k].unit}{per}]"
            values, ends = curve.values, [float(end[k]) for end in (curve.low, curve.high) if np.isfinite(end[k])]
        lines = [np.full_like(curve.t, end) for end in ends]
        chart.scales = {"x": {"time": False}, "y": {"range": _SHARES} if k is None else {}}
        chart.axes = (
            {"label": "t [s]", "labelSize": 14, "labelFont": "11px sans-serif", "size": 30},
            {"label": label, "labelSize": 16, "labelFont": "11px sans-serif", "size": 44},
        )
        chart.series = (
            {"label": "time [s]"},
            *({"label": self._entries[n].name, "stroke": self._colors[n], "width": 1.5} for n in columns),
            *({"label": "limit", "stroke": f"rgb{color}", "dash": (4, 4), "width": 1} for _ in lines),
        )
        chart.data = (curve.t, *(np.ascontiguousarray(values[:, n]) for n in columns), *lines)
