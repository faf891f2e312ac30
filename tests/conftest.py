"""Fixtures that all tests share."""

import os
import shutil
from importlib.util import find_spec

import hypothesis
import numpy as np
import pytest

import ulna

os.environ.setdefault("ULNA_WARMUP", "0")  # no second process that compiles beside the tests, but in its own test
collect_ignore = ["fuzz_readers.py"]  # started by hand; needs atheris
if find_spec("numba") is None:
    collect_ignore += ["cuda_arguments.py", "gpu"]
if find_spec("franka_sim") is None:
    collect_ignore += ["franka"]  # make test-franka
if find_spec("coal") is None and not os.environ.get("ULNA_NO_SKIPS"):  # make test-lowest: the peers need NumPy 2
    collect_ignore += ["collision/test_near_pairs.py", "ik/test_ik.py", "ik/test_ik_other_arms.py"]


@pytest.hookimpl(hookwrapper=True)
def pytest_collect_file():
    """Look for no examples in docstrings of tests, which have none: each file would be imported and walked once more."""
    outcome = yield
    outcome.force_result([found for found in outcome.get_result() if type(found) is pytest.Module])


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark what opens a page in a browser as ``process``: without a GPU each picture takes half a second."""
    for item in items:
        if "open_page" in item.fixturenames:
            item.add_marker(pytest.mark.process)


@pytest.fixture(scope="session")
def panda():
    return ulna.load("panda")


@pytest.fixture(scope="module")
def q(panda):
    """Forty configurations of the Panda within its limits."""
    return np.random.default_rng(41).uniform(panda.lower, panda.upper, (40, 7))


@pytest.fixture(scope="module")
def targets(panda, q):
    """Forty poses that the Panda reaches: those of ``q``."""
    return panda.forward_kinematics(q)


@pytest.fixture
def rng():
    return np.random.default_rng(20240607)


# Headless Chromium for all pages: one, and another for a second tab, as only one tab of a browser is drawn. A process has one
# Playwright. It is imported when first used, for the ROS environments have none.
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

    A slow machine opens it slowly: it has five minutes. When the test ends, its buttons are let go and it is closed.
    """
    from browser import COARSE, SIZE

    opened = []

    def open_page(url, browser=0, size=SIZE, scheme="light"):
        page = browser_of(browser).new_page(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
        opened.append(page)
        page.set_default_timeout(300_000)  # [ms]
        page.addresses = []
        page.on("request", lambda request: page.addresses.append(request.url))
        page.goto(f"{url}{'&' if '?' in url else '?'}fixedDpr={COARSE}")
        page.get_by_role("status").first.wait_for()
        return page

    yield open_page
    for page in opened:
        if not page.is_closed():
            page.mouse.up()
            page.close()


# The same examples in every run: a failure in CI is a failure here. No deadline: the first example may compile.
hypothesis.settings.register_profile("ulna", deadline=None, derandomize=True, database=None)
hypothesis.settings.load_profile("ulna")
