"""The Panda's twelve boxes: the assignment's table through Pinocchio's links, and Coal's verdicts over all of them."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from coal_boxes import as_coal, distance, overlap

# The table of the assignment, section 5: link, translation [m], quaternion (w, x, y, z), size [m]
TABLE = [
    (1, (-0.04, 0, -0.283), (1, 0, 0, 0), (0.23, 0.2, 0.1)),
    (1, (-0.009, 0, -0.183), (1, 0, 0, 0), (0.13, 0.12, 0.1)),
    (1, (0, -0.032, -0.082), (0.9514, 0.3079, 0, 0), (0.12, 0.1, 0.2)),
    (1, (-0.008, 0, 0), (1, 0, 0, 0), (0.15, 0.27, 0.11)),
    (1, (0, 0.042, 0.067), (0.9514, 0.3079, 0, 0), (0.12, 0.1, 0.2)),
    (3, (0.00687, 0, -0.139), (1, 0, 0, 0), (0.13, 0.12, 0.25)),
    (4, (-0.008, 0.004, 0), (0.7071, -0.7071, 0, 0), (0.13, 0.23, 0.15)),
    (5, (0.00422, 0.05367, -0.121), (0.9962, -0.08715, 0, 0), (0.12, 0.12, 0.4)),
    (5, (0.00422, 0.00367, -0.263), (1, 0, 0, 0), (0.12, 0.12, 0.25)),
    (5, (0.00328, 0.0176, -0.0055), (1, 0, 0, 0), (0.13, 0.23, 0.12)),
    (7, (-0.0136, 0.0092, 0.0083), (0, 1, 0, 0), (0.12, 0.12, 0.2)),
    (7, (-0.0136, 0.0092, 0.1407), (0.9239, 0, 0, -0.3827), (0.08, 0.22, 0.17)),
]
CRATE = (0.15, 0.09, 0.126)
NAMES = tuple(f"box {k}" for k in range(1, 13))


class Boxes:
    """The table upon Pinocchio's links."""

    def __init__(self, robot) -> None:
        self.model = pin.buildModelFromXML(robot.to_urdf())
        self.data = self.model.createData()

    def poses(self, q) -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, np.asarray(q))
        poses = []
        for link, translation, (w, x, y, z), _ in TABLE:
            T_base_link = self.data.oMf[self.model.getFrameId(f"panda_link{link}")]
            rotation = pin.Quaternion(w, x, y, z).normalized().matrix()
            poses.append((T_base_link * pin.SE3(rotation, np.array(translation))).homogeneous)
        return np.array(poses)

    def at(self, q) -> list:
        return [as_coal(size, T) for (*_, size), T in zip(TABLE, self.poses(q), strict=True)]


@pytest.fixture(scope="module")
def boxes(panda):
    return Boxes(panda)


def world_of(extents, T) -> ulna.World:
    world = ulna.World()
    world.add("crate", ulna.Box(extents), T)
    return world


def random_positions(panda, n: int) -> np.ndarray:
    return np.random.default_rng(12).uniform(panda.lower, panda.upper, (n, 7))


def test_the_boxes_stand_where_the_table_of_the_assignment_puts_them(panda, boxes):
    assert panda.collision_names == NAMES
    for q in (panda.home, np.zeros(7), *random_positions(panda, 20)):
        np.testing.assert_allclose(panda.collision_poses(q), boxes.poses(q), rtol=0, atol=1e-12)
    sizes = [body.shape.extents for link in panda.description.links for body in link.collisions]
    assert sizes == [size for *_, size in TABLE]


@pytest.mark.parametrize(
    ("xyz", "rpy"), [((0.5, 0, 0.21), (0, 0, 0)), ((0.3, -0.2, 0.6), (0.4, 1.1, -0.7))], ids=["as in the demo", "turned"]
)
def test_two_thousand_configurations_collide_exactly_where_coal_says_so(panda, boxes, xyz, rpy):
    T, q = ulna.pose(xyz, rpy), random_positions(panda, 2000)
    crate = as_coal(CRATE, T)
    expected = np.array([[overlap(box, crate) for box in boxes.at(row)] for row in q])
    world = world_of(CRATE, T)
    hits = panda.in_collision(q, world, self_collision=False)
    assert 0.02 < hits.mean() < 0.98
    np.testing.assert_array_equal(hits, expected.any(axis=1))
    for row, of_boxes in zip(q[:200], expected, strict=False):
        report = panda.check_collision(row, world, self_collision=False)
        assert report.touching == tuple(name for name, touched in zip(NAMES, of_boxes, strict=True) if touched)
        assert panda.in_collision(row, world, self_collision=False) is report.in_collision


