"""Headless Chromium for all pages: one, and another for a second tab, as only one tab of a browser is drawn.

Fixtures of ``conftest``: a process has one Playwright. It is imported when first used, for the ROS environments have none.
"""

import shutil

import pytest


@pytest.fixture(scope="session")
def browser_of():
    """Starts browser 0, 1, ... when it is first asked for."""
    from playwright.sync_api import sync_playwright

    from browser import FLAGS

    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("no Chromium on this machine: on Debian, apt-get install chromium")
    started = {}
    with sync_playwright() as playwright:

        def browser_of(number):
            if number not in started:
                started[number] = playwright.chromium.launch(executable_path=chromium, args=list(FLAGS))
            return started[number]

        yield browser_of
        for browser in started.values():
            browser.close()


@pytest.fixture
def open_page(browser_of):
    """Opens a page at an address, in a tab of its own; ``page.addresses`` has what it asked for.

    A slow machine opens it slowly: it has no limit of time. When the test ends, its buttons are let go and it is closed.
    """
    from browser import SIZE

    opened = []

    def open_page(url, browser=0, size=SIZE):
        page = browser_of(browser).new_page(viewport={"width": size[0], "height": size[1]})
        opened.append(page)
        page.set_default_timeout(0)
        page.addresses = []
        page.on("request", lambda request: page.addresses.append(request.url))
        page.goto(url)
        page.get_by_role("status").first.wait_for()
        return page

    yield open_page
    for page in opened:
        if not page.is_closed():
            page.mouse.up()
            page.close()
