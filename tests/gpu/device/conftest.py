"""The robot on a GPU, or in numba-cuda's simulator."""

import pytest


@pytest.fixture(scope="module")
def on_gpu(panda):
    return panda.on_gpu()
