"""Finds the columns of a table, with their units, by the names in its first line."""

import codecs
import csv
import re
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

from ulna.errors import count_of

LENGTH, ANGLE, TIME, NUMBER = "length", "angle", "time", "number"  # the kinds of quantities; a number has no unit
_PLAIN_UNITS: dict[str, tuple[str, float]] = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), (LENGTH, 1.0)),  # codespell:ignore
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), (LENGTH, 1e-3)),  # codespell:ignore
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), (LENGTH, 1e-2)),  # codespell:ignore
    **dict.fromkeys(("um", "\u00b5m", "\u03bcm"), (LENGTH, 1e-6)),
    **dict.fromkeys(("in", "inch", "inches"), (LENGTH, 0.0254)),
    **dict.fromkeys(("rad", "rads", "radian", "radians"), (ANGLE, 1.0)),
    **dict.fromkeys(("deg", "degs", "degree", "degrees", "\u00b0"), (ANGLE, 0.017453292519943295)),
    "mrad": (ANGLE, 1e-3),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), (TIME, 1.0)),
    **dict.fromkeys(("ms", "msec"), (TIME, 1e-3)),
    **dict.fromkeys(("us", "usec", "\u00b5s", "\u03bcs"), (TIME, 1e-6)),
    **dict.fromkeys(("ns", "nsec"), (TIME, 1e-9)),
    **dict.fromkeys(("", "-", "1"), (NUMBER, 1.0)),
}
_PER_TIME = {1: ("/s",), 2: ("/s^2", "/s2", "/s\u00b2", "/s/s")}  # suffixes of the units of rates
_IN_BRACKETS = re.compile(r"(.*?)[\s_]*[\[(<]\s*([^\[\]()<>]*?)\s*[\])>]")
_BEHIND = re.compile(r"(.+?)(?:\s+in\s+|[\s_./-]+|(?=\u00b0))([^\W\d_]+|\u00b0)")
_PLAIN = re.compile(r"[\w\s./:\[\]()-]*")  # names that are compared by their words
_SEPARATORS = (";", "\t", ",", None)  # None: blanks
_COMMENTS = ("#", "//")
_MAX_COLUMNS, _MAX_NAME = 1000, 200  # limits on compared names, since patterns take time
_LONGEST_LINE = 1_000_000  # characters


def rate_kind(kind: str, order: int) -> str:
    """The kind of the first or second derivative of a quantity."""
    return f"{kind}{_PER_TIME[order][0]}"


_UNITS = _PLAIN_UNITS | {
    f"{unit}{per}": (rate_kind(kind, order), factor)
    for order, all_per in _PER_TIME.items()
    for per in all_per
    for unit, (kind, factor) in _PLAIN_UNITS.items()
    if unit and kind in {LENGTH, ANGLE}
}


class Quantity(NamedTuple):
    """A quantity that a column may have.

    Attributes:
        name: Its name here.
        kind: Its kind, which determines its possible units.
        words: A pattern of its other names in files, in small letters, with one blank between words; "" for none.
        unit: Its unit in m, rad or s if the name of a column states none.
    """

    name: str
    kind: str
    words: str = ""
    unit: float = 1.0


_PLACE = r"(?:.* )?(?:position|pos|translation|trans|point|points|coordinate|location)"
_TURN = r"(?:.* )?(?:orientation|ori|rotation|rot|quaternion|quat)"
XYZ = tuple(Quantity(x, LENGTH, rf"[tp]{x}|[tp] {x}|{_PLACE} (?:{x}|{k})") for k, x in enumerate("xyz"))
RPY = tuple(Quantity(name, ANGLE, rf"(?:.* )?{name}") for name in ("roll", "pitch", "yaw"))
WXYZ = tuple(Quantity(f"q{x}", NUMBER, rf"q {x}|{_TURN} q?{x}") for x in "wxyz")
TIMES = Quantity("time", TIME, r"(?:.* )?(?:time|timestamp|stamp|t|time from start)")


class Head(NamedTuple):
    """The format of a table of text.

    Attributes:
        names: The names of its columns, as written; None if no line has them.
        n_columns: The number of columns in its first row.
        separator: The text between two columns; None for blanks.
        decimal_comma: Whether numbers have a decimal comma.
        first: The index of the first line with numbers.
    """

    names: tuple[str, ...] | None
    n_columns: int
    separator: str | None
    decimal_comma: bool
    first: int


class Found(NamedTuple):
    """The columns of quantities.

    Attributes:
        at: By the name of a quantity: the index of its column, and the factor from its stated unit to m, rad or s; None without
            one.
        others: The names of all other columns.
    """

    at: Mapping[str, tuple[int, float | None]]
    others: tuple[str, ...]


