"""The methods of a robot whose entries are bound in C: the same answers, names, refusals and lifetimes as in Python."""

import gc
import pickle
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import ulna

METHODS = "forward_kinematics", "jacobian", "inverse_kinematics", "all_solutions", "in_collision", "signed_distance"


@pytest.fixture
def crate():
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.4)))
    return world


def test_links_frames_and_out_may_be_given_in_any_way(panda):
    q, T, J = panda.random(seed=1), np.empty((4, 4)), np.empty((6, 7))
    link = "panda_link4"
    for _ in range(2):  # the first call makes what the second finds
        expected = panda.compile_forward(link=link)(q)
        assert np.array_equal(panda.forward_kinematics(q, link=link), expected)
        assert np.array_equal(panda.forward_kinematics(q=q, link=link), expected)
        assert panda.forward_kinematics(q, link=link, out=T) is T
        assert np.array_equal(T, expected)
        assert panda.jacobian(q, out=J, link=link) is J
        assert np.array_equal(J, panda.jacobian(q, link=link, expressed_in="base"))
        assert not np.array_equal(J, panda.jacobian(q, link=link, expressed_in="link"))
        in_link = panda.compile_jacobian(link=link, expressed_in="link")(q)
        assert np.array_equal(panda.jacobian(q, link=link, expressed_in="link"), in_link)
        assert np.array_equal(panda.forward_kinematics(q, out=None), panda.forward_kinematics(q, link=None))


@pytest.mark.parametrize("link", ["panda_link99", 3, ["panda_link4"], np.zeros(2)])
def test_a_link_that_there_is_not_is_refused_by_name(panda, link):
    q = panda.random(seed=1)
    for call in (panda.forward_kinematics, panda.jacobian):
        with pytest.raises(ulna.UlnaError, match="link"):
            call(q, link=link)


def test_what_python_does_not_take_is_refused_as_by_a_function(panda):
    for name in METHODS:
        method = getattr(panda, name)
        with pytest.raises(TypeError, match="missing 1 required positional argument"):
            method()
        with pytest.raises(TypeError, match="unexpected keyword argument 'queue'"):
            method(panda.home, queue=1)
        with pytest.raises(TypeError, match="positional argument"):
            method(panda.home, None, None)


def test_a_world_that_has_changed_is_asked_again(panda, crate):
    q = panda.random(seed=2)
    for ask in (panda.in_collision, panda.signed_distance):
        alone = [ask(q), ask(q, None), ask(q, None, self_collision=True)]
        near = ask(q, crate)
        assert near == ask(q, world=crate) == ask(q, crate, self_collision=True)
        crate.add("about the hand", ulna.Sphere(0.05), panda.forward_kinematics(q))
        assert ask(q) == alone[0]
        assert ask(q, crate) != near
        crate.remove("about the hand")
        assert alone == [ask(q)] * 3
        assert ask(q, crate) == near
        assert type(near) is (bool if ask.__name__ == "in_collision" else float)


@pytest.mark.parametrize("more", [(), ("ball",)])
def test_an_object_that_moves_is_found_by_the_entry_that_was_bound_before(panda, crate, more):
    """Its scene is the same but for the rows of the table; a list takes Python's own way, which binds another."""
    for name in more:  # not only boxes
        crate.add(name, ulna.Sphere(0.05), ulna.pose((0, 0.5, 0.5)))
    q, rng, other, before, answers = panda.home, np.random.default_rng(5), ulna.load("panda"), crate.snapshot(), []
    at_first = other.signed_distance(q, before)
    panda.in_collision(q, crate), panda.signed_distance(q, crate)
    bound = panda._checker._last
    for T in [panda.forward_kinematics(q), *ulna.pose(rng.uniform(-0.8, 0.8, (50, 3)), rng.uniform(-3, 3, (50, 3)))]:
        crate.move("crate", T)
        answers.append((panda.in_collision(q, crate), panda.signed_distance(q, crate)))
        assert panda._checker._last is bound
        fresh = ulna.World()
        fresh.add_many(crate.items())
        assert answers[-1] == (other.in_collision(q.tolist(), fresh), other.signed_distance(q.tolist(), fresh))
    assert {touches for touches, _ in answers} == {True, False}
    assert panda.signed_distance(q.tolist(), crate) == answers[-1][1]
    crate.move("crate", panda.forward_kinematics(q))
    assert panda.signed_distance(q.tolist(), crate) == answers[0][1]
    assert panda.signed_distance(q, before) == at_first


