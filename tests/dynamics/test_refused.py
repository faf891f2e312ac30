"""What no torque can be computed of is refused by name."""

import copy
import re

import numpy as np
import pytest

import ulna

GOOD = {"q": np.zeros((3, 6)), "qd": np.zeros((3, 6)), "qdd": np.zeros((3, 6))}


@pytest.fixture
def arm():
    made = ulna.Robot.from_dh(
        [(0, 0.3, np.pi / 2, 0), (0.4, 0, 0, 0), (0.3, 0, 0, 0), (0, 0.1, np.pi / 2, 0), (0, 0.1, -np.pi / 2, 0), (0, 0, 0, 0)]
    )
    return made.with_inertias({f"link{k}": ulna.Inertia(1.0, (0.1, 0, 0.05), np.eye(3) / 100) for k in range(1, 7)})


def test_a_robot_without_inertias():
    with pytest.raises(ulna.InertiaError, match="no link of 'robot' that moves has an inertia") as refused:
        ulna.Robot.from_dh([(0, 0, 0, 0)]).gravity_torque([0.0])
    assert refused.value.links == ("link1",)


def test_links_with_a_shape_and_no_inertia_are_named(panda):
    some = panda.with_inertias({"panda_link3": None})
    with pytest.raises(ulna.InertiaError, match=r"panda_link3.*no inertia; robot\.with_inertias") as refused:
        some.mass_matrix(panda.home)
    assert "panda_link3" in refused.value.links
    assert copy.copy(refused.value).links == refused.value.links


@pytest.mark.parametrize("name", ["q", "qd", "qdd"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite(arm, name, value):
    wrong = {key: array.copy() for key, array in GOOD.items()}
    wrong[name][1, 4] = value
    with pytest.raises(ulna.InputError, match=re.escape(f"{name}[1, 4]")):
        arm.inverse_dynamics(**wrong)
    with pytest.raises(ulna.InputError, match=re.escape(f"{name}[1, 4]")):
        arm.inverse_dynamics_derivatives(**wrong)
    with pytest.raises(ulna.InputError, match=re.escape("1, 4]")):
        arm.forward_dynamics(*wrong.values())
    if name != "qdd":
        with pytest.raises(ulna.InputError, match=re.escape(f"{name}[1, 4]")):
            arm.kinetic_energy(wrong["q"], wrong["qd"])


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"qd": np.zeros(5)}, "qd: shape"),
        ({"qdd": np.zeros((2, 6))}, "do not go together"),
        ({"gravity": (0, 0)}, "gravity"),
        ({"gravity": (0, 0, np.nan)}, "gravity"),
        ({"wrenches": [np.zeros(6)]}, "wrenches: list; forces and moments by link"),
        ({"wrenches": {"link3": (1, 2, 3)}}, "wrenches: shape"),
        ({"wrenches": {"link3": np.full(6, np.nan)}}, "wrenches"),
        ({"wrenches": {"link3": np.zeros((5, 6))}}, "does not go with q"),
        ({"out": np.empty((2, 6))}, "out"),
    ],
)
def test_arguments_that_do_not_fit(arm, changed, words):
    with pytest.raises(ulna.InputError, match=words):
        arm.inverse_dynamics(**{**GOOD, **changed})


def test_batches_that_do_not_go_together(arm):
    three, two = np.zeros((3, 6)), np.zeros((2, 6))
    for call in (
        lambda: arm.kinetic_energy(three, two),
        lambda: arm.forward_dynamics(three, np.zeros(6), two, wrenches={"link3": np.zeros(6)}),
        lambda: arm.inverse_dynamics_derivatives(three, two, three),
        lambda: arm.external_torque(three, three, three, two),
    ):
        with pytest.raises(ulna.InputError, match=r"go (with|together)"):
            call()


def test_a_wrench_on_a_link_that_is_not_there(arm):
    with pytest.raises(ulna.UnknownNameError, match="linkk"):
        arm.inverse_dynamics(**GOOD, wrenches={"linkk": np.zeros(6)})


@pytest.mark.parametrize("free", [1, 6])
def test_a_joint_that_moves_no_mass_has_no_acceleration(arm, free):
    """The last link has no mass; or the first joint alone moves point masses on its own axis."""
    nothing = ulna.Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
    point = {f"link{k}": nothing for k in range(1, 7)} | {"link1": ulna.Inertia(1.0, np.zeros(3), np.zeros((3, 3)))}
    singular = arm.with_inertias({"link6": nothing} if free == 6 else point)
    with pytest.raises(ulna.SingularityError, match="a joint moves no mass") as refused:
        singular.forward_dynamics(q=GOOD["q"], qd=GOOD["qd"], torque=GOOD["qdd"])
    assert refused.value.rows == ((0,), (1,), (2,))
    with pytest.raises(ulna.SingularityError):
        singular.operational_inertia(GOOD["q"])


def test_a_link_that_cannot_move_in_every_direction_has_no_operational_inertia(arm):
    with pytest.raises(ulna.SingularityError, match="no joint moves 'link2' in some direction"):
        arm.operational_inertia(np.full(6, 0.3), link="link2")


def test_inertias_of_links_that_are_not_there_or_are_none(arm):
    with pytest.raises(ulna.UnknownNameError, match="elbow"):
        arm.with_inertias({"elbow": None})
    with pytest.raises(ulna.InputError, match=r"ulna\.Inertia or None"):
        arm.with_inertias({"link1": 3.0})


@pytest.mark.parametrize(
    "wrong", [(-1.0, np.zeros(3), np.eye(3)), (1.0, np.zeros(2), np.eye(3)), (1.0, np.zeros(3), np.full((3, 3), np.nan))]
)
def test_an_inertia_that_is_none(wrong):
    with pytest.raises(ulna.InputError):
        ulna.Inertia(*wrong)


def test_gravity_may_point_along_any_axis(arm):
    q = np.linspace(-1, 1, 6)
    along = [arm.gravity_torque(q, gravity=axis) for axis in np.eye(3)]
    assert np.allclose(arm.gravity_torque(q, gravity=(2.0, -3.0, 5.0)), 2 * along[0] - 3 * along[1] + 5 * along[2])
    assert not arm.gravity_torque(q, gravity=(0, 0, 0)).any()
