"""Fixtures that all tests share."""

from importlib.util import find_spec

import hypothesis
import numpy as np
import pytest

import ulna
from page_fixtures import browser_of, open_page

__all__ = ["browser_of", "open_page"]
collect_ignore = ["fuzz_readers.py"]  # started by hand; needs atheris
if find_spec("numba") is None:
    collect_ignore += ["cuda_arguments.py", "gpu"]


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


# The same examples in every run: a failure in CI is a failure here. No deadline: the first example may compile.
hypothesis.settings.register_profile("ulna", deadline=None, derandomize=True, database=None)
hypothesis.settings.load_profile("ulna")
