"""How numbers are written on the command line."""

import math

import pytest

from ulna.cli.targets import numbers
from ulna.robot.coordinates import Coordinate

PI = math.pi
HOME = [0, -PI / 4, 0, -3 * PI / 4, 0, PI / 2, PI / 4]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0", 0.0),
        ("-0.5", -0.5),
        ("+.25", 0.25),
        ("3.", 3.0),
        ("1e-3", 1e-3),
        ("2.5E+2", 250.0),
        ("pi", PI),
        ("-pi", -PI),
        ("pi/2", PI / 2),
        ("-3pi/4", -3 * PI / 4),
        ("-3*pi/4", -3 * PI / 4),
        ("0.5pi", PI / 2),
        ("+pi/1.5", PI / 1.5),
    ],
)
def test_numbers_and_multiples_of_pi_are_parsed(text, value):
    assert numbers("--q", text, [Coordinate("a", "rad")]) == [value]


def test_numbers_are_separated_by_commas_or_whitespace():
    abcd = [Coordinate(name, "m") for name in "abcd"]
    for text in ("0,-pi/4,0.5 1e-3", " 0 , -pi/4\t0.5,1e-3 ", "0 -pi/4 0.5 1e-3"):
        assert numbers("--q", text, abcd) == [0, -PI / 4, 0.5, 1e-3]


def test_the_home_configuration_is_parsed_to_the_last_bit():
    assert numbers("--q", "0,-pi/4,0,-3pi/4,0,pi/2,pi/4", [Coordinate(name, "rad") for name in "abcdefg"]) == HOME


def test_degrees_apply_to_angles_only():
    entries = [Coordinate("turn", "rad"), Coordinate("slide", "m"), Coordinate("w", "")]
    assert numbers("--q", "180 180 180", entries, degrees=True) == [PI, 180, 180]


@pytest.mark.parametrize(
    "word", ["one", "nan", "inf", "1e999", "1_0", "0x1", "pi/0", "2**3", "pi*2", "3/4", "--1", "1;2", "pipi", "()"]
)
def test_text_that_is_not_a_number_is_refused(refusal, word):
    message = refusal("fk", "--q", f"0,0,0,{word},0,0,0")
    assert message == f"--q: {word!r} is not a number; numbers are written as 0.5, 1e-3, pi/2 or -3pi/4"


@pytest.mark.parametrize(("text", "count"), [("", "0 numbers"), ("1", "1 number"), ("1,2,3,4,5,6,7,8", "8 numbers")])
def test_the_error_for_a_wrong_count_names_the_joints(refusal, text, count):
    assert refusal("fk", "--q", text).startswith(f"--q: {count}, but 7 are expected: panda_joint1, panda_joint2")


def test_an_empty_entry_is_refused(refusal):
    assert "'' is not a number" in refusal("fk", "--q", "0,,0,0,0,0,0")


def test_pi_with_degrees_is_refused(refusal):
    assert refusal("fk", "--degrees", "--q", "0,0,0,0,0,0,pi/4") == "--q: 'pi/4' is in radians, but --degrees is given"


def test_a_number_too_large_is_refused(refusal):
    assert refusal("fk", "--degrees", "--q", "0,0,0,0,0,0,1e20").startswith("--q[6]: ")


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["ik", "--xyz", "0.4,0,0.5", "--rpy", "180,0,0"], "--rpy: 180 rad is more than a turn"),
        (["fk", "--q", "0,0,0,0,0,0,-45"], "--q: -45 rad is more than a turn"),
        (["check", "--box", "1,0,0,0,0,90,1,1,1"], "--box: 90 rad is more than a turn"),
    ],
)
def test_an_angle_of_more_than_a_turn_is_computed_with_a_hint_about_degrees(run, arguments, hint):
    result = run(*arguments)
    assert result.exit_code < 2
    assert result.stdout
    assert result.stderr == f"ulna: {hint}; with --degrees angles are in degrees\n"


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["ik", "--xyz", "400,100,500"], "--xyz: lengths are in meters; did you mean 0.4, 0.1, 0.5?"),
        (["ik", "--pose", "400,0,-500,0,pi,0"], "--pose: lengths are in meters; did you mean 0.4, 0, -0.5, 0, pi, 0?"),
        (
            ["check", "--box", "300,0,5,0,0,pi,150,90,126"],
            "--box: lengths are in meters; did you mean 0.3, 0, 0.005, 0, 0, pi, 0.15, 0.09, 0.126?",
        ),
        (["plan", "--xyz", "0,0,-250"], "--xyz: lengths are in meters; did you mean 0, 0, -0.25?"),
    ],
)
def test_lengths_beyond_any_arm_get_a_hint_about_millimeters(run, arguments, hint):
    assert f"ulna: {hint}\n" in run(*arguments).stderr


def test_there_is_no_hint_about_degrees_where_radians_are_meant(run, slider):
    for arguments in (
        ["fk", "--q", "0,0,0,0,0,0,6.28"],
        ["fk", "--q", "0,0,0,0,0,0,3pi"],
        ["fk", "--q", "0,0,0,0,0,0,180", "--degrees"],
        ["fk", slider, "--q", "9"],  # meters
        ["ik", "--xyz", "7,8,9"],
    ):
        assert run(*arguments).stderr == ""
