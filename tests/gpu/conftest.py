"""The CUDA compiler, without a device and without a driver: numba-cuda and the compiler's wheels."""

from functools import partial
from types import SimpleNamespace

import pytest

CAPABILITY = (9, 0)  # what is compiled for: H100 and H200


@pytest.fixture(scope="session")
def ptx():
    """Compiles a plain Python function as a device function for argument types, and returns the PTX."""
    from numba import cuda

    with pytest.MonkeyPatch.context() as patch:
        # A kernel that calls others asks a device for its capability, although the capability is given.
        patch.setattr("numba.cuda.dispatcher.get_current_device", lambda: SimpleNamespace(compute_capability=CAPABILITY))
        yield partial(_compile, cuda)


@pytest.fixture(scope="session")
def ptx_of_driver(ptx):
    """The same for what is run on the device."""
    return partial(ptx, device=False)


def _compile(cuda, function, types, *, device=True) -> str:
    return cuda.compile_ptx(function, types, device=device, cc=CAPABILITY)[0]
