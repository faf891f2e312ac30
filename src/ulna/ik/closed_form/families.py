"""Finds the family of closed forms of six axes, and the deviation of the axes from it.

Source of the families: Ostermeier, Kuelz and Althoff, Automatic geometric decomposition for analytical inverse kinematics (EAIK,
2024), table 1; of the parallel and intersecting axes that they need: Elias and Wen, IK-Geo (2022).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.axes import nearest_point
from ulna.kernels.chain import closed_form_layout as layout

Array = NDArray[np.float64]
Pair = tuple[int, int]
# rad: axes nearer to parallel than this make intersections, and quartics, ill-conditioned.
_SKEW, _SKEW_OF_QUARTIC = 1e-3, 3e-3
_ALMOST = 1e-6  # maximum miss of a family for which its arms are not treated as quartics
EXACT = 1e-12  # maximum miss of a form whose branches are all solutions
NEAR = 1e-3  # maximum miss of a form whose branches are starts of Newton steps: calibrated arms, and pi / 2 as 1.5708
_MIN_OFFSET = 2e-3  # of the reach: a quartic whose axes are nearer to intersecting than this is ill-conditioned


class Rule(NamedTuple):
    """The conditions of a family on its axes, and the table columns of its angles.

    Axes are numbered from 0, in the name from 1.

    Attributes:
        number: The family's number (``closed_form_layout``).
        name: The family in words.
        parallel: Pairs of parallel axes.
        intersecting: The pair of intersecting axes, besides those of a wrist.
        near: The pair of skew axes whose points are their nearest points.
        apart: Pairs of axes that must not be nearly parallel.
        size: A function of the directions (6, 3) that must not be nearly 0.
        slides: Mask of the prismatic joints among the first three; the others are revolute.
        has_wrist: Whether the last three axes intersect in a point.
        offset: A function of directions and points (6, 3): the length that a quartic is divided by [m]; None without a quartic.
        before: The row of NORMALS of the axis before the fifth, in whose frame FIFTH is.
        bend: The axis whose angle with the fifth is in BENDS.
    """

    number: int
    name: str
    parallel: tuple[Pair, ...] = ()
    intersecting: Pair | None = None
    near: Pair | None = None
    apart: tuple[Pair, ...] = ()
    size: Callable[[Array], float] | None = None
    slides: tuple[bool, bool, bool] = (False, False, False)
    has_wrist: bool = True
    offset: Callable[[Array, Array], float] | None = None
    before: int = layout.OF_4
    bend: int = 3


def _turn_across(turn: int, first: int, second: int) -> Callable[[Array], float]:
    """The deviation of a revolute axis from the normal of the plane of two prismatic joints' motion."""
    return lambda h: float(np.linalg.norm(np.cross(h[turn], np.cross(h[first], h[second]))))


def _between_last(_: Array, c: Array) -> float:
    """The distance of the points of the last two axes."""
    return float(np.linalg.norm(c[5] - c[4]))


def _before_wrist(h: Array, c: Array) -> float:
    """The smaller of the distances from axis 3 to axis 2 and to the center of the wrist."""
    return float(min(np.linalg.norm(c[2] - c[1]), np.linalg.norm(np.cross(h[2], c[3] - c[2]))))


_WRIST = "spherical wrist"
_HAND = ((0, 1), (3, 4), (4, 5))  # pairs that must not be nearly parallel if axes 2, 3 and 4 are parallel
_RULES = (
    Rule(
        layout.THREE_PARALLEL, "axes 2, 3 and 4 parallel, 5 and 6 intersecting", ((1, 2), (1, 3)), (4, 5), None, _HAND,
        has_wrist=False, before=layout.OF_2, bend=1,
    ),
    Rule(layout.PARALLEL_23, f"{_WRIST}, axes 2 and 3 parallel", ((1, 2),), apart=((0, 1),)),
    Rule(layout.INTERSECTING_12, f"{_WRIST}, axes 1 and 2 intersecting", intersecting=(0, 1), apart=((0, 1),)),
    Rule(layout.PARALLEL_12, f"{_WRIST}, axes 1 and 2 parallel", ((0, 1),), apart=((1, 2),)),
    Rule(layout.INTERSECTING_23, f"{_WRIST}, axes 2 and 3 intersecting", intersecting=(1, 2), apart=((1, 2),)),
    Rule(
        layout.OFFSET_HAND, "axes 2, 3 and 4 parallel", ((1, 2), (1, 3)), None, (4, 5), _HAND, has_wrist=False,
        offset=_between_last, before=layout.OF_2,
    ),
    Rule(layout.ANY_THREE_AXES, _WRIST, near=(1, 2), apart=((0, 1), (1, 2)), offset=_before_wrist),
    Rule(
        layout.SLIDE_PARALLEL_23, f"{_WRIST}, joint 1 sliding, axes 2 and 3 parallel", ((1, 2),),
        size=lambda h: abs(h[0] @ h[1]), slides=(True, False, False),
    ),
    Rule(
        layout.SLIDE_INTERSECTING_23, f"{_WRIST}, joint 1 sliding, axes 2 and 3 intersecting", intersecting=(1, 2),
        slides=(True, False, False),
    ),
    Rule(
        layout.INTERSECTING_12_SLIDE, f"{_WRIST}, axes 1 and 2 intersecting, joint 3 sliding", intersecting=(0, 1),
        slides=(False, False, True),
    ),
    Rule(
        layout.PARALLEL_12_SLIDE, f"{_WRIST}, axes 1 and 2 parallel, joint 3 sliding", ((0, 1),),
        size=lambda h: abs(h[2] @ h[0]), slides=(False, False, True),
    ),
    Rule(
        layout.TURN_SLIDES, f"{_WRIST}, joints 2 and 3 sliding", apart=((1, 2),), size=_turn_across(0, 1, 2),
        slides=(False, True, True),
    ),
    Rule(
        layout.SLIDES_TURN, f"{_WRIST}, joints 1 and 2 sliding", apart=((0, 1),), size=_turn_across(2, 0, 1),
        slides=(True, True, False),
    ),
    Rule(
        layout.THREE_SLIDES, f"{_WRIST}, joints 1, 2 and 3 sliding", size=lambda h: abs(np.linalg.det(h[:3])),
        slides=(True, True, True),
    ),
)  # fmt: skip
RULES = {rule.number: rule for rule in _RULES}


