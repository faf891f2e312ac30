"""What a person sees who asks for a GPU where there is none."""

import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import ulna


@pytest.mark.skipif(cuda.is_available(), reason="there is a GPU")
def test_without_a_gpu_there_is_one_clear_error():
    with pytest.raises(ulna.DeviceError, match="no NVIDIA GPU was found"):
        ulna.load("panda").on_gpu()
