"""Reads numbers as people write them on the command line: decimals, and fractions of pi."""

import math
import re
from collections.abc import Sequence

from ulna.cli.output import warn
from ulna.errors import InputError
from ulna.robot.coordinates import Coordinate

XYZ = (Coordinate("x", "m"), Coordinate("y", "m"), Coordinate("z", "m"))
RPY = (Coordinate("roll", "rad"), Coordinate("pitch", "rad"), Coordinate("yaw", "rad"))
WXYZ = tuple(Coordinate(name, "") for name in "wxyz")
BOX = (*XYZ, *RPY, Coordinate("length", "m"), Coordinate("width", "m"), Coordinate("height", "m"))
_DECIMAL = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WITH_PI = re.compile(rf"([+-]?)(?:({_DECIMAL})\*?)?pi(?:/({_DECIMAL}))?")
_WITHOUT_PI = re.compile(rf"[+-]?{_DECIMAL}")


def numbers(option: str, text: str, entries: Sequence[Coordinate], *, degrees: bool = False) -> list[float]:
    """The numbers in "0,-pi/4,0.5 1e-3", one for each entry; with ``degrees``, angles are converted to radians.

    Without it, a hint on standard error says that an angle of more than a turn is in radians.

    Raises:
        InputError: There are more or fewer numbers than entries, or one cannot be read. It names the option.
    """
    found = words(text)
    if len(found) != len(entries):
        names = ", ".join(entry.name for entry in entries[:9]) + (" ..." if len(entries) > 9 else "")
        verb = "is" if len(entries) == 1 else "are"
        raise InputError(option, f"{len(found)} number{'s' * (len(found) != 1)}, but {len(entries)} {verb} expected: {names}")
    values: list[float] = []
    turned: list[str] = []
    for word, entry in zip(found, entries, strict=True):
        is_angle = entry.unit == "rad"
        values.append(_number(option, word, degrees=degrees and is_angle))
        if is_angle and not degrees and abs(values[-1]) > 2 * math.pi and "pi" not in word:
            turned.append(word)
    if turned:
        warn(f"{option}: {turned[0]} rad is more than a turn; with --degrees angles are in degrees")
    return values


def is_name(text: str) -> bool:
    """Whether a text begins with a letter and none of its words is a number: "pinch", but neither "pi/2" nor "nan, 0"."""
    return text.strip()[:1].isalpha() and not any(_WITHOUT_PI.fullmatch(w) or _WITH_PI.fullmatch(w) for w in words(text))


def words(text: str) -> list[str]:
    """The words of a text, which commas or spaces separate."""
    return re.split(r"\s*,\s*|\s+", text.strip()) if text.strip() else []


def _number(option: str, word: str, *, degrees: bool) -> float:
    value = math.nan
    if _WITHOUT_PI.fullmatch(word):
        value = math.radians(float(word)) if degrees else float(word)
    elif match := _WITH_PI.fullmatch(word):
        if degrees:
            raise InputError(option, f"{word!r} is in radians, but --degrees is given")
        sign, factor, divisor = match.groups()
        value = float(f"{sign}{factor or 1}") * math.pi / (float(divisor or 1) or math.nan)
    if not math.isfinite(value):
        raise InputError(option, f"{word!r} is not a number; numbers are written as 0.5, 1e-3, pi/2 or -3pi/4")
    return value