class Row(NamedTuple):
    """The columns of a named table that make a row.

    Attributes:
        known: The quantities that a column may have.
        chosen: Selects the quantities of a row, in order, from the columns found.
        ignored: Whether a column of another name is ignored; otherwise it is refused.
    """

    known: Sequence[Quantity]
    chosen: Callable[[Found], Sequence[str]]
    ignored: Callable[[str], bool]


def text_of(content: bytes) -> str:
    """Decode a file by its byte order mark, without one as UTF-8."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    return content.decode("utf-8-sig", errors="replace")


def is_row(line: str) -> bool:
    """Whether a line is neither blank nor a comment."""
    stripped = line.lstrip()
    return bool(stripped) and not stripped.startswith(_COMMENTS)


def head_of(lines: Sequence[str], known: Sequence[Quantity]) -> Head | None:
    """The format of a table; None if it has no row of numbers.

    Its names come from the first line that is no comment, unless that contains numbers. Otherwise they come from the last comment
    before the numbers, if that has one word per column with ``known`` names among them.

    Raises:
        ValueError: The line of names has another number of columns than the line after it.
    """
    separators = _SEPARATORS
    start = next((k for k, line in enumerate(lines) if line.strip()), 0)
    if stated := re.fullmatch(r"sep=(.)\s*", lines[start] if lines else ""):  # written by spreadsheets
        separators, start = (stated[1], None), start + 1
    rows = list(islice((k for k in range(start, len(lines)) if is_row(lines[k])), 2))
    if not rows:
        return None
    head = _written(lines[rows[0]], separators, rows[0])
    if any(is_number(field, head) for field in fields_of(lines[rows[0]], head.separator)):
        return head._replace(names=_commented(lines[start : rows[0]], head, known))
    if len(rows) == 1:
        return None
    head = _written(lines[rows[1]], separators, rows[1])
    names = _split_names(lines[rows[0]], head)
    if len(names) != head.n_columns:
        named, there = count_of(len(names), "name"), count_of(head.n_columns, "column")
        few = f"line {rows[0] + 1} has {named}, but line {rows[1] + 1} has {there}"
        raise ValueError(f"{few}; a line that names none of them begins with #")
    return head._replace(names=names)


def _written(line: str, separators: Sequence[str | None], number: int) -> Head:
    """The format of a line of numbers."""
    separator = next(one for one in separators if one is None or one in line)
    return Head(None, len(fields_of(line, separator)), separator, separator != "," and "," in line, number)


def fields_of(line: str, separator: str | None) -> list[str]:
    """The fields of a line, without quotes, and without an empty one at its end.

    Raises:
        ValueError: The line, or a field, is too long.
    """
    if len(line) > _LONGEST_LINE:
        raise ValueError(f"a line has {len(line)} characters; up to {_LONGEST_LINE} are read")
    try:
        fields = next(csv.reader([line.strip()], delimiter=separator or " ", skipinitialspace=True), [])
    except csv.Error as error:
        raise ValueError(f"{line.strip()[:60]!r} is not a row: {error}") from None
    fields = [field.strip() for field in fields if separator is not None or field]
    return fields[:-1] if len(fields) > 1 and not fields[-1] else fields


def number_of(field: str, head: Head) -> float:
    """The number in a field.

    Raises:
        ValueError: It is not a number.
    """
    if "_" in field:
        raise ValueError(field)
    if head.decimal_comma:
        if "." in field:
            raise ValueError(field)
        field = field.replace(",", ".")
    return float(field)


def is_number(field: str, head: Head) -> bool:
    """Whether a field is a number."""
    try:
        number_of(field, head)
    except ValueError:
        return False
    return True


def find_columns(names: Sequence[str], known: Sequence[Quantity]) -> Found:
    """Find the columns of quantities by their names.

    A name may state a unit, as in "x [mm]", "q1 (deg)" or "roll_deg".

    Raises:
        ValueError: Two columns belong to one quantity, a unit is unknown or of another kind, or there are more than 1000 columns.
    """
    if len(names) > _MAX_COLUMNS:
        raise ValueError(f"{len(names)} columns have names; at most {_MAX_COLUMNS} are read")
    at: dict[str, tuple[int, float | None]] = {}
    others = []
    for k, name in enumerate(names):
        quantity, unit = _quantity(name, known)
        if quantity is None:
            others.append(name)
            continue
        if quantity.name in at:
            raise ValueError(
                f"columns {names[at[quantity.name][0]][:60]!r} and {name[:60]!r} are both {quantity.name}; one is expected"
            )
        at[quantity.name] = k, _factor(name, quantity, unit)
    return Found(at, tuple(others))


def required(found: Found, wanted: Sequence[str], names: Sequence[str]) -> tuple[list[int], list[float | None]]:
    """The indices of the required columns, and their factors.

    Raises:
        ValueError: A column is missing.
    """
    missing = [name for name in wanted if name not in found.at]
    if missing:
        has = ", ".join(repr(name) for name in names[:20]) + (" ..." if len(names) > 20 else "")
        raise ValueError(f"no column is named {', '.join(missing[:20])}; the names are {has[:400]}")
    return [found.at[name][0] for name in wanted], [found.at[name][1] for name in wanted]


def columns_of(names: Sequence[str], row: Row) -> tuple[list[int], list[float]]:
    """The indices of the columns that make a row, and their units in m, rad or s.

    Raises:
        ValueError: A column is missing, duplicate, or unknown.
    """
    found = find_columns(names, row.known)
    chosen = row.chosen(found)
    columns, factors = required(found, chosen, names)
    beside = [*found.others, *(names[column] for name, (column, _) in found.at.items() if name not in chosen)]
    strange = [name for name in beside if not row.ignored(name)]
    if strange:
        raise ValueError(f"column {strange[0][:60]!r} is unknown among {', '.join(chosen[:20])}")
    usual = {one.name: one.unit for one in row.known}
    return columns, [usual[name] if factor is None else factor for name, factor in zip(chosen, factors, strict=True)]


def words_of(name: str) -> str:
    """A name in small letters, with one blank between its words."""
    return " ".join(re.split(r"[\W_]+", name.casefold())).strip()


def _commented(lines: Sequence[str], head: Head, known: Sequence[Quantity]) -> tuple[str, ...] | None:
    """The names in the last comment before the numbers; None if it contains no known name.

    Raises:
        ValueError: It names columns, but their number is wrong, and not in the usual order.
    """
    comment = next((line for line in reversed(lines) if line.strip()), "").strip().lstrip("#/").strip()
    names = _split_names(comment, head)
    if len(names) != head.n_columns:
        names = tuple(re.split(r"[\s,;]+", comment))
    quantities = [_quantity(name, known)[0] for name in names[:_MAX_COLUMNS]]
    found = [(k, one.name) for k, one in enumerate(quantities) if one is not None]
    if not found:
        return None
    for skipped in {0, found[0][0]}:  # words before the names, as in "columns: x y z"
        if len(names) - skipped == head.n_columns:
            return names[skipped:]
    if len(found) > 2 and found != [(k, one.name) for k, one in enumerate(known[: len(found)])]:
        named, are = count_of(len(names), "column"), "is" if head.n_columns == 1 else "are"
        raise ValueError(f"the comment {comment[:60]!r} names {named}, but there {are} {head.n_columns}")
    return None


def _split_names(line: str, head: Head) -> tuple[str, ...]:
    """The names in a line, whose separator may differ from that of the numbers below."""
    ways = (fields_of(line, separator) for separator in (head.separator, *_SEPARATORS))
    first, *others = islice(ways, len(_SEPARATORS) + 1)
    names = next((names for names in (first, *others) if len(names) == head.n_columns), first)
    return tuple(name.strip(" ,;") for name in names)


def _quantity(name: str, known: Sequence[Quantity]) -> tuple[Quantity | None, str | None]:
    """The quantity of a column, and the unit in its name; None if there is none."""
    name = name.strip()[:_MAX_NAME]
    if exact := next((one for one in known if one.name == name), None):
        return exact, None
    if name == "%time":  # written by ``rostopic echo -p``
        return _named("time", known), "ns"
    match = _IN_BRACKETS.fullmatch(name)
    if match is not None and (quantity := _named(match[1], known)) is not None:
        return quantity, match[2]
    if (quantity := _named(name, known)) is not None:
        return quantity, None
    match = _BEHIND.fullmatch(name)
    if match is not None and match[2].casefold() in _UNITS and (quantity := _named(match[1], known)) is not None:
        return quantity, match[2]
    return None, None


def _named(name: str, known: Sequence[Quantity]) -> Quantity | None:
    """The quantity of a name without a unit; None if no quantity or several match."""
    words = words_of(name)
    if not words or not _PLAIN.fullmatch(name):
        return None
    alike = [one for one in known if one.name == name] or [one for one in known if words_of(one.name) == words]
    if alike:
        return alike[0] if len(alike) == 1 else None
    return next((one for one in known if one.words and re.fullmatch(one.words, words)), None)


def _factor(name: str, quantity: Quantity, unit: str | None) -> float | None:
    if unit is None:
        return None
    kind, factor = _UNITS.get(unit.casefold(), (None, 1.0))
    if kind != quantity.kind:
        expected = ", ".join(one for one, (kind, _) in _UNITS.items() if kind == quantity.kind and one)
        raise ValueError(f"the unit of column {name[:60]!r} is not known; of {quantity.name} it may be {expected}")
    return factor
