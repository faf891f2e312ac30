"""``all_solutions`` of one target in C: the bits, proofs, refusals and lifetimes of Python's own way, which takes a list."""

import dataclasses
import gc
import pickle
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import robots
import ulna
from ulna.engine import _calls
from ulna.ik.solutions import PROOFS, IKSolutions, Proof

FIELDS = "q", "valid", "real"


def arm_of(rows):
    return ulna.Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * 3 + [(-2.0, 4.0)] * 3)


@pytest.fixture(params=[robots.UR5, robots.PUMA], ids=["UR5", "Puma 560"])
def arm(request):
    return arm_of(request.param)


def as_bytes(found):
    return *[getattr(found, field).tobytes() for field in FIELDS], found.proof, found.family


def targets_of(arm, n):
    """Random targets, some of them singular or nearly so, some out of reach."""
    q = arm.random(n, seed=1)
    q[: n // 4, 4] *= 10.0 ** -np.arange(n // 4)
    T = arm.forward_kinematics(q)
    T[-n // 4 :, :3, 3] *= 2.0
    return T


def test_it_has_the_bits_of_many_targets_and_of_python(arm):
    proofs = set()
    targets = targets_of(arm, 80)
    many = arm.all_solutions(targets)
    for k, T in enumerate(targets):
        found, in_python = arm.all_solutions(T), arm.all_solutions(T.tolist())
        assert as_bytes(found) == as_bytes(in_python)
        assert repr(found) == repr(in_python)
        assert found.proof == many.proof[k]
        if found.proof != Proof.SEARCHED:
            assert all(getattr(found, field).tobytes() == getattr(many, field)[k].tobytes() for field in FIELDS)
        proofs.add(found.proof)
    assert {Proof.COMPLETE, Proof.CONTINUUM} <= proofs


def test_it_goes_to_c_once_it_was_asked(arm):
    T = arm.forward_kinematics(arm.home + 0.3)
    arm.all_solutions(T)
    every = arm._inverse_kinematics._default_all_solutions[None]
    branches = every._of_one
    assert isinstance(branches, _calls.Bound)
    q, valid, real, code = branches(T)
    assert as_bytes(IKSolutions.of_one(q, valid, real, PROOFS[code], every._family)) == as_bytes(arm.all_solutions(T))
    assert branches(T[None]) is None


def test_what_is_found_is_as_the_class_makes_it(arm):
    T = arm.forward_kinematics(arm.home + 0.3)
    arm.all_solutions(T)
    found = arm.all_solutions(T)
    assert type(found) is IKSolutions
    assert {*vars(found), "colliding"} == {field.name for field in dataclasses.fields(IKSolutions)}
    assert found.colliding == 0
    assert type(found.proof) is Proof
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.q = None  # type: ignore[misc]
    again = pickle.loads(pickle.dumps(found))  # noqa: S301 - our own
    assert as_bytes(again) == as_bytes(found)
    for each in (found, again):
        for field in FIELDS:
            with pytest.raises(ValueError, match="read-only"):
                getattr(each, field)[0] = 0


def test_arguments_may_be_given_in_any_way(arm):
    T = arm.forward_kinematics(arm.home + 0.3)
    expected = as_bytes(arm.all_solutions(T))
    for _ in range(2):  # the first call makes what the second finds
        assert as_bytes(arm.all_solutions(T=T)) == as_bytes(arm.all_solutions(T, link=None)) == expected
        assert as_bytes(arm.all_solutions(T, link=arm.tip)) == expected
        assert as_bytes(arm.all_solutions(T, seed=0)) == as_bytes(arm.all_solutions(T, task=ulna.Task.pose())) == expected
        assert as_bytes(arm.all_solutions(np.asfortranarray(T))) == as_bytes(arm.all_solutions(T[None][0])) == expected
        assert not np.array_equal(arm.all_solutions(T, link="link3").q, arm.all_solutions(T).q)
        assert arm.all_solutions(T, whole_turns=True).real.all()
    assert arm.all_solutions(T.astype(np.float32)).q.shape == (8, 6)
    with pytest.raises(TypeError):
        arm.all_solutions(T, None)
    with pytest.raises(TypeError):
        arm.all_solutions(T, arm.tip, link=arm.tip)


@pytest.mark.parametrize("wrong", [np.ones((4, 4)), np.full((4, 4), np.nan), np.full((4, 4), np.inf), np.eye(3), np.zeros(16)])
def test_what_is_no_pose_is_refused_as_in_python(arm, wrong):
    arm.all_solutions(arm.forward_kinematics(arm.home))
    messages = []
    for T in (wrong, wrong.tolist()):
        with pytest.raises(ulna.InputError, match="T") as refused:
            arm.all_solutions(T)
        messages.append(str(refused.value))
    assert messages[0] == messages[1]


@pytest.mark.parametrize("link", ["no such link", 3, ["tip"], np.zeros(2)])
def test_a_link_that_there_is_not_is_refused_by_name(arm, link):
    with pytest.raises(ulna.UlnaError, match="link"):
        arm.all_solutions(np.eye(4), link=link)


def test_it_is_bound_to_so_many_branches_as_there_is_room_for(arm):
    arm.all_solutions(arm.forward_kinematics(arm.home))
    every = arm._inverse_kinematics._default_all_solutions[None]
    for numbers in [(17, 3), (0, 3), (8, 0), (8,)]:
        with pytest.raises(ValueError, match="a size" if len(numbers) == 2 else "wrong count"):
            _calls.Bound(every._run, "branches", every._tables, 6, numbers, len)
    with pytest.raises(TypeError):
        _calls.Bound(every._run, "branches", every._tables[:3], 6, (8, 3), len)


def test_an_arm_that_was_asked_is_freed():
    arm = arm_of(robots.UR5)
    found = [arm.all_solutions(arm.forward_kinematics(arm.home + 0.1)) for _ in range(3)]
    gone = weakref.ref(arm)
    del arm
    gc.collect()
    assert gone() is None
    assert found[-1].real.any()


def test_many_threads_find_what_one_finds(arm):
    targets = list(targets_of(arm, 200)[60:])
    alone = [as_bytes(arm.all_solutions(T)) for T in targets]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda T: as_bytes(arm.all_solutions(T)), targets)) == alone
