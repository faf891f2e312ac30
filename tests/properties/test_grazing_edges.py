"""No edge that is called free touches: needles, plates of kilometers, many turns, mimic joints, held shapes, clouds.

``python -m benchmarks.edges`` searches for a counterexample among as many as there is time for.
"""

import numpy as np
import pytest

import grazing
import solids
import ulna

pytestmark = pytest.mark.filterwarnings("ignore::ulna.UnitWarning")  # there are plates of kilometers
I = np.eye(4)  # noqa: E741
# Once called free: a box's extents, an obstacle, and both ends. The search for the distance stalled, and its upper bound passed
# for the distance.
ONCE_FREE = {
    "a wire of 8 m": (
        (0.010341204773051579, 0.01265704594460784, 0.20818811790599104),
        ulna.Cylinder(0.0001159844903690051, 7.566047257485048),
        (0.06815621426975317, -0.037273932731577836, 2.8518053096294813, 0.8077137905856939, 0.35554591740347163,
         -2.4045701736343013),
        (0.06813940997916448, -0.03688744352634941, 2.851805309744969, 0.8077137905856939, 0.35554591740347163,
         -2.4045701736343013),
    ),
    "a wire of 86 m": (
        (0.015343115332987258, 0.08747796075793665, 0.0032179158367730376),
        ulna.Cylinder(0.0005725464807922496, 85.96162192881896),
        (0.02946045587571286, 0.024315826245162195, -40.14922498112859, -1.7672856275651394, -0.6360649057164167,
         0.939570180729544),
        (0.02942520434621235, 0.02289960232559602, -40.14922498327303, -1.7672856275651394, -0.6360649057164167,
         0.939570180729544),
    ),
    "a wire of 808 m": (
        (0.39777673868966, 0.004665640779047404, 0.1594884895047553),
        ulna.Cylinder(0.008901922850238204, 808.0849330304924),
        (-0.18594101778049038, -0.11364510031370062, -376.69534774717175, 0.3837601424172248, 2.454101271221411,
         -0.5864873550054961),
        (-0.17481279102760847, -0.11279153715582338, -376.69534774727765, 0.3837601424172248, 2.454101271221411,
         -0.5864873550054961),
    ),
    "a plate of kilometers": (
        (0.01551201999836725, 0.13229085608445523, 0.06219734163884644),
        ulna.ConvexMesh(grazing.corners((2309.999073038901, 0.0035688204910846455, 4906.656959897858))),
        (1155.1070215933796, 0.0014611970522371833, 2280.1615967994926, 2.830914573583491, 1.963133884173656,
         -1.427483965144419),
        (1155.0679484104833, 0.0014404825990339495, 2280.1615968029264, 2.830914573583491, 1.963133884173656,
         -1.427483965144419),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", ONCE_FREE)
def test_an_edge_that_was_called_free_and_ends_in_contact_is_a_collision(case):
    extents, obstacle, a, b = ONCE_FREE[case]
    robot, world = grazing.mover(ulna.Box(extents), I), ulna.World()
    world.add("obstacle", obstacle)
    found = robot.edge_in_collision(a, b, world, self_collision=False)
    assert robot.in_collision(b, world, self_collision=False)
    assert found.in_collision
    assert 0 < found.free_until < 1


@pytest.mark.slow
@pytest.mark.parametrize("obstacle", grazing.OBSTACLES)
@pytest.mark.parametrize("kind", grazing.KINDS)
def test_an_edge_on_which_two_bodies_share_a_point_is_never_called_free(rng, kind, obstacle):
    approached = 0
    for _ in range(40):
        robot, world, a, b = grazing.grazing_edges(rng, kind, obstacle, 8)
        found = robot.edge_in_collision(a, b, world, self_collision=False, resolution=1e-5)
        assert found.in_collision.all()
        approached += np.count_nonzero(found.free_until > 0)
    assert approached > 40, "most begin apart"


@pytest.mark.slow
@pytest.mark.parametrize("pair", solids.PAIRS, ids="-".join)
def test_what_is_certain_of_a_distance_is_near_the_distance(rng, pair):
    """Needles and plates too: a bound that were far below would be certain, and of no use."""
    lost = []
    for _ in range(20):
        robot, world, a, _ = grazing.grazing_edges(rng, *pair, 8)
        apart = robot.signed_distance(a, world, self_collision=False)
        for q, distance in zip(a, apart, strict=True):
            if distance > 3e-5:
                lost.append(robot.edge_in_collision(q, q, world, self_collision=False, resolution=1e-5).in_collision)
    assert len(lost) > 20
    assert not any(lost)


def test_far_from_the_origin_rounding_is_counted():
    """A box of 0.2 m that ends a rounding error short of a wall, 15 km from the base: too near to be called free for certain."""
    robot, world = grazing.mover(ulna.Box((0.2, 0.2, 0.2)), I), ulna.World()
    far = 15_000.0
    world.add("wall", ulna.Box((1, 1, 1)), ulna.pose((far + 0.6, 0, 0)))
    gap = 1e-13 * far
    q = np.array([far - gap, 0, 0, 0, 0, 0])
    assert robot.edge_in_collision(q - [0.01, 0, 0, 0, 0, 0], q, world, self_collision=False).in_collision
