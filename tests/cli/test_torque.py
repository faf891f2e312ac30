"""``ulna torque``."""

import re

import pytest

# A bar of 2 kg and one meter that turns about a level axis at its end, and a slide along it without a limit.
BAR = """<robot name="bar">
  <link name="wall"/>
  <link name="bar"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="slider"/>
  <joint name="turn" type="revolute"><parent link="wall"/><child link="bar"/><axis xyz="0 -1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="20"/></joint>
  <joint name="slide" type="prismatic"><parent link="bar"/><child link="slider"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" velocity="1" effort="{effort}"/></joint>
</robot>"""


@pytest.fixture
def bar(tmp_path):
    def bar(effort):
        path = tmp_path / f"bar{effort}.urdf"
        path.write_text(BAR.format(effort=effort), encoding="utf-8")
        return path

    return bar


def test_what_an_arm_holds_is_exit_status_0(ask, bar):
    answer = ask("torque", bar(9), "--q", "0, 0.5", "--payload", "1kg@0.5,0,0")
    assert (answer.exit_code, answer.holds, answer.unknown) == (0, True, [])
    assert answer.torque == pytest.approx([2 * 9.81 * 0.5 + 9.81, 0.0])
    assert answer.share == pytest.approx([answer.torque[0] / 20, 0.0])
    assert answer.payload == pytest.approx((20 - 9.81) / 9.81)
    assert answer.bears == [pytest.approx(answer.payload), None]
    assert (answer.limited_by, answer.link, answer.units) == ("turn", "slider", ["Nm", "N"])


def test_what_it_does_not_hold_is_exit_status_1(ask, run, bar):
    answer = ask("torque", bar(9), "--q", "0, 0.5", "--payload", "1.1@0.5 0 0")
    assert (answer.exit_code, answer.holds, answer.mass, answer.center) == (1, False, 1.1, [0.5, 0, 0])
    result = run("torque", bar(9), "--q", "0, 0.5", "--payload", "1.1@0.5 0 0")
    assert result.exit_code == 1
    assert re.search(r"turn +20\.60 +20\.00 +103\.0 % +1\.04 +Nm", result.stdout)
    assert result.stdout.splitlines()[-2:] == [
        "at 0.5, 0, 0 of slider it can hold 1.04 kg, limited by turn",
        "beyond the torque limits",
    ]


def test_a_joint_without_a_limit_is_named_and_is_no_yes(ask, run, bar):
    answer = ask("torque", bar(0), "--q", "0, 0.5")
    assert (answer.exit_code, answer.holds, answer.unknown) == (1, False, ["slide"])
    assert (answer.limit[1], answer.share[1], answer.bears[1]) == (None, None, None)
    assert run("torque", bar(0)).stdout.splitlines()[-1].startswith("unknown: no effort limit above 0 for slide")
    assert ask("torque", bar(0), "--q", "0, 0.5", "--effort", "20, 9").exit_code == 0
    assert ask("torque", bar(0), "--q", "0, 0.5", "--effort", "5").exit_code == 1


def test_what_its_maker_rates_an_arm_for_is_beside_what_its_motors_hold(ask, run):
    light, heavy = (run("torque", "ur10e", "--payload", f"{mass}kg@0,0,0.1") for mass in (10, 15))
    assert "the maker's rated payload is 12.5 kg" in light.stdout
    assert "more than the maker's rated payload of 12.5 kg" in heavy.stdout
    assert ask("torque", "ur10e").rated == 12.5
    assert ask("torque", "panda").rated == 3.0


def test_motion_and_mounting_count(ask, bar):
    """Along the wall's x axis the bar is weightless to its joint, and the slide is pulled."""
    answer = ask("torque", bar(9), "--q", "0, 0.5", "--mount", "wall", "--payload", "0.5")
    assert answer.torque == pytest.approx([0.0, -0.5 * 9.81])
    assert answer.bears == [None, pytest.approx(9 / 9.81)]
    moved = ask("torque", bar(9), "--q", "0, 0.5", "--gravity", "0,0,0", "--qdd", "2, 0", "--qd", "3, 0", "--payload", "1")
    assert moved.torque == pytest.approx([2 * 2 * 0.25 + 2 * 0.25, -9 * 0.5])
    turned = ask("torque", bar(9), "--q", "0, 0.5", "--gravity", "0,0,0", "--degrees", "--qd", "180, 0", "--payload", "1")
    assert turned.torque[1] == pytest.approx(-0.5 * 3.14159265**2)
    upside = ask("torque", bar(9), "--q", "0, 0.5", "--mount", "ceiling")
    assert upside.torque == pytest.approx([-9.81, 0.0])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--payload", "3lb"], "--payload: '3lb' is not a number"),
        (["--payload", "-3kg"], "--payload: '-3kg'; a mass of at least 0"),
        (["--payload", "3@1,2"], "--payload: 2 numbers, but 3 are expected: x, y, z"),
        (["--mount", "wall", "--gravity", "0,0,1"], "--mount, --gravity: give only one"),
        (["--gravity", "0,1"], "--gravity: 2 numbers, but 3 are expected"),
        (["--effort", "1,2,3"], "--effort: 3 numbers, but 7 are expected"),
        (["--effort", "0"], "--effort: 0; limits above 0"),
        (["--qd", "1"], "--qd: 1 number, but 7 are expected"),
    ],
)
def test_what_cannot_be_taken_is_refused(refusal, arguments, words):
    assert refusal("torque", *arguments).startswith(words)


def test_a_robot_without_inertias_is_refused(refusal, slider):
    assert "no inertia" in refusal("torque", slider)
