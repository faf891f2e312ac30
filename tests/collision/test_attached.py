"""What the robot holds moves with its link and is checked like the robot's own shapes."""

import pickle

import numpy as np
import pytest

import ulna
from ulna.errors import InputError, UnknownNameError

CUP, ABOVE = ulna.Box((0.06, 0.06, 0.12)), ulna.pose((0, 0, 0.08))


@pytest.fixture
def holding(panda):
    return panda.with_attached("cup", CUP, ABOVE, touch_links=["panda_link7"])


def test_the_robot_itself_is_not_changed(panda, holding):
    assert panda.attached == ()
    assert [held.name for held in holding.attached] == ["cup"]
    assert holding.tip == panda.tip
    assert holding.collision_names == (*panda.collision_names, "cup")


def test_it_is_where_the_link_holds_it(panda, holding):
    poses = holding.collision_poses(panda.home)
    np.testing.assert_allclose(poses[-1], panda.forward_kinematics(panda.home) @ ABOVE, rtol=0, atol=1e-14)


def test_it_collides_with_the_world_where_a_crate_of_its_shape_would(panda, holding, rng):
    world, cup = ulna.World(), ulna.World()
    world.add("shelf", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.45, 0, 0.3)))
    q = rng.uniform(panda.lower, panda.upper, (300, 7))
    verdicts = holding.in_collision(q, world, self_collision=False)
    arm = panda.in_collision(q, world, self_collision=False)
    box = ulna.load(
        '<robot name="cup"><link name="l"><collision><geometry><box size="0.06 0.06 0.12"/></geometry></collision></link></robot>'
    )
    for k, row in enumerate(q):
        T_cup = panda.forward_kinematics(row) @ ABOVE
        cup = ulna.World()
        cup.add("shelf", ulna.Box((0.3, 0.3, 0.3)), np.linalg.inv(T_cup) @ ulna.pose((0.45, 0, 0.3)))
        assert verdicts[k] == (arm[k] or box.in_collision([], cup))
    assert (verdicts & ~arm).any()


def test_it_is_checked_against_the_links_but_the_one_that_holds_it_and_those_that_may_touch(panda, holding):
    assert holding.in_collision(panda.home) is False  # it overlaps box 12 of link 7
    bare = panda.with_attached("cup", CUP, ABOVE)
    assert bare.in_collision(panda.home) is False  # no joint moves link 7 against the tip
    large = panda.with_attached("plank", ulna.Box((1.2, 0.02, 0.02)), ABOVE)
    (pair,) = (
        large.with_attached("crumb", ulna.Box((0.01,) * 3), np.eye(4), link="panda_link0").check_collision(np.zeros(7)).pairs[:1]
    )
    assert {pair.name_a, pair.name_b} & {"plank"}


def test_touch_links_may_touch(panda):
    across = ulna.Box((0.9, 0.9, 0.02)), ulna.pose((0, 0, -0.15))
    touching = panda.with_attached("tray", *across).check_collision(panda.home)
    links = {pair.link_a for pair in touching.pairs} | {pair.link_b for pair in touching.pairs}
    assert touching.in_collision
    assert "tray" in links
    allowed = panda.with_attached("tray", *across, touch_links=links - {"tray"})
    assert not allowed.in_collision(panda.home)


def test_it_can_be_put_down(panda, holding):
    assert holding.without_attached("cup").collision_names == panda.collision_names
    with pytest.raises(UnknownNameError, match="did you mean 'cup'"):
        holding.without_attached("cupp")


@pytest.mark.parametrize(
    ("name", "T", "named", "error"),
    [
        ("panda_link1", np.eye(4), {}, InputError),
        ("cup", np.eye(4), {"link": "panda_link11"}, UnknownNameError),
        ("cup", np.eye(4), {"link": "panda_link1", "touch_links": ["finger"]}, UnknownNameError),
        ("cup", np.eye(4), {"link": "panda_link1", "touch_links": "panda_link7"}, InputError),
        ("cup", np.ones((4, 4)), {}, InputError),
        (3, np.eye(4), {}, InputError),
    ],
)
def test_an_invalid_attached_object_is_refused(panda, name, T, named, error):
    with pytest.raises(error):
        panda.with_attached(name, CUP, T, **named)


def test_two_objects_need_two_names(holding):
    with pytest.raises(InputError, match="already has"):
        holding.with_attached("cup", CUP, ABOVE)


def test_a_pickle_holds_it_too(panda, holding):
    same = pickle.loads(pickle.dumps(holding))  # noqa: S301 - our own bytes
    assert same.collision_names == holding.collision_names
    assert not same.attached[0].T_link_object.flags.writeable
    assert same.in_collision(panda.home) == holding.in_collision(panda.home)
