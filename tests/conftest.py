"""Fixtures that all tests share."""

import hypothesis
import numpy as np
import pytest

import ulna

collect_ignore = ["fuzz_readers.py"]  # started by hand; needs atheris


@pytest.fixture(scope="session")
def panda():
    return ulna.load("panda")


@pytest.fixture
def rng():
    return np.random.default_rng(20240607)


# The same examples in every run: a failure in CI is a failure here. No deadline: the first example may compile.
hypothesis.settings.register_profile("ulna", deadline=None, derandomize=True, database=None)
hypothesis.settings.load_profile("ulna")
