"""The C extension: wrong arguments are refused, never a crash; and what it computes is what Python's own way computes."""

import gc
import pickle
import sys

import numpy as np
import pytest

import robots
import ulna
from ulna.engine import _calls
from ulna.kinematics.entries import forward, jacobian
from ulna.kinematics.forward import CompiledForward


class Lying(np.ndarray):
    """An array of another class."""


def odd_values():
    """What is not an array of seven float64 that may be written to, and two that are."""
    read_only = np.zeros(7)
    read_only.setflags(write=False)
    unaligned = np.zeros(57, np.uint8)[1:].view(np.float64)
    arrays = [np.zeros(7), np.ones(7) * 1e300, np.full(7, np.nan), read_only, unaligned, np.zeros(14)[::2], np.zeros(7, ">f8")]
    arrays += [np.zeros(shape) for shape in [(), (0,), (6,), (8,), (7, 1), (1, 7), (4, 4), (6, 7), (0, 7), (1,) * 7]]
    arrays += [np.zeros(7, kind) for kind in (np.float32, np.int64, bool, complex, object, "U3", "M8[s]")]
    plain = [None, 0, 7, 2**70, -(2**70), 0.5, np.float64(1), np.int64(3), True, "seven", b"", (), [0.0] * 7, {}, object(), type]
    return [*arrays, np.zeros(7).view(Lying), np.ma.zeros(7), *plain]


ODD = odd_values()
TAME = (TypeError, ValueError, LookupError, MemoryError, OverflowError)  # an UlnaError is one of these


@pytest.mark.parametrize("function", [forward.forward_one, jacobian.jacobian_one])
def test_an_entry_takes_or_refuses_any_argument(function, panda):
    chain, rng = panda.tree.chain(panda.tip).copy(), np.random.default_rng(1)
    of_pose = function is forward.forward_one
    good = [chain, 7, np.zeros(7), np.zeros((4, 4))] if of_pose else [chain, 0, 7, np.zeros(7), np.zeros((6, 7))]
    assert function(*good)
    for _ in range(3000):
        arguments = list(good)
        place = rng.integers(1, len(good))  # not the table of joints: that is the library's own
        arguments[place] = ODD[rng.integers(len(ODD))]
        try:
            assert function(*arguments) in (True, False)
        except TypeError as error:
            assert f"argument {place + 1}" in str(error)  # noqa: PT017 - it may or may not be refused
    for n in (0, 1, len(good) - 1, len(good) + 1):
        with pytest.raises(TypeError, match=f"{n} arguments; it was compiled for another number"):
            function(*(good * 2)[:n])


def questions(panda):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.4)))
    panda.compile_forward(), panda.compile_jacobian()  # what makes them
    ur5 = ulna.Robot.from_dh(robots.UR5, convention="standard")
    return {
        "pose": panda._forward[None],
        "jacobian": panda._jacobian[None, "base"],
        "touches": lambda *arguments: panda.in_collision(arguments[0], world),
        "distance": lambda *arguments: panda.signed_distance(arguments[0], world),
        "edge": lambda *arguments: panda.edge_in_collision(*arguments[:2], world),
        "copy": lambda *arguments: world.move("crate", arguments[0]),
        "search": lambda *arguments: panda.inverse_kinematics(*arguments[:2]),
        "branches": lambda *arguments: ur5.all_solutions(*arguments[:2]),
    }


@pytest.mark.parametrize("name", ["pose", "jacobian", "touches", "distance", "edge", "copy", "search", "branches"])
def test_a_bound_function_takes_or_refuses_any_argument(name, panda):
    function, rng = questions(panda)[name], np.random.default_rng(2)
    for _ in range(1500):
        arguments = [ODD[k] for k in rng.integers(len(ODD), size=rng.integers(1, 4))]
        try:
            function(*arguments)
        except TAME as error:
            assert str(error)  # noqa: PT017 - it may or may not be refused


def test_a_bound_function_takes_its_arguments_by_name(panda):
    fk, T = panda.compile_forward(), np.empty((4, 4))
    assert fk(panda.home, out=T) is T
    assert fk(q=panda.home).shape == (4, 4)
    with pytest.raises(TypeError):
        fk(panda.home, None, None)
    with pytest.raises(TypeError, match="'queue'"):
        fk(panda.home, queue=1)
    with pytest.raises(TypeError):
        fk()


def test_the_plain_methods_use_the_extension(panda):
    world = ulna.World()
    panda.forward_kinematics(panda.home), panda.jacobian(panda.home), panda.in_collision(panda.home, world)  # what makes them
    queries = panda._checker._last
    of_links = panda._forward[None], panda._jacobian[None, "base"]
    for function in (*of_links, queries.overlaps, queries.min_distance, queries.edge):
        assert isinstance(function, _calls.Bound)


