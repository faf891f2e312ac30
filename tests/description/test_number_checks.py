"""A number, a count or a switch is checked in one way, wherever it is given; the error names the argument and the value."""

from fractions import Fraction

import numpy as np
import pytest

import ulna
from ulna.description.arrays import as_count, as_number, as_switch, positive
from ulna.errors import InputError

HUGE = 10**400  # a whole number that no float can hold


@pytest.mark.parametrize("value", [2, 2.0, np.float32(2), np.int64(2), Fraction(2)])
def test_a_number_becomes_a_float(value):
    assert as_number("x", value) == 2.0
    assert type(positive("x", value)) is float


@pytest.mark.parametrize("value", [True, np.True_, "2", None, [2.0], np.array(2.0), np.nan, np.inf, -np.inf, 1j, HUGE, -HUGE])
def test_what_is_no_finite_number_is_refused(value):
    for check in (as_number, positive):
        with pytest.raises(InputError, match="x: ") as refused:
            check("x", value)
        assert refused.value.argument == "x"


def test_the_bounds_of_a_number_belong_to_it_unless_it_is_to_be_above():
    assert as_number("x", 0, 0.0) == 0.0
    assert as_number("x", 1, 0.0, most=1.0) == 1.0
    assert as_number("x", np.inf, 0.0, most=np.inf) == np.inf
    for value, bounds in ((-1e-300, {}), (1.0001, {"most": 1.0}), (0.0, {"above": True}), (HUGE, {"most": np.inf})):
        with pytest.raises(InputError, match="a share is expected"):
            as_number("x", value, 0.0, "a share", **bounds)


def test_a_count_is_a_whole_number_between_its_bounds():
    assert as_count("n", np.int32(3)) == 3
    assert as_count("n", 2**31 - 1) == 2**31 - 1
    for value in (2.0, True, "3", None, -1, 2**31, HUGE):
        with pytest.raises(InputError, match=r"n: .* a whole number from 0 to 2147483647 is expected"):
            as_count("n", value)
    with pytest.raises(InputError, match="n: 0; a whole number from 1 to 5"):
        as_count("n", 0, 1, 5)


def test_a_switch_is_true_or_false():
    assert as_switch("on", np.False_) is False
    for value in (1, 0, "no", None):
        with pytest.raises(InputError, match=r"on: .*True or False"):
            as_switch("on", value)


@pytest.mark.slow
@pytest.mark.parametrize("huge", [HUGE, 10**5000], ids=["401 digits", "more digits than Python writes"])
def test_a_whole_number_that_no_float_can_hold_is_refused_by_every_call(huge):
    panda = ulna.load("panda")
    plan = panda.plan(panda.home, panda.home + 0.1)
    calls = {
        "time_limit": lambda: panda.plan(panda.home, panda.home + 0.1, time_limit=huge),
        "clearance": lambda: panda.plan(panda.home, panda.home + 0.1, clearance=huge),
        "seed": lambda: panda.plan(panda.home, panda.home + 0.1, seed=huge),
        "blend": lambda: plan.trajectory(acceleration=1.0, blend=huge),
        "since": lambda: plan.trajectory(acceleration=1.0).is_free(None, since=huge),
        "max_distance": lambda: panda.check_collision(panda.home, max_distance=huge),
        "resolution": lambda: panda.edge_in_collision(panda.home, panda.home + 0.1, resolution=huge),
        "damping": lambda: panda.differential_ik(panda.home, np.zeros(6), 0.01, damping=huge),
        "position_tolerance": lambda: panda.inverse_kinematics(np.eye(4), position_tolerance=huge),
        "n": lambda: panda.random(huge),
        "tolerance": lambda: panda.dh(tolerance=huge),
        "touching": lambda: panda.with_allowed_collisions(touching=huge),
    }
    for name, call in calls.items():
        with pytest.raises(InputError) as refused:
            call()
        assert refused.value.argument == name
        assert "more than 308 digits" in str(refused.value)
