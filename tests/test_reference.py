"""Every public name has its place in the reference. (`make docs` looks at more: it reads what is written there.)"""

import re
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
    assert {"ulna.collision.edge.EdgeReport", "ulna.model.groups.JointGroup", "ulna.model.description.Mimic"} <= reached
    assert not any("Checker" in name for name in reached)