def test_several_crates_collide_where_any_of_them_does(panda):
    q, rng = random_positions(panda, 500), np.random.default_rng(3)
    poses = ulna.pose(rng.uniform((-0.8, -0.8, 0), (0.8, 0.8, 1.2), (5, 3)), rng.uniform(-3, 3, (5, 3)))
    together, single = ulna.World(), np.zeros(500, dtype=bool)
    for k, T in enumerate(poses):
        together.add(f"crate {k}", ulna.Box(CRATE), T)
        single |= panda.in_collision(q, world_of(CRATE, T), self_collision=False)
    np.testing.assert_array_equal(panda.in_collision(q, together, self_collision=False), single)
    assert not panda.in_collision(q, ulna.World(), self_collision=False).any()


@pytest.mark.parametrize("k", range(12), ids=NAMES)
def test_a_crate_wholly_within_a_box_of_the_robot_is_found(panda, boxes, k):
    """Its surface is nowhere near that of the box: a checker that tests surfaces would call it free."""
    T, extents = boxes.poses(panda.home)[k], (0.01, 0.008, 0.006)
    world = world_of(extents, T @ ulna.pose((0.01, -0.008, 0.012), (0.3, 0.2, 0.1)))
    assert panda.in_collision(panda.home, world) is True
    assert panda.in_collision([panda.home] * 3, world).tolist() == [True] * 3
    report = panda.check_collision(panda.home, world, self_collision=False)
    crate = as_coal(extents, world.pose("crate"))
    assert NAMES[k] in report.touching
    for pair in report.pairs:
        depth = distance(boxes.at(panda.home)[NAMES.index(pair.name_a)], crate)
        assert pair.signed_distance == pytest.approx(depth, rel=0, abs=1e-9)


def test_a_robot_wholly_within_a_huge_crate_touches_it_with_every_box(panda, boxes):
    extents, T = (9.0, 8.0, 10.0), ulna.pose((0.2, -0.1, 0.3), (0.5, 0.4, 0.3))
    world = world_of(extents, T)
    assert panda.in_collision(random_positions(panda, 50), world).all()
    report = panda.check_collision(panda.home, world, self_collision=False)
    assert report.touching == NAMES
    assert [pair.signed_distance for pair in report.pairs] == sorted(pair.signed_distance for pair in report.pairs)
    for pair in report.pairs:
        depth = distance(boxes.at(panda.home)[NAMES.index(pair.name_a)], as_coal(extents, T))
        assert pair.signed_distance == pytest.approx(depth, rel=0, abs=1e-8)


def test_a_pair_names_the_box_the_crate_and_the_link(panda):
    report = panda.check_collision(panda.home, world_of(CRATE, ulna.pose((0, 0, 0.333))))
    link_of = {pair.name_a: pair.link_a for pair in report.pairs}
    assert {pair.name_b for pair in report.pairs} == {"crate"}
    assert link_of == {name: f"panda_link{TABLE[NAMES.index(name)][0]}" for name in report.touching}
    assert str(report) == "collision: " + ", ".join(report.touching)


@pytest.fixture
def checked(panda):
    """The pairs of the arm's own boxes that are checked, by their rows in the table."""
    links = [f"panda_link{link}" for link, *_ in TABLE]
    return [
        (i, j)
        for j in range(12)
        for i in range(j)
        if links[i] != links[j] and (links[i], links[j]) not in panda.allowed_collisions
    ]


def test_the_arm_collides_with_itself_exactly_where_coal_says_so(panda, boxes, checked):
    q = random_positions(panda, 500)
    assert len(checked) == 37
    expected = [any(overlap(at[i], at[j]) for i, j in checked) for at in map(boxes.at, q)]
    assert 0.05 < np.mean(expected) < 0.2
    assert panda.in_collision(q).tolist() == expected


def test_the_least_distance_to_crates_and_to_itself_is_coals(panda, boxes, checked):
    q, rng, world = random_positions(panda, 60), np.random.default_rng(4), ulna.World()
    poses = ulna.pose(rng.uniform((-0.8, -0.8, 0), (0.8, 0.8, 1.2), (3, 3)), rng.uniform(-3, 3, (3, 3)))
    for k, T in enumerate(poses):
        world.add(f"crate {k}", ulna.Box(CRATE), T)
    crates = [as_coal(CRATE, T) for T in poses]
    for row, to_world, to_all in zip(
        q, panda.signed_distance(q, world, self_collision=False), panda.signed_distance(q, world), strict=True
    ):
        at = boxes.at(row)
        expected = min(distance(box, crate) for box in at for crate in crates)
        itself = min(distance(at[i], at[j]) for i, j in checked)
        assert to_world == pytest.approx(expected, rel=0, abs=1e-6)
        assert to_all == pytest.approx(min(expected, itself), rel=0, abs=1e-6)
