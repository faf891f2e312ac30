"""What a person sees who asks for a GPU where there is none."""

import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import ulna
from ulna.gpu import device_array


@pytest.mark.skipif(cuda.is_available(), reason="there is a GPU")
def test_without_a_gpu_there_is_one_clear_error():
    with pytest.raises(ulna.DeviceError, match="no NVIDIA GPU was found"):
        ulna.load("panda").on_gpu()


def test_a_numpy_that_the_compiler_cannot_use_is_refused_with_the_remedy(monkeypatch):
    def without_a_name(module):
        raise AttributeError(f"module 'numpy' has no attribute 'row_stack' in {module}")

    panda = ulna.load("panda")
    monkeypatch.setattr(device_array.importlib, "import_module", without_a_name)
    with pytest.raises(ulna.DeviceError, match=r"cannot be used with NumPy .*row_stack.*pip install 'numpy<2\.5'"):
        panda.on_gpu()
