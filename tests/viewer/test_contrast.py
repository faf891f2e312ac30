"""All words, signs and controls of the page can be told from what is behind them: on a light page, a dark one, and on a phone."""

import pytest

from contrast import SIZES, Seen, faint, resize, seen_on
from processes import wait_for
from ulna.viewer.html import status_line
from ulna.viewer.palette import GREEN, RED, STOPPED, UNKNOWN

OPEN_ALL = """() => [...document.querySelectorAll('[role=button][aria-expanded=false]')]
    .filter((folder) => folder.checkVisibility()).forEach((folder) => folder.click())"""


@pytest.fixture
def world(crate):
    return crate


def plan(view):
    T = view.session.hand_pose
    T[1, 3] += 0.2
    with view.session.lock:
        view.plans.planning.turn(on=True)
        view.plans.planning.send(T)
    view._on_event()


def choose_obstacle(view):
    with view.obstacles.lock:
        view.obstacles.form.choose("crate")
    view._on_event()


TABS = {
    "Move": lambda view: view.link.choose(""),
    "Obstacles": choose_obstacle,
    "Plan": plan,
    "Steer": lambda view: view.steer._do(lambda: view.steer.steering.turn(on=True)),
    "Look": lambda view: view.link.choose("panda_link3"),
}
SHOWN = {"Move": "Save q", "Obstacles": "Delete", "Plan": "Copy as Python", "Steer": "move +x", "Look": "Attach crate"}


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everything_on_the_page_can_be_told_from_its_ground(view, open_page, scheme):
    page, seen = open_page(view.url, scheme=scheme), {}
    wait_for(lambda: view.ready and not view.notice.text, "a page that is ready", looks=None)
    for size in SIZES:
        resize(page, SIZES[size])
        for tab, begin in TABS.items():
            page.get_by_role("tab", name=tab).click()
            begin(view)
            page.wait_for_timeout(300)
            page.evaluate(OPEN_ALL)
            page.get_by_role("button", name=SHOWN[tab]).first.wait_for()
            seen[tab, size] = seen_on(page)
        page.get_by_label("Link", exact=True).click()
        page.get_by_role("option", name="panda_link2").wait_for()
        seen["a list", size] = seen_on(page)
        page.keyboard.press("Escape")
        page.get_by_role("tab", name="Look").focus()
        page.keyboard.press("?")
        page.get_by_role("dialog", name="Keys").wait_for()
        seen["the keys", size] = seen_on(page)
        page.keyboard.press("Escape")
        page.get_by_role("button", name="Settings").last.click()
        page.get_by_text("Scene tree").wait_for()
        seen["viser's settings", size] = seen_on(page)
        page.get_by_role("button", name="Settings").last.click()
        page.get_by_role("tab", name="Look").wait_for()
    assert {place: few for place, all_of_it in seen.items() if (few := faint(all_of_it))} == {}
    assert {"text", "sign", "control"} == {one.kind for all_of_it in seen.values() for one in all_of_it}
    assert len({one.words for all_of_it in seen.values() for one in all_of_it}) > 100


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_marks_of_all_colors_can_be_told_from_their_ground(view, open_page, scheme):
    """A light page has the marks darker than the scene has their colors."""
    page, marks = (
        open_page(view.url, scheme=scheme),
        "".join(status_line("mark", color) for color in (GREEN, RED, STOPPED, UNKNOWN)),
    )
    page.evaluate(
        "(marks) => document.querySelector('[role=status]').parentElement.insertAdjacentHTML('beforeend', marks)", marks
    )
    seen = [one for one in seen_on(page) if one.element.startswith("span") and one.kind == "sign"]
    assert len(seen) >= 5
    assert faint(seen) == []


def test_faint_words_are_found():
    gray = Seen("text", "gray", "p", 4.4, large=False, inactive=False)
    assert faint([gray]) == ["4.40: text 'gray' (p)"]
    assert faint([gray._replace(large=True), gray._replace(inactive=True), gray._replace(contrast=4.6)]) == []


def test_contrast_is_that_of_the_guidelines(browser_of):
    """Black on white has 21 to 1, gray 119 on white 4.48 to 1, and half of an opacity counts."""
    page = browser_of(0).new_page()
    half = "<div style='opacity:.5;background:#fff'><p style='color:#000'>c</p></div>"
    page.set_content(f"<p style='color:#000'>a</p><p style='color:#777'>b</p>{half}")
    found = {one.words: one.contrast for one in seen_on(page)}
    page.close()
    assert found == pytest.approx({"a": 21.0, "b": 4.48, "c": 3.98}, abs=0.06)
