"""All of the page is used by keys alone, and the control that has them is seen, from the top of the panel to its end."""

from itertools import pairwise

import pytest

import ulna
from browser import wait_to_see
from ulna.viewer.session import steering

pytestmark = pytest.mark.slow

MAX = 120  # stops of Tab on the whole page
ROW = 15  # [pixels] by which controls of a row differ in height

# The control that has the keys: its name, its left and upper ends in what scrolls [pixels], whether all of it is on the
# screen, and the width of its ring.
STOP = """() => {
    const e = document.activeElement, style = getComputedStyle(e), { left, top, right, bottom } = e.getBoundingClientRect();
    let scrolled = 0;
    for (let one = e.parentElement; one; one = one.parentElement) scrolled += one.scrollTop;
    const words = e.ariaLabel || e.labels?.[0]?.textContent || e.innerText || '';
    const inside = left >= 0 && top >= 0 && right <= innerWidth + 1 && bottom <= innerHeight + 1;
    const ring = style.outlineStyle === 'solid' ? parseFloat(style.outlineWidth) * style.opacity : 0;
    return [e === document.body ? '' : words.trim(), left, top + scrolled, inside, ring];
}"""


@pytest.fixture
def view(panda, monkeypatch):
    monkeypatch.setattr(steering, "_HELD_FOR", 5.0)  # drawn by a CPU, a page says only every second or so that a key is held
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, -0.4, 0.05)))
    with ulna.view(panda, world) as view:
        yield view


def go(page, name, key="Tab"):
    """Go on by a key to the control of a name. Every control on the way is seen and has a ring."""
    for _ in range(MAX):
        page.keyboard.press(key)
        words, *_, ring = page.evaluate(STOP)
        wait_to_see(page, lambda: page.evaluate(STOP)[3], f"{words} on the screen")  # the panel may have grown in this moment
        assert not words or ring >= 2, f"{words} has a ring"
        if words == name:
            return
    raise AssertionError(f"no control {name!r} in {MAX} stops")


def use(page, name, key="Enter"):
    go(page, name)
    page.keyboard.press(key)


def type_in(page, name, text):
    go(page, name)
    if page.evaluate("document.activeElement.role") == "slider":
        go(page, name)
    page.keyboard.press("Control+a")
    page.keyboard.type(text)
    page.keyboard.press("Enter")


def choose(page, name, option):
    """Choose from a list: opened by an arrow, gone through by arrows, chosen by Enter."""
    use(page, name, "ArrowDown")
    page.get_by_role("option", name=option, exact=True).wait_for()
    marked = page.locator("[role=option][data-combobox-selected]")
    wait_to_see(page, marked.count, "a marked option")  # marked a moment after the list is open: an arrow before it would be lost
    for _ in range(MAX):
        if marked.inner_text() == option:
            break
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    wait_to_see(page, lambda: page.evaluate("document.activeElement.value") == option, f"{option} as the choice")


def in_front(page, name):
    use(page, name)
    wait_to_see(page, lambda: page.get_by_role("tab", name=name).get_attribute("aria-selected") == "true", f"the tab {name}")


def hand(view, axis):
    return view.session.hand_pose[axis, 3]


def plan_play_and_save(view, page, panda, folder):
    planning = view.plans.planning
    in_front(page, "Plan")
    use(page, "Plan a motion")
    page.get_by_role("button", name="End planning").wait_for()
    type_in(page, "Goal xyz [m], y", "0.3")
    wait_to_see(page, lambda: planning.shown is not None and planning.shown.motion is not None, "a plan")
    use(page, "Play", "Space")
    wait_to_see(page, lambda: abs(hand(view, 1) - 0.3) < 1e-3 and not view.plans.moving, "the arm at the goal")
    with page.expect_download() as download:
        use(page, "CSV", "Space")
    download.value.save_as(folder / "motion.csv")
    assert panda.motion_from_file(folder / "motion.csv").duration > 0.5


