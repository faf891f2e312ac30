"""The robot against itself: which pairs of links may touch, with what evidence, and what the queries make of it."""

import pickle

import numpy as np
import pytest

import formulas
import ulna
from ulna.collision import sampled_pairs
from ulna.collision.allowed import AllowedCollisions, LinkPair
from ulna.collision.entries import overlap
from ulna.errors import InputError, UnknownNameError

# Three cubes in a row on a rail of pegs: the hand slides over the middle one into the base.
ROW = """<robot name="row">
  <link name="base"><collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
  <link name="middle"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="hand"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="plate"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <joint name="a" type="fixed"><parent link="base"/><child link="middle"/><origin xyz="0.2 0 0"/></joint>
  <joint name="b" type="prismatic"><parent link="middle"/><child link="hand"/><origin xyz="0.8 0 0"/><axis xyz="-1 0 0"/>
    <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
  <joint name="c" type="fixed"><parent link="hand"/><child link="plate"/></joint>
</robot>"""


def pairs_by_reason(allowed):
    return {(pair.link_a[-1], pair.link_b[-1]): pair.reason for pair in allowed}


def test_the_links_of_the_panda_that_always_overlap_may_touch(panda):
    expected = {("1", "3"): "always", ("3", "4"): "adjacent", ("4", "5"): "adjacent", ("5", "7"): "always"}
    assert pairs_by_reason(panda.allowed_collisions) == expected


def test_what_was_never_seen_to_touch_is_a_candidate_and_stays_checked(panda):
    allowed = panda.allowed_collisions
    assert {str(pair) for pair in allowed.never_seen} == {
        "panda_link1 - panda_link4: never (0 of 2000)",
        "panda_link4 - panda_link7: never (0 of 2000)",
    }
    assert not any(pair in allowed for pair in allowed.never_seen)
    assert all(pair in allowed.plus(*allowed.never_seen) for pair in allowed.never_seen)


def test_the_evidence_counts_and_shows_a_configuration(panda):
    for pair in (*panda.allowed_collisions, *panda.allowed_collisions.checked):
        if pair.reason in ("always", "sometimes"):
            assert 0 < pair.touched <= pair.samples == 2000
            others = panda.with_allowed_collisions(AllowedCollisions(()))
            touching = {frozenset((p.link_a, p.link_b)) for p in others.check_collision(pair.q).pairs}
            assert pair.links in touching


@pytest.mark.parametrize(
    ("a", "b", "low", "high"), [(1, 5, 0.08, 0.10), (1, 7, 0.06, 0.075), (3, 7, 0.007, 0.013), (3, 5, 0.003, 0.009)]
)
def test_random_configurations_touch_as_often_as_the_boxes_of_the_assignment_do(panda, a, b, low, high):
    q = np.random.default_rng(5).uniform(panda.lower, panda.upper, (20_000, 7))
    everything = [
        (f"panda_link{i}", f"panda_link{j}")
        for i, j in ((1, 3), (1, 4), (1, 5), (1, 7), (3, 4), (3, 5), (3, 7), (4, 5), (4, 7), (5, 7))
    ]
    alone = (f"panda_link{a}", f"panda_link{b}")
    only = panda.with_allowed_collisions([pair for pair in everything if pair != alone])
    assert low < only.in_collision(q).mean() < high


def test_the_panda_is_free_at_home(panda):
    assert panda.in_collision(panda.home) is False
    assert not panda.check_collision(panda.home).pairs


def test_it_collides_where_any_pair_of_links_that_is_not_allowed_overlaps(panda, rng):
    """By the slow twin, over all 66 pairs of boxes."""
    q = rng.uniform(panda.lower, panda.upper, (40, 7))
    carriers = [(link.name, body) for link in panda.description.links for body in link.collisions]
    for row, collides in zip(q, panda.in_collision(q), strict=True):
        poses = dict(zip(panda.link_names, formulas.link_poses(panda.description, row), strict=True))
        touching = {
            frozenset((a, b))
            for k, (a, body_a) in enumerate(carriers)
            for b, body_b in carriers[:k]
            if formulas.gaps_of_boxes(
                poses[a] @ body_a.pose, body_a.shape.half_extents, poses[b] @ body_b.pose, body_b.shape.half_extents
            ).max() <= 0
        }  # fmt: skip
        wrong = {pair for pair in touching if len(pair) == 2 and tuple(pair) not in panda.allowed_collisions}
        assert bool(wrong) == collides == panda.in_collision(row)
        assert {frozenset((pair.link_a, pair.link_b)) for pair in panda.check_collision(row).pairs} == wrong


