"""The page of a Panda."""

import pytest

import ulna
from processes import wait_for


@pytest.fixture
def view(panda):
    """The Panda on a page, without obstacles; ended after the test."""
    with ulna.view(panda) as view:
        yield view


@pytest.fixture
def page(view, open_page):
    """The page, once all its kernels are compiled; a new one for each test."""
    page = open_page(view.url)
    wait_for(lambda: view.ready and view.page.server.get_clients(), "a page that is ready", looks=None)
    return page