def test_an_edge_in_c_has_the_report_of_python_bit_for_bit(panda, crate):
    rng, other, outcomes = np.random.default_rng(6), ulna.load("panda"), set()
    for q_a, way in zip(panda.random(60, seed=7), rng.normal(size=(60, 7)), strict=True):
        q_b = q_a + 0.3 * way
        crate.move("crate", ulna.pose(rng.uniform(-0.6, 0.6, 3), rng.uniform(-3, 3, 3)))
        expected = other.edge_in_collision(q_a.tolist(), q_b.tolist(), crate)
        for itself in ({}, {"self_collision": True}):
            report = panda.edge_in_collision(q_a, q_b, world=crate, **itself)
            assert type(report).__name__ == "EdgeReport"
            assert (type(report.in_collision), type(report.free_until)) == (bool, float)
            assert (report.in_collision, report.free_until, report.q.tobytes(), str(report)) == (
                expected.in_collision, expected.free_until, expected.q.tobytes(), str(expected),
            )  # fmt: skip
        assert panda.edge_in_collision(q_a, q_b, crate, resolution=0.1).free_until <= 1.0
        outcomes.add(report.in_collision)
    assert outcomes == {True, False}
    for wrong in (np.full(7, np.nan), np.full(7, 1e300), np.zeros(6)):
        with pytest.raises(ulna.InputError, match=r"^q_b"):
            panda.edge_in_collision(panda.home, wrong, crate)
        with pytest.raises(ulna.InputError, match=r"^q_a"):
            panda.edge_in_collision(wrong, panda.home, crate)
    for arguments in ((), (panda.home,), (panda.home, panda.home, crate, True)):
        with pytest.raises(TypeError, match="positional argument"):
            panda.edge_in_collision(*arguments)


def test_objects_that_links_may_touch_are_checked_as_in_python(panda, crate):
    q = panda.home
    assert not panda.in_collision(q, crate)
    crate.add("table", ulna.Box((2, 2, 0.02)), touch_links=panda.link_names)
    assert not panda.in_collision(q, crate)
    crate.add("ball", ulna.Sphere(0.05), panda.forward_kinematics(q))
    assert panda.in_collision(q, crate)


def test_a_result_of_one_target_is_as_that_of_many(panda):
    for q in panda.random(50, seed=3):
        T = panda.forward_kinematics(q)
        one, long = panda.inverse_kinematics(T), panda.inverse_kinematics(T, trace=True)
        assert one.q.tobytes() == long.q.tobytes()
        assert one.info.tobytes() == long.info.tobytes()
        assert (one.tolerances, str(one), one.collisions) == (long.tolerances, str(long), ())
        near = panda.inverse_kinematics(T, q_seed=q + 0.01, link=panda.tip)
        assert near.q.tobytes() == panda.inverse_kinematics(T, q + 0.01).q.tobytes()
        again = pickle.loads(pickle.dumps(one))  # noqa: S301 - our own
        assert again.q.tobytes() == one.q.tobytes()
        with pytest.raises(AttributeError, match="cannot be changed"):
            one.q = q


def test_a_target_without_a_solution_is_explained(panda):
    panda.inverse_kinematics(panda.forward_kinematics(panda.home))
    for T in (ulna.pose((3, 0, 0)), ulna.pose((0.02, 0, 0.1))):
        assert str(panda.inverse_kinematics(T)) == str(panda.inverse_kinematics(T.tolist()))
    with pytest.raises(ulna.InputError, match="not a pose"):
        panda.inverse_kinematics(np.ones((4, 4)))


def test_a_subclass_may_have_methods_of_its_own():
    class Counting(ulna.Robot):
        calls = 0

        def forward_kinematics(self, q, *, link=None, **named):
            type(self).calls += 1
            return super().forward_kinematics(q, link=link, **named)

    robot = Counting(ulna.load("panda").description)
    assert np.array_equal(robot.forward_kinematics(robot.home), ulna.load("panda").forward_kinematics(robot.home))
    assert Counting.calls == 1


def test_a_robot_that_was_asked_is_freed(crate):
    robot = ulna.load("panda")
    for _ in range(3):
        robot.inverse_kinematics(robot.forward_kinematics(robot.home)), robot.jacobian(robot.home)
        robot.in_collision(robot.home, crate), robot.signed_distance(robot.home, crate)
    gone = weakref.ref(robot)
    del robot
    gc.collect()
    assert gone() is None


def test_many_threads_get_the_answers_of_one(panda, crate):
    q = panda.random(400, seed=4)

    def ask(x):
        T = panda.forward_kinematics(x)
        found = panda.inverse_kinematics(T)
        return (
            T.tobytes(),
            panda.jacobian(x).tobytes(),
            panda.in_collision(x, crate),
            panda.signed_distance(x, crate),
            found.q.tobytes(),
        )

    alone = [ask(x) for x in q]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(ask, q)) == alone