def test_links_that_no_joint_moves_and_links_of_one_joint_may_touch_and_others_may_not():
    robot = ulna.load(ROW)
    reasons = {(pair.link_a, pair.link_b): pair.reason for pair in robot.allowed_collisions}
    assert reasons == {("base", "middle"): "fixed", ("hand", "middle"): "adjacent", ("hand", "plate"): "fixed"}
    # The hand's cube meets the base's where q > 0.5 (their faces meet at 1 - q = 0.2 + 0.1 + 0.2 of the middle's offset).
    assert robot.in_collision([[0.69], [0.71]]).tolist() == [False, True]
    (pair,) = [p for p in robot.check_collision([0.75]).pairs if "hand" in (p.link_a, p.link_b)]
    assert (pair.link_a, pair.link_b) == ("base", "hand")
    assert pair.signed_distance == pytest.approx(-0.05, abs=1e-12)


def test_the_user_may_allow_and_forbid_pairs():
    robot = ulna.load(ROW)
    allowed = robot.allowed_collisions
    lenient = robot.with_allowed_collisions(allowed.plus(("hand", "base"), ("plate", "base")))
    assert not lenient.in_collision([1.0])
    strict = robot.with_allowed_collisions(allowed.minus(("hand", "middle")))
    assert strict.in_collision([0.65])
    assert not robot.in_collision([0.65])
    assert robot.allowed_collisions == allowed


def test_pairs_do_not_mind_the_order_of_their_links():
    allowed = AllowedCollisions((LinkPair("b", "a"),))
    assert ("a", "b") in allowed
    assert ("b", "a") in allowed
    assert ("a", "c") not in allowed
    assert "ab" not in allowed
    assert len(allowed.plus(("a", "b"), ("b", "a"))) == 1


def test_the_pairs_of_an_srdf_are_taken_as_its_reader_gives_them():
    class Disabled:
        link_a, link_b, reason = "hand", "base", "Never"

    found = ulna.load(ROW).allowed_collisions
    *others, pair = ulna.load(ROW).with_allowed_collisions([Disabled()]).allowed_collisions
    assert str(pair) == "base - hand: never"
    assert tuple(others) == found.pairs


def test_srdf_text_holds_every_pair_with_its_reason():
    text = ulna.load(ROW).allowed_collisions.to_srdf("row & column")
    assert '<robot name="row &amp; column">' in text
    assert '<disable_collisions link1="base" link2="middle" reason="Fixed"/>' in text
    assert text.count("<disable_collisions") == 3


def test_self_collision_can_be_left_out(panda):
    q = np.array(panda.allowed_collisions.checked[1].q)
    assert panda.in_collision(q) is True
    assert panda.in_collision(q, ulna.World(), self_collision=False) is False


def test_asking_for_nothing_is_an_error(panda):
    with pytest.raises(InputError, match="nothing to check"):
        panda.in_collision(panda.home, self_collision=False)


@pytest.mark.parametrize("pairs", [[("hand",)], ["hand"], [("hand", 3)], [("hand", "hand")]])
def test_what_is_not_a_pair_of_links_is_refused(pairs):
    with pytest.raises(InputError):
        ulna.load(ROW).with_allowed_collisions(pairs)


def test_an_unknown_link_is_reported_with_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'hand'"):
        ulna.load(ROW).with_allowed_collisions([("hnd", "base")])
    with pytest.raises(UnknownNameError, match="allowed pair"):
        ulna.load(ROW).allowed_collisions.minus(("hand", "base"))


def test_the_choice_of_the_user_outlives_a_pickle_and_a_tool(panda):
    robot = panda.with_allowed_collisions([("panda_link1", "panda_link7")])
    for same in (pickle.loads(pickle.dumps(robot)), robot.with_tool(np.eye(4))):  # noqa: S301 - our own bytes
        *found, added = same.allowed_collisions
        assert tuple(found) == panda.allowed_collisions.pairs
        assert str(added) == "panda_link1 - panda_link7: user"


def test_what_touches_at_a_configuration_that_is_known_to_be_free_may_be_allowed(panda):
    strict = panda.with_allowed_collisions(AllowedCollisions(()))
    folded = np.array(next(pair for pair in panda.allowed_collisions.checked if pair.touched).q)
    for robot, q in ((strict, panda.home), (panda, folded)):
        assert robot.in_collision(q)
        lenient = robot.with_allowed_collisions(at=q)
        assert not lenient.in_collision(q)
        added = {pair.links for pair in lenient.allowed_collisions} - {pair.links for pair in robot.allowed_collisions}
        assert added == {frozenset((pair.link_a, pair.link_b)) for pair in robot.check_collision(q).pairs}
    with pytest.raises(InputError, match="at: shape"):
        panda.with_allowed_collisions(at=[panda.home] * 2)
    with pytest.raises(UnknownNameError):
        panda.with_allowed_collisions(at="no such state")


