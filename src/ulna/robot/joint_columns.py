"""Recognizes the joint positions of a robot among the named columns of a table."""

import re
from collections.abc import Sequence

from ulna.description.columns import ANGLE, LENGTH, NUMBER, Found, Quantity, Row, words_of
from ulna.errors import count_of
from ulna.robot.coordinates import coordinates_of
from ulna.robot.robot import Robot

_KINDS = {"rad": ANGLE, "m": LENGTH}
_OTHER_COLUMNS = (
    r"(?:.* )?(?:time|time from start|stamp|timestamp|t|secs?|nsecs?|nanosec|seq|id|index|frame|"
    r"velocity|vel|qd|qdot|dq|acceleration|acc|qdd|qddot|ddq|jerk|effort|torque|tau|current|measured|error|temperature)(?: .*)?|"
    r"(?:qd|dq|qdd|ddq|tau)\d+"
)


def joint_columns(robot: Robot) -> Row:
    """The columns that make a row of q.

    A column has the name of its joint, optionally with "position" before or after it, as PlotJuggler writes it. Numbered names
    (q1, joint_1) stand for the entries of q in order, from 0 or from 1, unless a joint has such a name.
    """
    entries = coordinates_of(robot)
    known = [Quantity(one.name, _KINDS.get(one.unit, NUMBER), _position_pattern(one.name)) for one in entries]
    ends = [re.search(r"\d+$", one.name) for one in entries]
    numbers = [int(end[0]) for end in ends if end is not None]
    words = "q|j|joint|axis" if numbers == sorted(set(numbers)) else "q"
    numbered = {first: [f"#{k + first}" for k in range(len(entries))] for first in (0, 1)}
    for k in range(len(entries) + 1):
        kind = known[min(k, len(entries)) - 1].kind if entries else NUMBER
        known.append(Quantity(f"#{k}", kind, rf"(?:{words}) ?0*{k}"))
    names, others = [one.name for one in entries], {words_of(joint.name) for joint in robot.description.joints}

    def choose(found: Found) -> Sequence[str]:
        if not any(one in found.at for one in (*numbered[0], *numbered[1])):
            return names
        if any(name in found.at for name in names):
            raise ValueError(f"some columns have the names of joints, others numbers; the joints are {', '.join(names[:20])}")
        ordered = numbered[0 if "#0" in found.at else 1]
        if any(name not in found.at for name in ordered):
            raise ValueError(f"its columns are numbered, but not from 0 or from 1 as {count_of(len(names), 'joint')}")
        return ordered

    def is_ignored(name: str) -> bool:
        return not name.strip() or words_of(name) in others or bool(re.fullmatch(_OTHER_COLUMNS, words_of(name)))

    return Row(known, choose, is_ignored)


def _position_pattern(name: str) -> str:
    """A pattern for column names of a joint's position, such as /joint_states/NAME/position."""
    words = re.escape(words_of(name))
    return rf"(?:position|pos|q) {words}|(?:.* )?{words} (?:position|pos|q)"
