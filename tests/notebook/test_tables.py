"""What a notebook shows of a result: one line as its ``repr``, and a table that fetches nothing."""

import numpy as np
import pytest
from lxml import html

import ulna
from ulna.notebook.tables import MAX_ROWS, table

NASTY = "<b onload=x>&\"'"


@pytest.fixture(scope="module")
def world():
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.2)), ulna.pose((0.5, 0, 0.6)))
    return world


@pytest.fixture(scope="module")
def plan(panda, world):
    ends = np.array([panda.home, panda.home])
    ends[:, 0] = 0.8, -0.8
    return panda.plan(*ends, world)


RESULTS = {
    "robot": lambda panda, _world, _plan: panda,
    "world": lambda _panda, world, _plan: world,
    "plan": lambda _panda, _world, plan: plan,
    "no plan": lambda panda, _world, _plan: panda.plan(panda.home, panda.home, blocked(panda)),
    "trajectory": lambda _panda, _world, plan: plan.trajectory(acceleration=5.0),
    "report": lambda panda, _world, _plan: panda.check_collision(panda.home, blocked(panda)),
    "free report": lambda panda, world, _plan: panda.check_collision(panda.home, world),
    "DH table": lambda panda, _world, _plan: panda.dh(),
    "IK result": lambda panda, _world, _plan: panda.inverse_kinematics(ulna.pose((0.4, 0.1, 0.5))),
    "IK results": lambda panda, _world, _plan: panda.inverse_kinematics(ulna.pose([(0.4, 0.1, 0.5), (2, 0, 0)])),
}
WITHOUT_TABLES = {
    "IK solutions": lambda panda, _world, _plan: panda.all_solutions(ulna.pose((0.4, 0.1, 0.5))),
    "followed path": lambda panda, _world, _plan: panda.follow(panda.forward_kinematics(panda.home)[None]),
    "closed form": lambda panda, _world, _plan: panda.closed_form,
    "pair": lambda panda, _world, _plan: panda.check_collision(panda.home, blocked(panda)).pairs[0],
    "edge report": lambda panda, world, _plan: panda.edge_in_collision(panda.home, panda.home, world),
}


def blocked(panda):
    world = ulna.World()
    world.add("crate", ulna.Box((0.3, 0.3, 0.3)), panda.forward_kinematics(panda.home))
    return world


def rows_of(shown):
    """The cells of each row of a table, as text."""
    return [[cell.text_content() for cell in row] for row in html.fromstring(shown).iter("tr")]


@pytest.mark.parametrize("of", [*RESULTS, *WITHOUT_TABLES])
def test_a_repr_is_one_line_without_arrays(panda, world, plan, of):
    result = (RESULTS | WITHOUT_TABLES)[of](panda, world, plan)
    line = repr(result)
    assert line.startswith(f"<{type(result).__name__}")
    assert line.endswith(">")
    assert "\n" not in line
    assert "array" not in line
    assert len(line) < 220


@pytest.mark.parametrize("of", RESULTS)
def test_a_table_fetches_nothing_and_runs_nothing(panda, world, plan, of):
    shown = RESULTS[of](panda, world, plan)._repr_html_()
    tags = {element.tag for element in html.fromstring(shown).iter()}
    assert tags <= {"div", "table", "thead", "tbody", "tr", "th", "td"}
    assert not {name for element in html.fromstring(shown).iter() for name in element.attrib} - {"style", "scope"}
    assert "url(" not in shown


def test_the_table_of_a_robot_has_its_limits(panda):
    header, *rows = rows_of(panda._repr_html_())
    assert header == ["joint", "lower", "upper", "velocity", "home"]
    assert [row[0] for row in rows] == list(panda.joint_names)
    shown = np.array([row[1:] for row in rows], dtype=float)
    expected = np.column_stack([panda.lower, panda.upper, panda.velocity_limits, panda.home])
    assert np.allclose(shown, expected, rtol=1e-4)


def test_a_limit_that_there_is_not_is_an_empty_cell():
    rows = rows_of(ulna.Robot.from_dh([(0, 0.3, 0, 0), (0.2, 0, 1.5, 0.1)])._repr_html_())
    assert [row[1:3] for row in rows[1:]] == [["", ""], ["", ""]]


def test_the_table_of_a_motion_has_its_ends_and_its_greatest_values(plan):
    motion = plan.trajectory(acceleration=5.0)
    shown = np.array([row[1:] for row in rows_of(motion._repr_html_())[1:]], dtype=float)
    assert np.allclose(shown[:, :2].T, plan.path[[0, -1]], atol=1e-4)
    assert np.allclose(shown[:, 2:], np.abs([motion.qd, motion.qdd]).max(axis=1).T, rtol=0.02, atol=1e-6)


def test_the_table_of_a_report_has_every_pair(panda):
    report = panda.check_collision(panda.home, blocked(panda))
    rows = rows_of(report._repr_html_())[1:]
    assert [(a, b) for a, b, _ in rows] == [(pair.name_a, pair.name_b) for pair in report.pairs]
    assert np.allclose([float(d) for *_, d in rows], [1e3 * pair.signed_distance for pair in report.pairs], rtol=1e-4)


def test_names_are_escaped():
    world = ulna.World()
    world.add(NASTY, ulna.Sphere(0.1))
    assert rows_of(world._repr_html_())[1][0] == NASTY
    assert "<b" not in world._repr_html_()
    assert "<b" not in table(NASTY, [NASTY], [[NASTY]], [NASTY])


def test_of_a_long_table_the_first_rows_are_shown_and_the_others_counted():
    world = ulna.World()
    world.add_many((f"ball {k}", ulna.Sphere(0.1)) for k in range(MAX_ROWS + 5))
    shown = world._repr_html_()
    assert len(rows_of(shown)) == 1 + MAX_ROWS
    assert html.fromstring(shown).text_content().endswith("and 5 more")


def test_a_printed_dh_table_is_still_the_table(panda):
    lines = str(panda.dh()).splitlines()
    assert lines[0] == "panda: modified DH table from panda_link0 to panda_ee"
    assert sum(name in line for name in panda.joint_names for line in lines) == 7
    assert repr(panda.dh()).startswith("<DHTable of 'panda': 7 rows, modified, panda_link0 to panda_ee, off by at most ")