def test_what_touches_in_a_share_of_the_samples_may_be_allowed(panda):
    counted = panda.allowed_collisions.checked
    most = max(pair.touched / pair.samples for pair in counted)
    assert 0 < most < 0.95
    assert panda.with_allowed_collisions(touching=0.95).allowed_collisions.pairs == panda.allowed_collisions.pairs
    some = panda.with_allowed_collisions(touching=most / 2).allowed_collisions
    expected = {pair.links for pair in counted if pair.touched / pair.samples >= most / 2}
    assert expected == {pair.links for pair in some} - {pair.links for pair in panda.allowed_collisions}
    bare = panda.with_allowed_collisions(AllowedCollisions(())).with_allowed_collisions(touching=most / 2)
    assert {pair.links for pair in bare.allowed_collisions} == expected, "the samples are the robot's, whatever pairs were given"
    for wrong in (0, 1.5, True, "95 %"):
        with pytest.raises(InputError, match="touching"):
            panda.with_allowed_collisions(touching=wrong)


# A plate turns on the base, face on face; another has a gap of 10 um to the base; a peg slides out of it.
TURNING = """<robot name="turning">
  <link name="base"><collision><geometry>{shape}</geometry></collision></link>
  <link name="post"/>
  <link name="plate"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="hidden"/>
  <link name="above"><collision><origin xyz="0 0 0.30001"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="peg"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.2 0.02 0.02"/></geometry></collision></link>
  <joint name="a" type="continuous"><parent link="base"/><child link="post"/><axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="post"/><child link="plate"/><axis xyz="0 0 1"/></joint>
  <joint name="c" type="continuous"><parent link="post"/><child link="hidden"/><axis xyz="0 0 1"/></joint>
  <joint name="d" type="continuous"><parent link="hidden"/><child link="above"/><axis xyz="0 0 1"/></joint>
  <joint name="e" type="prismatic"><parent link="post"/><child link="peg"/><origin xyz="-0.1 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
</robot>"""
FIRST_QUESTIONS = {
    "the counts": lambda robot, _: robot.allowed_collisions,
    "contact at one q": lambda robot, q: robot.in_collision(q),
    "contact at each q": lambda robot, q: robot.in_collision([q, q]),
    "a distance": lambda robot, q: robot.signed_distance(q),
    "the pairs": lambda robot, q: robot.check_collision(q),
}


@pytest.mark.parametrize("shape", ['<box size="0.4 0.4 0.4"/>', '<cylinder radius="0.2" length="0.4"/>'], ids=["box", "cylinder"])
@pytest.mark.parametrize("first", FIRST_QUESTIONS)
def test_which_pairs_are_checked_does_not_depend_on_the_first_question(shape, first):
    """Also where faces lie on each other: the entries that may find the pairs are compiled apart, and round apart."""
    robot = ulna.load(TURNING.format(shape=shape))
    FIRST_QUESTIONS[first](robot, robot.home)
    checked = {frozenset((pair.link_a, pair.link_b)) for pair in robot.check_collision(robot.home, max_distance=10.0).pairs}
    always = {pair.links for pair in robot.allowed_collisions if pair.reason == "always"}
    assert always == {frozenset(("base", "plate")), frozenset(("above", "plate"))}
    assert checked == {frozenset(pair) for pair in (("base", "above"), ("base", "peg"), ("plate", "peg"), ("above", "peg"))}


def test_robots_that_differ_in_what_is_attached_find_the_pairs_once(panda):
    with_cup = panda.with_attached("cup", ulna.Box((0.05, 0.05, 0.1)), np.eye(4))
    assert with_cup.without_attached("cup").allowed_collisions is with_cup.allowed_collisions is panda.allowed_collisions
    assert panda.with_tool(np.eye(4)).allowed_collisions is not panda.allowed_collisions


FIRST_CALLS = {
    "one": lambda robot, world: robot.in_collision(robot.home, world),
    "batch": lambda robot, world: robot.in_collision(robot.random(9, seed=1), world),
    "distance": lambda robot, world: robot.signed_distance(robot.home, world),
    "edge": lambda robot, world: robot.edge_in_collision(robot.home, robot.home + 0.1, world),
    "report": lambda robot, world: robot.check_collision(robot.home, world),
}


@pytest.mark.parametrize("first", FIRST_CALLS)
def test_the_pairs_are_found_by_one_entry_whatever_is_called_first(panda, first, monkeypatch):
    robot, world, taken = ulna.load("panda"), ulna.World(), set()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((1, 0, 0)))

    class Recorded:
        def __getattr__(self, name):
            taken.add(name)
            return getattr(overlap, name)

    monkeypatch.setattr(sampled_pairs, "overlap", Recorded())
    FIRST_CALLS[first](robot, world)
    assert taken == {"overlap_one"}
    assert np.array_equal(robot._checker.pairs, panda.with_allowed_collisions(panda.allowed_collisions)._checker.pairs)
