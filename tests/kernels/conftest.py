"""The kernels' own fixture: ``run`` evaluates a probe in one of the modes that this process has."""

from functools import partial

import pytest

import kernel_modes

# Without the compiler there is no machine code to look at.
collect_ignore = [] if kernel_modes.COMPILED else ["test_vectorised.py"]


@pytest.fixture(params=kernel_modes.MODES)
def run(request):
    return partial(kernel_modes.run, request.param)
