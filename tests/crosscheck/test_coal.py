"""Box against box: verdicts and depths against Coal, and depths against a separating-axis test in extended precision.

Where Coal can be trusted: it is asked for a tolerance of 1e-12, for with its own of 1e-6 it calls boxes up to 2e-6 m apart
overlapping, and its depths of nearly parallel boxes are up to 1.3e-6 m off. So asked its depths are good to 1e-10 m, and its
verdicts too, but for bodies with nearly parallel edges: there it may call free what overlaps by 1e-6 m.
"""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from coal_boxes import as_coal, distance, overlap
from ulna.kernels import layout

PAIRS = 2500  # a family: 22 500 in all
CONTACT = 1e-9  # [m] nearer to touching than this, either verdict is right
LONE_BOX = """<robot name="lone">
  <link name="world"/>
  <link name="lone"><collision name="lone"><geometry><box size="{size}"/></geometry></collision></link>
  <joint name="flight" type="floating"><parent link="world"/><child link="lone"/><origin xyz="{xyz}" rpy="{rpy}"/></joint>
</robot>"""


def scattered(rng, reach):
    return np.hstack([rng.uniform(-reach, reach, (PAIRS, 3)), rng.uniform(-np.pi, np.pi, (PAIRS, 3))])


def nearly_parallel(rng, reach):
    """Right angles, and about them tilts of 1e-12 to 0.1 rad: on both sides of where edges stop giving an axis."""
    q = scattered(rng, reach)
    tilt = rng.normal(size=(PAIRS, 3)) * 10.0 ** rng.uniform(-12, -1, (PAIRS, 1))
    q[:, 3:] = rng.integers(-2, 3, (PAIRS, 3)) * np.pi / 2 + tilt
    return q


def on_one_table(rng, reach):
    """Exactly parallel, the lower faces in one plane."""
    q = scattered(rng, reach)
    q[:, 2], q[:, 3:] = (0.4 - 0.1) / 2, 0.0
    return q


def stacked(rng, reach):
    """Exactly parallel, one upon the other, but for a gap of 2e-9 to 1e-3 m, open or overlapping."""
    q = on_one_table(rng, reach)
    q[:, 2] = (0.4 + 0.1) / 2 + 10.0 ** rng.uniform(-8.7, -3, PAIRS) * rng.choice([-1, 1], PAIRS)
    return q


def crossed(rng, reach):
    """Bars edge upon edge at an angle of 1e-10 to 1 rad, by 1e-6 to 1e-2 m apart or not: the product of two edges decides."""
    eighth = pin.rpy.rpyToMatrix(np.pi / 4, 0, 0)
    angle = 10.0 ** rng.uniform(-10, 0, PAIRS) * rng.choice([-1, 1], PAIRS)
    gap = 10.0 ** rng.uniform(-6, -2, PAIRS) * rng.choice([-1, 1], PAIRS)
    rpy = [pin.rpy.matrixToRpy(eighth.T @ pin.rpy.rpyToMatrix(0, 0, a) @ eighth) for a in angle]
    aside = rng.uniform(-reach, reach, (PAIRS, 2)) * [1, 1e-3]
    return np.hstack([np.column_stack([aside, 0.02 * np.sqrt(2) + gap]) @ eighth, rpy])


TURNED, SQUARE = ((0.1, -0.2, 0.3), (0.3, 0.2, -0.5)), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
# extents of the flying box and of the crate [m], where the crate stands, and how the box flies about it
FAMILIES = {
    "boxes of one size": ((0.3, 0.2, 0.4), (0.25, 0.5, 0.1), TURNED, scattered, 0.4),
    "long thin boxes": ((1.0, 0.01, 0.01), (0.01, 1.2, 0.02), TURNED, scattered, 0.15),
    "a needle and a sheet": ((2.0, 0.001, 0.001), (1.0, 1.0, 0.001), TURNED, scattered, 0.5),
    "a small box within and about a large one": ((0.05, 0.04, 0.03), (0.5, 0.6, 0.7), TURNED, scattered, 0.4),
    "a large box over and about a small one": ((0.5, 0.6, 0.7), (0.05, 0.04, 0.03), TURNED, scattered, 0.4),
    "nearly parallel boxes": ((0.3, 0.2, 0.4), (0.25, 0.5, 0.1), TURNED, nearly_parallel, 0.3),
    "bars crossed edge upon edge": ((1.0, 0.02, 0.02), (1.0, 0.02, 0.02), TURNED, crossed, 0.1),
    "boxes on one table": ((0.3, 0.2, 0.4), (0.25, 0.5, 0.1), SQUARE, on_one_table, 0.4),
    "boxes stacked": ((0.3, 0.2, 0.4), (0.25, 0.5, 0.1), SQUARE, stacked, 0.25),
}


def gap_by_separating_axes(a, T_a, b, T_b) -> float:
    """The widest gap over the fifteen axes, each normalized, in extended precision where the machine has it."""
    T_a, T_b = np.asarray(T_a, np.longdouble), np.asarray(T_b, np.longdouble)
    edges = np.concatenate([T_a[:3, :3].T, T_b[:3, :3].T])
    axes = [*edges, *(np.cross(u, v) for u in edges[:3] for v in edges[3:])]
    axes = np.array([n / np.sqrt(n @ n) for n in axes if n @ n > 1e-24])
    shadows = np.abs(axes @ edges.T) @ (np.concatenate([a, b]) / 2)
    return float((np.abs(axes @ (T_b[:3, 3] - T_a[:3, 3])) - shadows).max())


