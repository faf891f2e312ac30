"""The page of a Panda."""

import pytest

import ulna


@pytest.fixture
def view(panda):
    """The Panda on a page, without obstacles; ended after the test."""
    with ulna.view(panda) as view:
        yield view
