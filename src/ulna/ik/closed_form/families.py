"""Finds to which family of closed forms six axes belong, and by how much they miss it.

Source of the families: Ostermeier, Kuelz and Althoff, Automatic geometric decomposition for analytical inverse kinematics
(EAIK, 2024), table 1; of the parallel and intersecting axes that they need: Elias and Wen, IK-Geo (2022).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.axes import nearest_point
from ulna.kernels.chain import closed_form_layout as layout

Array = NDArray[np.float64]
NAMES = {
    layout.THREE_PARALLEL: "axes 2, 3 and 4 parallel, 5 and 6 intersecting",
    layout.PARALLEL_23: "spherical wrist, axes 2 and 3 parallel",
    layout.INTERSECTING_12: "spherical wrist, axes 1 and 2 intersecting",
    layout.PARALLEL_12: "spherical wrist, axes 1 and 2 parallel",
    layout.INTERSECTING_23: "spherical wrist, axes 2 and 3 intersecting",
    layout.OFFSET_HAND: "axes 2, 3 and 4 parallel",
    layout.ANY_THREE_AXES: "spherical wrist",
    layout.SLIDE_PARALLEL_23: "spherical wrist, joint 1 sliding, axes 2 and 3 parallel",
    layout.SLIDE_INTERSECTING_23: "spherical wrist, joint 1 sliding, axes 2 and 3 intersecting",
    layout.INTERSECTING_12_SLIDE: "spherical wrist, axes 1 and 2 intersecting, joint 3 sliding",
    layout.PARALLEL_12_SLIDE: "spherical wrist, axes 1 and 2 parallel, joint 3 sliding",
    layout.TURN_SLIDES: "spherical wrist, joints 2 and 3 sliding",
    layout.SLIDES_TURN: "spherical wrist, joints 1 and 2 sliding",
    layout.THREE_SLIDES: "spherical wrist, joints 1, 2 and 3 sliding",
}
# rad: nearer to parallel than this, axes that have to intersect are not well enough determined; and axes of a quartic.
_SKEW, _SKEW_OF_QUARTIC = 1e-3, 3e-3
EXACT = 1e-12  # largest miss of a form whose branches are all there are
NEAR = 1e-3  # largest miss of one whose branches are only starts of Newton steps: calibrated arms, and pi / 2 as 1.5708
_QUARTIC, _ALMOST = (layout.OFFSET_HAND, layout.ANY_THREE_AXES), 1e-6
_LEAST_OFFSET = 2e-3  # of the reach: a quartic whose axes are nearer to intersecting than this is ill determined
Miss = tuple[int, float, float] | None  # the family, and by how much angles and lengths miss it


@dataclass(frozen=True, eq=False)
class Family:
    """Six axes, brought into a family.

    Attributes:
        number: Of the family (``closed_form_layout``).
        from_end: Whether the chain is seen from its end: the axes are turned round and in reversed order.
        miss: The most by which directions [rad] and points [share of the reach] were moved for it.
        directions: Unit vectors, shape (6, 3), exactly of the family.
        points: On the axes, shape (6, 3) [m].
        signs: Shape (6,): -1 where the direction is opposite to that about which q turns.
    """

    number: int
    from_end: bool
    miss: float
    directions: Array
    points: Array
    signs: Array


def family_of(directions: Array, points: Array, slides: NDArray[np.bool_], unit: float) -> Family | None:
    """The family with the least miss, of several that are as good the first; None where none comes near.

    directions, points: Shape (6, 3); slides: which joints slide, shape (6,); unit: the length of which shares are taken [m].
    """
    found = [
        *_families(directions, points, slides, unit, from_end=False),
        *_families(-directions[::-1], points[::-1], slides[::-1], unit, from_end=True),
    ]
    if not found:
        return None
    simple = [family for family in found if family.number not in _QUARTIC]
    if simple and min(family.miss for family in simple) <= _ALMOST:  # what is nearly one of these is ill determined as a quartic
        found = simple
    least = min(family.miss for family in found)
    return next(family for family in found if family.miss <= max(10.0 * least, EXACT))


def _families(h: Array, c: Array, slides: NDArray[np.bool_], scale: float, *, from_end: bool) -> Iterator[Family]:
    for make in _MAKERS.get(tuple(slides.tolist()[:3]), ()) if not slides[3:].any() else ():
        directions, points, signs = h.copy(), c.copy(), np.ones(6)
        result = make(directions, points, signs)
        if result is not None:
            number, angle, length = result
            miss = max(angle, length / scale)
            if miss <= NEAR and (number not in _QUARTIC or _least_offset(number, directions, points) > _LEAST_OFFSET * scale):
                yield Family(number, from_end, miss, directions, points, signs)


def _three_parallel(h: Array, c: Array, signs: Array) -> Miss:
    angle = max(_made_parallel(h, signs, 1, 2), _made_parallel(h, signs, 1, 3))
    if min(_skewness(h, 0, 1), _skewness(h, 3, 4), _skewness(h, 4, 5)) < _SKEW:
        return None
    return layout.THREE_PARALLEL, angle, _made_intersecting(h, c, 4, 5)


def _parallel_23(h: Array, c: Array, signs: Array) -> Miss:
    angle = _made_parallel(h, signs, 1, 2)
    return None if _skewness(h, 0, 1) < _SKEW else _with_wrist(layout.PARALLEL_23, h, c, angle, 0.0)


def _intersecting_12(h: Array, c: Array, _: Array) -> Miss:
    return None if _skewness(h, 0, 1) < _SKEW else _with_wrist(layout.INTERSECTING_12, h, c, 0.0, _made_intersecting(h, c, 0, 1))


def _parallel_12(h: Array, c: Array, signs: Array) -> Miss:
    angle = _made_parallel(h, signs, 0, 1)
    return None if _skewness(h, 1, 2) < _SKEW else _with_wrist(layout.PARALLEL_12, h, c, angle, 0.0)


def _intersecting_23(h: Array, c: Array, _: Array) -> Miss:
    return None if _skewness(h, 1, 2) < _SKEW else _with_wrist(layout.INTERSECTING_23, h, c, 0.0, _made_intersecting(h, c, 1, 2))


def _offset_hand(h: Array, c: Array, signs: Array) -> Miss:
    angle = max(_made_parallel(h, signs, 1, 2), _made_parallel(h, signs, 1, 3))
    if min(_skewness(h, 0, 1), _skewness(h, 3, 4), _skewness(h, 4, 5)) < _SKEW_OF_QUARTIC:
        return None
    _made_near(h, c, 4, 5)
    return layout.OFFSET_HAND, angle, 0.0


def _any_three_axes(h: Array, c: Array, _: Array) -> Miss:
    if min(_skewness(h, 0, 1), _skewness(h, 1, 2)) < _SKEW_OF_QUARTIC:
        return None
    _made_near(h, c, 1, 2)
    return _with_wrist(layout.ANY_THREE_AXES, h, c, 0.0, 0.0)


def _least_offset(number: int, h: Array, c: Array) -> float:
    """The least of the lengths by which a quartic is divided [m]."""
    if number == layout.OFFSET_HAND:
        return float(np.linalg.norm(c[5] - c[4]))
    return float(min(np.linalg.norm(c[2] - c[1]), np.linalg.norm(np.cross(h[2], c[3] - c[2]))))


def _slide_parallel_23(h: Array, c: Array, signs: Array) -> Miss:
    angle = _made_parallel(h, signs, 1, 2)
    return None if abs(h[0] @ h[1]) < _SKEW else _with_wrist(layout.SLIDE_PARALLEL_23, h, c, angle, 0.0)


def _slide_intersecting_23(h: Array, c: Array, _: Array) -> Miss:
    return _with_wrist(layout.SLIDE_INTERSECTING_23, h, c, 0.0, _made_intersecting(h, c, 1, 2))


def _intersecting_12_slide(h: Array, c: Array, _: Array) -> Miss:
    return _with_wrist(layout.INTERSECTING_12_SLIDE, h, c, 0.0, _made_intersecting(h, c, 0, 1))


def _parallel_12_slide(h: Array, c: Array, signs: Array) -> Miss:
    angle = _made_parallel(h, signs, 0, 1)
    return None if abs(h[2] @ h[0]) < _SKEW else _with_wrist(layout.PARALLEL_12_SLIDE, h, c, angle, 0.0)


def _turn_slides(h: Array, c: Array, _: Array) -> Miss:
    across = np.cross(h[1], h[2])
    ill = min(_skewness(h, 1, 2), float(np.linalg.norm(np.cross(h[0], across)))) < _SKEW
    return None if ill else _with_wrist(layout.TURN_SLIDES, h, c, 0.0, 0.0)


def _slides_turn(h: Array, c: Array, _: Array) -> Miss:
    across = np.cross(h[0], h[1])
    ill = min(_skewness(h, 0, 1), float(np.linalg.norm(np.cross(h[2], across)))) < _SKEW
    return None if ill else _with_wrist(layout.SLIDES_TURN, h, c, 0.0, 0.0)


def _three_slides(h: Array, c: Array, _: Array) -> Miss:
    return None if abs(np.linalg.det(h[:3])) < _SKEW else _with_wrist(layout.THREE_SLIDES, h, c, 0.0, 0.0)


# By which of the first three joints slide.
_MAKERS = {
    (False, False, False): (
        _three_parallel,
        _parallel_23,
        _intersecting_12,
        _parallel_12,
        _intersecting_23,
        _offset_hand,
        _any_three_axes,
    ),
    (True, False, False): (_slide_parallel_23, _slide_intersecting_23),
    (False, False, True): (_intersecting_12_slide, _parallel_12_slide),
    (False, True, True): (_turn_slides,),
    (True, True, False): (_slides_turn,),
    (True, True, True): (_three_slides,),
}


def _with_wrist(number: int, h: Array, c: Array, angle: float, length: float) -> Miss:
    """The miss, together with that of the last three axes, which are made to intersect."""
    if min(_skewness(h, 3, 4), _skewness(h, 4, 5)) < _SKEW:
        return None
    c[3:], away = nearest_point(h[3:], c[3:])
    return number, angle, max(length, away)


def _skewness(h: Array, i: int, j: int) -> float:
    """The sine of the angle between two axes."""
    return float(np.linalg.norm(np.cross(h[i], h[j])))


def _made_parallel(h: Array, signs: Array, i: int, j: int) -> float:
    """Turn axis j to the direction of axis i, or the opposite of it, and note that; the angle that it misses."""
    signs[j] = 1.0 if h[i] @ h[j] >= 0.0 else -1.0
    missed = _skewness(h, i, j)
    h[j] = h[i]
    return missed


def _made_intersecting(h: Array, c: Array, i: int, j: int) -> float:
    """Move the points of two axes to where they intersect; the distance between the axes."""
    normal, way = np.cross(h[i], h[j]), c[j] - c[i]
    square = normal @ normal
    if square < _SKEW**2:
        return np.inf
    _made_near(h, c, i, j)
    c[i] = c[j] = (c[i] + c[j]) / 2.0
    return float(abs(way @ normal) / np.sqrt(square))


def _made_near(h: Array, c: Array, i: int, j: int) -> None:
    """Move the points of two skew axes to where each is nearest to the other."""
    normal, way = np.cross(h[i], h[j]), c[j] - c[i]
    square = normal @ normal
    c[i], c[j] = c[i] + h[i] * (np.cross(way, h[j]) @ normal / square), c[j] + h[j] * (np.cross(way, h[i]) @ normal / square)