class Pairs:
    """One family: q is the pose of the flying box in the frame of the crate."""

    def __init__(self, name: str) -> None:
        self.a, self.b, (xyz, rpy), fly, reach = FAMILIES[name]
        words = {"size": self.a, "xyz": xyz, "rpy": rpy}
        self.robot = ulna.load(LONE_BOX.format(**{key: " ".join(map(repr, values)) for key, values in words.items()}))
        self.T_crate, self.world = ulna.pose(xyz, rpy), ulna.World()
        self.world.add("crate", ulna.Box(self.b), self.T_crate)
        self.q = fly(np.random.default_rng(len(name)), reach)
        self.T = self.T_crate @ ulna.pose(self.q[:, :3], self.q[:, 3:])
        # The product of nearly parallel edges has a direction that rounding turns by up to 1e-8 rad.
        self.delicate = fly in (nearly_parallel, crossed)
        self.exactness = 1e-8 if self.delicate else 1e-13  # [m]
        self.gaps = np.array([gap_by_separating_axes(self.a, T, self.b, self.T_crate) for T in self.T])
        self.verdicts = np.array([overlap(as_coal(self.a, T), as_coal(self.b, self.T_crate)) for T in self.T])


@pytest.fixture(scope="module", params=FAMILIES)
def family(request):
    return Pairs(request.param)


def wrong_verdicts(family, expected, judged) -> str:
    assert judged.mean() > 0.9
    assert 0.05 < expected.mean() < 0.95, "a family must have pairs of both kinds"
    wrong = np.flatnonzero(judged & (family.robot.in_collision(family.q, family.world) != expected))
    return f"{len(wrong)} of {PAIRS}, the first at q = {family.q[wrong[0]].tolist()}" if len(wrong) else ""


@pytest.mark.slow
def test_two_boxes_overlap_exactly_where_coal_says_so(family):
    assert not wrong_verdicts(family, family.verdicts, np.abs(family.gaps) > (2e-6 if family.delicate else CONTACT))


def test_two_boxes_overlap_exactly_where_no_axis_separates_them(family):
    assert not wrong_verdicts(family, family.gaps < 0, np.abs(family.gaps) > max(CONTACT, family.exactness))


def test_one_by_one_the_verdicts_are_those_of_the_batch(family):
    q = family.q[:200]
    one_by_one = [family.robot.in_collision(row, family.world) for row in q]
    assert one_by_one == family.robot.in_collision(q, family.world).tolist()
    assert one_by_one == [family.robot.check_collision(row, family.world).in_collision for row in q]


def overlapping(family, n: int = 300):
    """Pairs that overlap for sure, each with its row."""
    rows = np.flatnonzero(family.gaps < -CONTACT)[:n]
    assert len(rows) > 200
    for k in rows:
        (pair,) = family.robot.check_collision(family.q[k], family.world).pairs
        yield k, pair


def test_the_depth_is_that_of_the_separating_axes(family):
    for k, pair in overlapping(family):
        assert pair.signed_distance == pytest.approx(family.gaps[k], rel=0, abs=family.exactness)


def test_the_depth_is_coals(family):
    for k, pair in overlapping(family):
        if family.delicate and family.gaps[k] > -2e-6:
            continue
        expected = distance(as_coal(family.a, family.T[k]), as_coal(family.b, family.T_crate))
        assert pair.signed_distance == pytest.approx(expected, rel=0, abs=max(1e-9, family.exactness))


def moved_out(family, pair, margin):
    """Where the crate stands once it has gone out along the normal by the depth and a margin."""
    T = family.T_crate.copy()
    T[:3, 3] += (margin - pair.signed_distance) * pair.normal
    return T


@pytest.mark.slow
@pytest.mark.parametrize("margin", [1e-5, -1e-5], ids=["beyond", "short of"])
def test_moved_out_along_the_normal_a_box_is_free_just_beyond_the_depth(family, margin):
    for k, pair in overlapping(family):
        if -pair.signed_distance < abs(margin):
            continue
        T_moved = moved_out(family, pair, margin)
        gap = gap_by_separating_axes(family.a, family.T[k], family.b, T_moved)
        assert gap == pytest.approx(margin, rel=0, abs=family.exactness)
        assert overlap(as_coal(family.a, family.T[k]), as_coal(family.b, T_moved)) == (margin < 0)


def test_the_verdict_turns_within_the_margin_of_contact(family):
    world, margin = ulna.World(), 4 * family.exactness + layout.CONTACT * (sum(family.a) + sum(family.b))
    world.add("crate", ulna.Box(family.b))
    for k, pair in overlapping(family):
        if -pair.signed_distance < margin:
            continue
        for side in (1, -1):
            world.move("crate", moved_out(family, pair, side * margin))
            assert family.robot.in_collision(family.q[k], world) is (side < 0)
            assert family.robot.in_collision(family.q[k : k + 1], world).tolist() == [side < 0]


def test_boxes_that_just_touch_overlap_and_a_hair_apart_they_do_not():
    """Lengths that binary numbers hold exactly, so that the faces, edges or corners meet to the last bit."""
    robot, world, one = ulna.load(LONE_BOX.format(size="0.5 0.5 0.5", xyz="0 0 0", rpy="0 0 0")), ulna.World(), np.ones(3)
    world.add("crate", ulna.Box((0.25, 0.25, 0.25)))
    for direction in np.array([(0, 0, 1), (-1, 0, 0), (0, 1, 1), (1, -1, 0), (-1, 1, -1)]):
        touching = np.concatenate([0.375 * direction, 0 * one])
        apart = np.concatenate([(0.375 + 1e-7) * direction, 0 * one])
        assert robot.in_collision([touching, apart], world).tolist() == [True, False]
        assert [robot.in_collision(q, world) for q in (touching, apart)] == [True, False]
        (pair,) = robot.check_collision(touching, world).pairs
        assert pair.signed_distance == 0.0
        assert not robot.check_collision(apart, world).pairs