def steer(view, page):
    in_front(page, "Steer")
    use(page, "Steer the hand", "Space")
    pad = page.get_by_role("button", name="move -z")
    wait_to_see(page, lambda: view.steer.steering.can_move and pad.count() and pad.is_enabled(), "live buttons")
    before = hand(view, 2)
    page.keyboard.down("PageDown")
    wait_to_see(page, lambda: hand(view, 2) < before - 0.01, "a hand that moves down by its key")
    page.keyboard.up("PageDown")
    wait_to_see(page, lambda: not view.steer.moving, "a hand that rests")
    before = hand(view, 0)
    go(page, "move -x [↓]")
    page.keyboard.down("Space")
    wait_to_see(page, lambda: hand(view, 0) < before - 0.01, "a hand that moves back while Space holds its button")
    page.keyboard.up("Space")
    wait_to_see(page, lambda: not view.steer.moving, "a hand that rests")


def move_an_obstacle_and_undo(view, page):
    in_front(page, "Obstacles")
    choose(page, "Obstacle", "crate")
    wait_to_see(page, page.get_by_label("Position [m], y").count, "the numbers of the crate")
    type_in(page, "Position [m], y", "-0.5")
    wait_to_see(page, lambda: view.world.pose("crate")[1, 3] == -0.5, "a crate elsewhere")
    page.keyboard.press("Tab")
    use(page, "Undo")
    wait_to_see(page, lambda: view.world.pose("crate")[1, 3] == -0.4, "the crate where it was")


def attach_and_put_down(view, page):
    in_front(page, "Look")
    choose(page, "Link", "panda_link7")
    wait_to_see(page, lambda: view.link.chosen == "panda_link7", "a chosen link")
    use(page, "Attach crate")
    wait_to_see(page, lambda: view.session.robot.attached and not view.world.names, "an attached crate")
    use(page, "Put crate down")
    wait_to_see(page, lambda: view.world.names == ("crate",), "a crate that is put down")
    page.keyboard.press("Control+z")
    wait_to_see(page, lambda: not view.world.names, "a crate that is attached again")


def look_up_the_keys(page):
    in_front(page, "Move")
    page.keyboard.press("?")
    keys = page.get_by_role("dialog", name="Keys")
    keys.wait_for()
    assert "with Shift, parallel to the screen" in keys.inner_text()
    page.keyboard.press("Escape")
    keys.wait_for(state="detached")
    assert page.evaluate(STOP)[0] == "Move"
    use(page, "Copy, save, load q")
    go(page, "Save q")


def test_a_person_with_keys_alone_plans_plays_saves_steers_moves_attaches_and_undoes(view, page, panda, tmp_path):
    plan_play_and_save(view, page, panda, tmp_path)
    steer(view, page)
    move_an_obstacle_and_undo(view, page)
    attach_and_put_down(view, page)
    look_up_the_keys(page)


def test_a_number_that_is_longer_than_the_one_before_is_taken(view, page):
    """As 0.25 in place of 0: viser's number refuses it where the cursor was behind the end of the old one."""
    for text in ("0.25", "-0.125", "1"):
        type_in(page, "joint1", text)
        wait_to_see(page, lambda text=text: view.q[0] == float(text), text)


def test_the_controls_follow_each_other_as_they_are_read(view, page):
    """In each tab: below the control before, or beside it on its right."""
    view.steer._do(lambda: view.steer.steering.turn(on=True))
    for tab in ("Move", "Obstacles", "Plan", "Steer", "Look"):
        in_front(page, tab)
        go(page, "Look")  # the last of the tabs
        stops = []
        while (stop := page.evaluate(STOP))[0]:
            stops.append(stop)
            assert len(stops) < MAX
            page.keyboard.press("Tab")
        assert len(stops) > 3 or tab == "Plan"  # one button, before it is pressed
        for (before, left, top, *_), (words, right, below, *_) in pairwise(stops[1:]):
            assert below > top + ROW or (below > top - ROW and right > left), f"{words} after {before}"


def test_the_control_that_has_the_keys_stays_on_the_screen_when_the_panel_grows(view, page):
    in_front(page, "Move")
    use(page, "Copy, save, load q")
    go(page, "Save q")
    page.evaluate(
        "document.querySelector('[role=tablist]').before(Object.assign(document.createElement('p'), { style: 'height: 90vh' }))"
    )
    wait_to_see(page, lambda: page.evaluate(STOP)[3], "Save q below what is new")
    assert page.evaluate(STOP)[0] == "Save q"