@dataclass(frozen=True, eq=False)
class Family:
    """Six axes, moved exactly into a family.

    Attributes:
        number: The family's number (``closed_form_layout``).
        from_end: Whether the chain is seen from its end: the axes are reversed, in direction and in order.
        miss: The maximum move of the directions [rad] and of the points [share of the reach].
        directions: Unit vectors, shape (6, 3), exactly of the family.
        points: Points on the axes, shape (6, 3) [m].
        signs: Shape (6,): -1 where the direction is opposite to the joint's own.
    """

    number: int
    from_end: bool
    miss: float
    directions: Array
    points: Array
    signs: Array

    @property
    def rule(self) -> Rule:
        """The family's conditions on its axes."""
        return RULES[self.number]


def family_of(directions: Array, points: Array, slides: NDArray[np.bool_], unit: float) -> Family | None:
    """The family with the smallest miss, the first of equally good ones; None if no family is near.

    directions, points: Shape (6, 3). slides: Mask of the prismatic joints, shape (6,). unit: The length for relative distances
    [m].
    """
    families = [
        *_families(directions, points, slides, unit, from_end=False),
        *_families(-directions[::-1], points[::-1], slides[::-1], unit, from_end=True),
    ]
    if not families:
        return None
    not_quartic = [family for family in families if family.rule.offset is None]
    if (
        not_quartic and min(family.miss for family in not_quartic) <= _ALMOST
    ):  # axes near one of these make an ill-conditioned quartic
        families = not_quartic
    min_miss = min(family.miss for family in families)
    return next(family for family in families if family.miss <= max(10.0 * min_miss, EXACT))


def _families(h: Array, c: Array, slides: NDArray[np.bool_], scale: float, *, from_end: bool) -> Iterator[Family]:
    if slides[3:].any():
        return
    for rule in _RULES:
        if rule.slides != tuple(slides.tolist()[:3]):
            continue
        directions, points, signs = h.copy(), c.copy(), np.ones(6)
        missed = _move_into(rule, directions, points, signs)
        if missed is not None:
            miss = max(missed[0], missed[1] / scale)
            is_offset = rule.offset is None or rule.offset(directions, points) > _MIN_OFFSET * scale
            if miss <= NEAR and is_offset:
                yield Family(rule.number, from_end, miss, directions, points, signs)


def _move_into(rule: Rule, h: Array, c: Array, signs: Array) -> tuple[float, float] | None:
    """Move axes into a family; the miss as angle [rad] and length [m], or None if ill-conditioned."""
    angle = max((_make_parallel(h, signs, i, j) for i, j in rule.parallel), default=0.0)
    min_skewness = _SKEW if rule.offset is None else _SKEW_OF_QUARTIC
    if any(_skewness(h, i, j) < min_skewness for i, j in rule.apart) or (rule.size is not None and rule.size(h) < _SKEW):
        return None
    length = _make_intersecting(h, c, *rule.intersecting) if rule.intersecting else 0.0
    if rule.near:
        _make_nearest(h, c, *rule.near)
    if rule.has_wrist:
        if min(_skewness(h, 3, 4), _skewness(h, 4, 5)) < _SKEW:
            return None
        c[3:], distance = nearest_point(h[3:], c[3:])
        length = max(length, distance)
    return angle, length


def _skewness(h: Array, i: int, j: int) -> float:
    """The sine of the angle between two axes."""
    return float(np.linalg.norm(np.cross(h[i], h[j])))


def _make_parallel(h: Array, signs: Array, i: int, j: int) -> float:
    """Make axis j parallel to axis i, and record the sign of its direction; the angle between the axes."""
    signs[j] = 1.0 if h[i] @ h[j] >= 0.0 else -1.0
    missed = _skewness(h, i, j)
    h[j] = h[i]
    return missed


def _make_intersecting(h: Array, c: Array, i: int, j: int) -> float:
    """Move the points of two axes to their intersection; the distance between the axes."""
    normal, difference = np.cross(h[i], h[j]), c[j] - c[i]
    square = normal @ normal
    if square < _SKEW**2:
        return np.inf
    _make_nearest(h, c, i, j)
    c[i] = c[j] = (c[i] + c[j]) / 2.0
    return float(abs(difference @ normal) / np.sqrt(square))


def _make_nearest(h: Array, c: Array, i: int, j: int) -> None:
    """Move the points of two skew axes to their nearest points."""
    normal, difference = np.cross(h[i], h[j]), c[j] - c[i]
    square = normal @ normal
    c[i], c[j] = (
        c[i] + h[i] * (np.cross(difference, h[j]) @ normal / square),
        c[j] + h[j] * (np.cross(difference, h[i]) @ normal / square),
    )
