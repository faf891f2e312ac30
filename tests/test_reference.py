"""Checks that the reference lists every public name, and that the site fetches nothing. `make docs` checks the text."""

import re
import runpy
import sys
from pathlib import Path

import pytest

import ulna

DOCS = Path(__file__).parents[1] / "docs"
TEXT = "\n".join(page.read_text(encoding="utf-8") for page in sorted((DOCS / "reference").glob("*.md")))


@pytest.fixture(scope="module")
def public():
    sys.path.insert(0, str(DOCS / "site"))
    try:
        import public

        return public
    finally:
        sys.path.pop(0)


def names_in(text):
    return set(re.findall(r"[A-Za-z_][\w.]*", text))


@pytest.mark.parametrize("name", ulna.__all__)
def test_a_public_name_has_its_place(name):
    assert f"ulna.{name}" in names_in(TEXT), f"docs/reference: ulna.{name} is missing"


def test_a_class_that_is_reached_from_the_public_names_has_its_place(public):
    assert set(public.public_classes()) <= names_in(TEXT)


def test_every_member_of_a_robot_has_its_place(public):
    listed = {name.removeprefix("Robot.") for name in names_in(TEXT)}
    assert set(public.public_members(ulna.Robot)) <= listed


def test_a_class_is_reached_through_what_methods_return_and_what_attributes_hold(public):
    reached = set(public.public_classes())
    assert {
        "ulna.collision.report.EdgeReport",
        "ulna.kinematics.groups.JointGroup",
        "ulna.description.robot_description.Mimic",
    } <= reached
    assert not any("Checker" in name for name in reached)


@pytest.fixture(scope="module")
def commands():
    """The sections of the command line's reference, by command."""
    sections = runpy.run_path(str(DOCS / "site" / "commands.py"))["reference"]().split("## ")[1:]
    return {section.splitlines()[0]: section for section in sections}


def test_the_reference_of_a_command_has_its_usage_line(commands):
    assert {"ulna fk", "ulna ik", "ulna check", "ulna bench"} <= set(commands)
    for name, section in commands.items():
        assert re.search(rf"```text\n{name} \[OPTIONS\].*\n```", section), section


@pytest.mark.parametrize(
    ("command", "entry"),
    [
        ("ulna ik", "`--xyz X,Y,Z`\n: The position to reach, in meters."),
        ("ulna follow", "or a .npy file. [required]"),
        ("ulna ik", "`--seed` (integer)\n: Chooses the random samples: the same number gives the same result. [default: 0]"),
        ("ulna dh", "`ROBOT` (text)\n: A name of `ulna list`, or the path of a .urdf, .xacro or .sdf file. [default: panda]"),
        ("ulna check", "`--self` / `--no-self`\n: Check the robot's links against each other too. [default: self]"),
        ("ulna record", "`--seconds` (number)\n: "),
    ],
)
def test_the_reference_of_a_command_has_types_and_defaults(commands, command, entry):
    assert entry in commands[command]


@pytest.mark.parametrize(
    ("text", "refused"),
    [
        ('<script async src="https://cdn.example/x.js"></script>', True),
        ("<link rel='stylesheet' href='//fonts.example/a.css'>", True),
        ('<img alt="a" src="http://example/a.png">', True),
        ('@import "https://fonts.example/a.css";', True),
        ("a { background: url( https://example/a.png ) }", True),
        ('<script src="_static/x.js"></script><link href="_static/a.css"><img src="a.png">', False),
        ('<a href="https://www.ros.org/reps/rep-0103.html">a link is for the reader to follow</a>', False),
    ],
)
def test_what_a_page_would_fetch_from_elsewhere_is_seen(text, refused):
    found = runpy.run_path(str(DOCS / "site" / "self_contained.py"))["fetched_from_elsewhere"](text)
    assert bool(found) == refused
