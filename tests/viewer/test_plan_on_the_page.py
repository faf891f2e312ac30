"""The tab of plans in a browser: a goal is typed and dragged, the plan is drawn and played, the reason is read."""

import numpy as np
import pytest

import ulna
from browser import arrow, camera_of, drag, wait_to_see
from processes import wait_for

pytestmark = pytest.mark.slow


@pytest.fixture
def view(panda):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 0.9)), ulna.pose((0.45, 0.2, 0.45)))
    with ulna.view(panda, world) as view:
        yield view


@pytest.fixture
def page(view, open_page):
    page = open_page(view.url)
    page.get_by_role("tab", name="Plan").click()
    page.get_by_role("button", name="Plan a motion").click()
    wait_to_see(page, lambda: "no goal yet" in page.inner_text("body"), "the request for a goal")
    return page


def type_goal(view, page, x, y):
    """Type two coordinates of the goal, and wait for its plan: what it needs may have to be compiled."""
    for name, value in (("Goal xyz [m]", x), ("Goal xyz [m], y", y)):
        field = page.get_by_label(name, exact=True)
        field.fill(value)
        field.press("Enter")
    wait_for(lambda: view.plans.planning.shown is not None, "a plan", looks=None)


def test_a_typed_goal_is_planned_to_drawn_and_played(view, page, panda):
    type_goal(view, page, "0.307", "0.45")
    wait_to_see(page, lambda: "solved: " in page.inner_text("body"), "a plan")
    assert "certified free" in page.inner_text("body")
    assert view.plans.line.visible
    page.get_by_role("button", name="Play").click()
    wait_to_see(page, lambda: view.plans.planning.share == 1.0 and not view.plans.moving, "the end of the motion")
    assert np.allclose(panda.forward_kinematics(view.q)[1, 3], 0.45, atol=2e-5)
    along = page.get_by_role("textbox", name="Along the plan")
    along.fill("0")
    along.press("Enter")
    wait_to_see(page, lambda: np.allclose(view.q, panda.home), "the arm at its start")


def test_a_goal_inside_an_obstacle_has_a_reason_and_no_line(view, page, panda):
    type_goal(view, page, "0.45", "0.2")
    wait_to_see(page, lambda: "goal in collision: " in page.inner_text("body"), "the reason")
    assert "post" in page.inner_text("body")
    assert not view.plans.line.visible
    assert np.array_equal(view.q, panda.home)


def test_a_dragged_goal_is_planned_to_and_the_arm_stays(view, page, panda):
    camera = camera_of(page, view.page.server)
    size, T = view.plans.handles.control.scale, panda.forward_kinematics(panda.home)
    drag(page, view.plans.handles, arrow(camera, T, 2, size), (0, 60), "blue")
    page.mouse.up()
    wait_for(lambda: view.plans.planning.shown is not None, "a plan", looks=None)
    assert np.array_equal(view.q, panda.home)
    assert view.plans.planning.hand_pose[2, 3] < T[2, 3] - 0.01


DRAWN = """() => Object.values(window.__viserTestpoints?.uplots ?? {})
    .map(({ chart }) => [chart.data[0].length, chart.series.slice(1).map((s) => s.label), chart.axes[1].label])"""


def test_the_curves_of_a_plan_are_plotted_against_their_limits(view, page, panda):
    page.get_by_label("Limit the jerk").click()
    type_goal(view, page, "0.307", "0.45")
    shown = [
        [400, [f"panda_joint{k}" for k in range(1, 8)] + 2 * ["limit"], name]
        for name in ("position", "velocity", "acceleration", "jerk")
    ]
    wait_to_see(page, lambda: sorted(page.evaluate(DRAWN)) == sorted(shown), "four charts")
    page.get_by_label("Joint", exact=True).click()
    page.get_by_role("option", name="panda_joint2").click()
    labels = ["acceleration [rad/s\u00b2]", "jerk [rad/s\u00b3]", "position [rad]", "velocity [rad/s]"]
    shown = [[400, ["panda_joint2", "limit", "limit"], label] for label in labels]
    wait_to_see(page, lambda: sorted(page.evaluate(DRAWN)) == sorted(shown), "the charts of one joint")
    page.get_by_label("Limit the jerk").click()
    wait_for(
        lambda: view.plans.planning.shown and "jerk" not in view.plans.planning.shown.curves, "a plan with jumps", looks=None
    )
    wait_to_see(page, lambda: len(page.evaluate(DRAWN)) == 3, "no chart of the jerk")
    page.get_by_role("button", name="End planning").click()
    wait_to_see(page, lambda: page.evaluate(DRAWN) == [], "no chart")


def test_what_is_kept_is_chosen_and_drawn(view, page):
    bands = view.plans.bands
    page.get_by_label("Keep upright").click()
    wait_to_see(page, lambda: bands.cone.visible, "the cone")
    assert not bands.bar.visible
    page.get_by_label("Keep on the line").click()
    type_goal(view, page, "0.4", "-0.3")
    wait_to_see(page, lambda: "% of the tolerance" in page.inner_text("body"), "a plan that keeps both")
    wait_to_see(page, lambda: bands.bar.visible, "the bar")
    a, b = view.plans.planning.shown.kept_line
    np.testing.assert_allclose(bands.bar.position, (a + b) / 2)
    assert bands.bar.dimensions[2] == pytest.approx(np.linalg.norm(b - a))
    page.get_by_role("button", name="End planning").click()
    wait_to_see(page, lambda: not bands.bar.visible and not bands.cone.visible, "nothing that is kept")