def test_in_c_and_in_python_are_the_same_bits(panda):
    world = ulna.World()
    for k in range(20):
        world.add(f"{k}", ulna.Box((0.1, 0.2, 0.1)), ulna.pose((0.6 * np.cos(k), 0.6 * np.sin(k), 0.05 * k)))
    fk, jac, checker = panda.compile_forward(), panda.compile_jacobian(), panda._checker
    scene = checker._scene(world.objects(), True)
    for q in panda.random(1000, seed=4):
        assert np.array_equal(panda.forward_kinematics(q), fk._validated(q))
        assert np.array_equal(panda.jacobian(q), jac._validated(q))
        assert panda.in_collision(q, world) == checker.in_collision_by_entries(scene, q)
        assert panda.signed_distance(q, world) == checker.min_distance(scene, q)


def test_in_c_and_in_python_find_the_same_solution(panda):
    for q in panda.random(200, seed=5):
        T = panda.forward_kinematics(q)
        assert np.array_equal(panda.inverse_kinematics(T).q, panda.inverse_kinematics(T.tolist()).q)
        assert np.array_equal(panda.inverse_kinematics(T, q + 0.1).q, panda.inverse_kinematics(T, (q + 0.1).tolist()).q)


def test_a_robot_that_was_asked_can_be_pickled(panda):
    panda.forward_kinematics(panda.home), panda.in_collision(panda.home), panda.signed_distance(panda.home)
    panda.inverse_kinematics(panda.forward_kinematics(panda.home))
    again = pickle.loads(pickle.dumps(panda))  # noqa: S301 - our own
    assert np.array_equal(again.forward_kinematics(panda.home), panda.forward_kinematics(panda.home))
    assert again.in_collision(panda.home) == panda.in_collision(panda.home)


def test_bound_functions_are_freed():
    panda = ulna.load("panda")
    tree = panda.tree
    gc.collect()
    before = sys.getrefcount(tree)
    for _ in range(100):
        fk = CompiledForward(tree, panda.tip)
        fk(panda.home), fk([0.0] * 7)
    del fk
    gc.collect()
    assert sys.getrefcount(tree) <= before + 1


UNREADABLE = ("x", "(1wd", "d" * 100, "1", "((d))", "9wd" * 10, "1w[", "1w[Tally]", "1w[Tally 16", "1w[ 16]", f"1w[{'T' * 60} 8]")


@pytest.mark.parametrize("overloads", [[], (1,), ((0, "d"),), *(((1, text),) for text in UNREADABLE)])
def test_an_entry_cannot_be_made_of_nonsense(overloads):
    with pytest.raises((TypeError, ValueError)):
        _calls.make_entry("f", overloads, "b", 1)


@pytest.mark.parametrize("arguments", [(), ("f",), ("f", (), "b"), ("f", (), "", 1), ("f", (), "q", 1)])
def test_an_entry_needs_a_name_its_machine_code_and_a_result(arguments):
    with pytest.raises((TypeError, ValueError)):
        _calls.make_entry(*arguments)


NONSENSE = {
    0: [len, 3, _calls.make_entry],
    1: ["truth", "number", "edge", "copy", "search", "branches", "dance", None],
    2: [(), (7,), (7, 7), (None, 7, 7), [], None],
    3: [0, -1, 2**70, None],
    4: [(), (4,), (0, 4), (4, 2**70), ("a", 4), (4, 4, 4), None],
    5: [None, 3],
}


@pytest.mark.parametrize(("place", "wrong"), [(place, wrong) for place in NONSENSE for wrong in NONSENSE[place]])
def test_a_function_cannot_be_bound_to_nonsense(panda, place, wrong):
    arguments = [forward.forward_one, "pose", (panda.tree.chain(panda.tip).copy(), 7), 7, (4, 4), len]
    assert _calls.Bound(*arguments)(np.zeros(7)).shape == (4, 4)
    arguments[place] = wrong
    with pytest.raises((TypeError, ValueError, OverflowError)):
        _calls.Bound(*arguments)


def test_a_bound_entry_is_bound_once(panda):
    arguments = [forward.forward_one, "pose", (panda.tree.chain(panda.tip).copy(), 7), 7, (4, 4), len]
    bound, of_nothing = _calls.Bound(*arguments), _calls.Bound.__new__(_calls.Bound)
    with pytest.raises(TypeError, match="cannot be changed"):
        bound.__init__(*arguments)
    with pytest.raises(TypeError, match="no bound arguments"):
        of_nothing(np.zeros(7))
    assert _calls.Bound(None, *arguments[1:])([1, 2, 3]) == 3  # without machine code Python is always asked
    with pytest.raises(TypeError, match="by position"):
        _calls.Bound(*arguments, like=None)
