"""Reads constraints from the command line: ``--keep upright=5deg``."""

import csv
import re
from collections.abc import Callable, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

from ulna.cli.depends import as_options
from ulna.cli.targets import BOX, RPY, XYZ, numbers, words
from ulna.description.pose import pose
from ulna.errors import InputError, did_you_mean
from ulna.planning.keep import Keep
from ulna.robot.coordinates import Coordinate

KeepTexts = Annotated[
    list[str] | None,
    typer.Option(
        "--keep",
        metavar="NAME=NUMBERS",
        help="A constraint on the motion: upright=5deg, orientation=2deg, line=x,y,z,x,y,z,1mm (two points), "
        "plane=x,y,z,roll,pitch,yaw,1mm, inside=x,y,z,roll,pitch,yaw,length,width,height, looking=x,y,z,5deg (a point), or "
        'together=LINK,LINK; the tolerance may be left out. "LINK:upright=5deg" is about another link. Repeatable.',
    ),
]
_UNITS = {"deg": ("rad", np.pi / 180.0), "rad": ("rad", 1.0), "mm": ("m", 1e-3), "m": ("m", 1.0)}
_WITH_UNIT = re.compile(r"([0-9.eE+-]+)(deg|rad|mm|m)")


class _Kind(NamedTuple):
    """A kind of constraint: its numbers, the units of its tolerances, and the function that makes it."""

    entries: Sequence[Coordinate]
    units: tuple[str, ...]
    make: Callable[..., Keep]


_KINDS = {
    "upright": _Kind((), ("rad",), lambda _, **options: Keep.upright(**options)),
    "orientation": _Kind((), ("rad",), lambda _, **options: Keep.orientation(**options)),
    "line": _Kind((*XYZ, *XYZ), ("m",), lambda x, **options: Keep.on_line(x[:3], x[3:], **options)),
    "plane": _Kind((*XYZ, *RPY), ("m",), lambda x, **options: Keep.in_plane(pose(x[:3], x[3:]), **options)),
    "inside": _Kind(BOX, (), lambda x, **options: Keep.inside(x[6:], pose(x[:3], x[3:6]), **options)),
    "looking": _Kind(XYZ, ("rad",), Keep.looking_at),
}


def keep_of(text: str, *, degrees: bool = False) -> Keep:
    """Parse a constraint such as "upright=5deg", "line=0.4,0,0.5,0.4,0,0.8,1mm" or "left_hand:upright".

    Raises:
        InputError: The text cannot be read, or the constraint is refused.
    """
    head, _, rest = text.partition("=")
    link, colon, name = head.rpartition(":")
    options: dict[str, Any] = {"link": link} if colon else {}
    values = _words(rest)
    tolerances: list[tuple[str, float]] = []
    while values and (match := _WITH_UNIT.fullmatch(values[-1])):
        unit, factor = _UNITS[match[2]]
        tolerances.insert(0, (unit, factor * numbers("--keep", match[1], [Coordinate("tolerance", "")])[0]))
        values.pop()
    with as_options(dict.fromkeys(("a", "b", "T", "extents", "point", "relative_to", "task", "within", "xyz", "rpy"), "--keep")):
        if name == "together":
            return _together(text, values, tolerances)
        if name not in _KINDS:
            raise InputError("--keep", f"{text!r} names no constraint{did_you_mean(name, (*_KINDS, 'together'))}")
        kind = _KINDS[name]
        if len(values) > len(kind.entries) and kind.units == ("rad",):  # a tolerance without a unit is an angle
            options["within"] = numbers("--keep", values.pop(), [Coordinate("tolerance", "rad")], degrees=degrees)[0]
        elif tolerances:
            options["within"] = _within(text, tolerances, kind.units)[0]
        return kind.make(numbers("--keep", ",".join(values), kind.entries, degrees=degrees), **options)


def _words(text: str) -> list[str]:
    """Split a text into words; a name in double quotes may contain commas and spaces."""
    if '"' not in text:
        return words(text)
    try:
        return [word.strip() for word in next(csv.reader([text], skipinitialspace=True, strict=True))]
    except csv.Error:
        message = f'{text!r}: put a name with a comma in double quotes: together="left,hand",right'
        raise InputError("--keep", message) from None


def _together(text: str, links: list[str], tolerances: list[tuple[str, float]]) -> Keep:
    if len(links) != 2:
        raise InputError("--keep", f"{text!r}; together=LINK,LINK is expected")
    options = {"within": tuple(_within(text, tolerances, ("m", "rad")))} if tolerances else {}
    return Keep.together(*links, **options)  # type: ignore[arg-type]


def _within(text: str, tolerances: list[tuple[str, float]], units: tuple[str, ...]) -> list[float]:
    """The tolerances; raises an error if their units differ from ``units``."""
    if tuple(unit for unit, _ in tolerances) != units:
        expected = ",".join({"rad": "5deg", "m": "1mm"}[unit] for unit in units)
        what = f"a tolerance such as {expected}" if units else "no tolerance"
        raise InputError("--keep", f"{text!r}; {what} is expected at the end")
    return [value for _, value in tolerances]
