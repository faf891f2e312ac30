"""The page of a Panda."""

import pytest

import ulna
from processes import wait_for


@pytest.fixture
def world():
    """No obstacles; a file of tests may have others."""
    return ulna.World()


@pytest.fixture
def crate():
    """A world with a crate beside the Panda."""
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, -0.4, 0.05)))
    return world


@pytest.fixture
def view(panda, world):
    """The Panda on a page, among the obstacles; ended after the test."""
    with ulna.view(panda, world) as view:
        yield view


@pytest.fixture
def page(view, open_page):
    """The page, once all its kernels are compiled; a new one for each test."""
    page = open_page(view.url)
    wait_for(lambda: view.ready and view.page.server.get_clients(), "a page that is ready", looks=None)
    return page
