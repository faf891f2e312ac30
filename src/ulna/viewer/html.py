"""Writes the HTML of the panel: text with a colored mark, lists, the kinematic tree, tables of numbers."""

import html
from collections.abc import Iterable
from math import isinf
from typing import NamedTuple

from ulna.description.robot_description import Joint, JointType
from ulna.description.structure import joints_from_root
from ulna.robot import Robot
from ulna.viewer.palette import GREEN, RED, STOPPED, UNKNOWN, Color, is_in_the_way
from ulna.viewer.session.ellipsoid import Mobility
from ulna.viewer.session.loads import NEAR_LIMIT, Load

STYLE = "padding:0.35em 0.75em;line-height:1.35"
BUTTON = "border:1px solid var(--ulna-link);border-radius:2px;color:var(--ulna-link);background:transparent;padding:0.2em 0.7em"


def status_line(words: str, color: Color) -> str:
    """Text after a colored mark; screen readers announce its changes.

    The mark is a disc for contacts and stops, a dotted ring for an unknown state, otherwise a ring.
    """
    line = "dotted" if color == UNKNOWN else "solid"
    look = "background:currentColor" if is_in_the_way(color) else f"border:0.22em {line};box-sizing:border-box"
    disc = f"--mark:rgb{color};display:inline-block;width:0.9em;height:0.9em;border-radius:50%;vertical-align:-0.08em;{look}"
    return f'<div role="status" style="{STYLE};font-weight:600"><span data-mark style="{disc}"></span> {html.escape(words)}</div>'


def lead(words: str) -> str:
    """A sentence in large letters, for the first step of a page."""
    return f'<div style="{STYLE};font-size:1.1em;font-weight:600">{html.escape(words)}</div>'


def small_text(words: str) -> str:
    """Small text."""
    return f'<div style="{STYLE};font-size:0.85em">{html.escape(words)}</div>'


def copy_button(words: str, label: str, copied: str) -> str:
    """A button that copies a text, below small text if there is any."""
    button = f'<button data-copy="{html.escape(copied, quote=True)}" style="{BUTTON}">{label}</button>'
    above = f"{html.escape(words)}<br>" if words else ""
    return f'<div style="padding:0 0.75em 0.4em;font-size:0.8em">{above}{button}</div>'


def bullet_list(lines: Iterable[str]) -> str:
    """A list of small lines."""
    rows = "".join(f'<li style="margin-bottom:0.3em">{html.escape(line)}</li>' for line in lines)
    return f'<ul style="{STYLE};font-size:0.8em;margin:0;padding-left:1.6em;overflow-wrap:anywhere">{rows}</ul>'


def color_bar(title: str, colors: Iterable[Iterable[float]], ends: tuple[str, str]) -> str:
    """A titled bar of evenly spaced colors (red, green, blue in 0..255), with labels at both ends."""
    stops = ", ".join(f"rgb({', '.join(f'{channel:g}' for channel in color)})" for color in colors)
    low, high = (f"<span>{html.escape(end)}</span>" for end in ends)
    bar = f'<div style="height:0.8em;border-radius:0.2em;background:linear-gradient(to right, {stops})"></div>'
    row = f'<div style="display:flex;justify-content:space-between">{low}{high}</div>'
    return f'<div style="{STYLE};font-size:0.85em"><div>{html.escape(title)}</div>{bar}{row}</div>'


def tree_html(robot: Robot) -> str:
    """The kinematic tree: each link in bold, followed by its joint."""
    rows = [
        f'<div style="padding-left:{0.7 * branch.depth:.1f}em"><b>{html.escape(branch.link)}</b>'
        + (
            ""
            if branch.joint is None
            else f' <span style="opacity:0.65">{_kind(branch.joint.type)}{html.escape(branch.joint.name)}</span>'
        )
        + "</div>"
        for branch in outline(robot)
    ]
    return f'<div style="{STYLE};font-size:0.75em;white-space:nowrap;overflow-x:auto">{"".join(rows)}</div>'


def mobility_html(mobility: Mobility) -> str:
    """The singular values and the manipulability."""
    values = " ".join(f"{value:.3f}" for value in mobility.singular_values)
    radii = " ".join(f"{radius:.3f}" for radius in mobility.radii)
    rows = [("singular values", values), ("half axes [m/s]", radii), ("manipulability", f"{mobility.manipulability:.4g}")]
    return facts(rows)


def load_bar(joint: str, load: Load) -> str:
    """A thin bar of the holding torque of a joint relative to its limit, with the numbers beside it.

    The bar is green, orange near the limit, and red and full beyond the limit.
    """
    color = UNKNOWN if isinf(load.limit) else GREEN if load.share < NEAR_LIMIT else STOPPED if load.share <= 1.0 else RED
    width = min(round(100.0 * load.share, 1), 100.0)
    fill = f'<div style="width:{width:g}%;height:100%;background:currentColor"></div>'
    look = f"--mark:rgb{color};flex:1;height:0.5em;border:1px solid;border-radius:0.2em;box-sizing:border-box;overflow:hidden"
    names = f'role="meter" aria-label="{html.escape(f"holding torque of {joint}", quote=True)}" aria-valuetext="{load}"'
    bar = f'<div data-mark {names} aria-valuemin="0" aria-valuemax="100" aria-valuenow="{width:g}" style="{look}">{fill}</div>'
    look = "min-width:12em;text-align:right;color:var(--ulna-number);font-variant-numeric:tabular-nums"
    words = f'<div style="{look}">holding {load}</div>'
    return (
        f'<div style="display:flex;align-items:center;padding:0 0.9em 0.4em;font-size:0.75em;line-height:1.3">{bar}{words}</div>'
    )


def facts(rows: Iterable[tuple[str, str]]) -> str:
    """A table of names and values."""
    cells = "".join(
        f'<tr><th scope="row" style="text-align:left;padding-right:1em;font-weight:500">{html.escape(name)}</th>'
        f"<td>{html.escape(value)}</td></tr>"
        for name, value in rows
    )
    return f'<table style="{STYLE};font-size:0.8em;margin-left:0.75em;font-variant-numeric:tabular-nums">{cells}</table>'


def _kind(kind: JointType) -> str:
    return "fixed " if kind == JointType.FIXED else f"{kind} "


class Branch(NamedTuple):
    """A line of the tree: its depth, the link, and the parent joint of the link (None for the root)."""

    depth: int
    link: str
    joint: Joint | None


def outline(robot: Robot) -> list[Branch]:
    """The lines of the tree, depth first, in the order of the description."""
    depths, lines = {robot.base: 0}, [Branch(0, robot.base, None)]
    for joint in joints_from_root(robot.description):
        depths[joint.child] = depths[joint.parent] + 1
        lines.append(Branch(depths[joint.child], joint.child, joint))
    return lines
