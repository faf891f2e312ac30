"""All words, signs and controls of the demo's page can be told from what is behind them."""

import pytest

from contrast import SIZES, faint, resize, seen_on
from ulna.demo.page import DemoApp
from ulna.demo.scenario import Demo

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everything_on_the_page_of_the_demo_can_be_told_from_its_ground(open_page, scheme):
    app = DemoApp(Demo(), port=0)
    try:
        page = open_page(app.url, scheme=scheme)
        page.get_by_text("free", exact=True).first.wait_for()
        page.get_by_role("checkbox", name="Plan around the box").check()
        for size in SIZES.values():
            resize(page, size)
            seen = seen_on(page)
            assert faint(seen) == []
            assert {"Record", "joint7", "Drag the orange box into the arm."} <= {one.words for one in seen}
    finally:
        app.stop()
