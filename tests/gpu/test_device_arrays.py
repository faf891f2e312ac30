"""Arrays of other libraries, taken and given by DLPack: what can be seen of it without a GPU.

An array on a GPU is played by one of NumPy that says so. ``device/test_gpu_robot.py`` has the same on a GPU.
"""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from cuda.core.utils import StridedMemoryView

import ulna
from ulna.gpu import device_array
from ulna.gpu.device_array import _class_with_dlpack, as_own, description, is_on_device


class Foreign:
    """An array that has DLPack alone, on a device of some kind."""

    def __init__(self, array, kind):
        self.array, self.kind, self.streams = array, kind, []

    def __dlpack_device__(self):
        return self.kind, 0

    def __dlpack__(self, *, stream=None, **asked):
        self.streams.append(stream)
        return self.array.__dlpack__(**asked)


@pytest.fixture(params=[False, True])
def per_thread(monkeypatch, request):
    """Whether Numba has a stream for each thread; in the place of numba-cuda is what returns a description and its owner."""
    config = SimpleNamespace(CUDA_PER_THREAD_DEFAULT_STREAM=request.param, ENABLE_CUDASIM=False)
    fake = SimpleNamespace(config=config, from_cuda_array_interface=lambda desc, owner: (desc, owner))
    monkeypatch.setattr(device_array, "cuda", fake)
    return request.param


@pytest.mark.parametrize(("kind", "expected"), [(1, False), (2, True), (3, False), (13, True), (10, False)])
def test_dlpack_says_where_an_array_is(kind, expected):
    assert is_on_device(Foreign(np.zeros(3), kind)) is expected


def test_what_has_neither_protocol_is_on_the_host():
    assert not is_on_device([1.0, 2.0])
    assert not is_on_device(np.zeros(3))
    assert is_on_device(SimpleNamespace(__cuda_array_interface__={}))


def test_an_array_is_taken_in_its_place_after_the_work_that_writes_it(per_thread):
    array = np.arange(24.0).reshape(2, 3, 4)[:, :, ::2]
    foreign = Foreign(array, 2)
    taken, owner = as_own("q", foreign)
    assert foreign.streams == [2 if per_thread else 1]
    assert (taken["shape"], taken["strides"], taken["typestr"]) == ((2, 3, 2), array.strides, "<f8")
    assert taken["data"][0] == array.ctypes.data
    assert owner.exporting_obj is foreign


def test_an_array_on_the_host_is_left_to_numpy():
    for kind in (1, 3):
        foreign = Foreign(np.zeros(3), kind)
        assert as_own("q", foreign) is foreign


def test_a_device_of_another_maker_is_refused_by_name():
    with pytest.raises(ulna.InputError, match=r"q.*kind 10 of DLPack"):
        as_own("q", Foreign(np.zeros(3), 10))


def test_the_description_of_a_view_is_that_of_the_array():
    for array in (np.zeros((3, 4)), np.zeros((3, 4), np.float32).T, np.zeros(0, np.int8), np.array(2.5)):
        own = description(StridedMemoryView.from_dlpack(array, stream_ptr=-1))
        assert (own["shape"], own["typestr"]) == (array.shape, array.dtype.str)
        assert own["strides"] in (None, array.strides)
        assert own["data"][0] == array.ctypes.data or not array.size


def test_results_are_given_by_dlpack_after_the_work_that_writes_them(monkeypatch):
    waited = []
    event = SimpleNamespace(record=waited.append, wait=waited.append)
    config = SimpleNamespace(CUDA_PER_THREAD_DEFAULT_STREAM=False, ENABLE_CUDASIM=False)
    monkeypatch.setattr(
        device_array,
        "cuda",
        SimpleNamespace(config=config, default_stream=lambda: 1, external_stream=int, event=lambda **_: event),
    )
    array = np.arange(6.0).reshape(2, 3)
    data = SimpleNamespace(device_ctypes_pointer=SimpleNamespace(value=array.ctypes.data), size=array.nbytes)
    own = _class_with_dlpack()(shape=(2, 3), strides=array.strides, dtype=array.dtype, gpu_data=data)
    on_host = StridedMemoryView.from_dlpack(array, stream_ptr=-1)  # cuda.core asks the driver where memory is: there is none
    monkeypatch.setattr(type(own), "_view", lambda _: on_host)
    assert own.__dlpack_device__() == (1, 0)
    np.testing.assert_array_equal(
        np.from_dlpack(SimpleNamespace(__dlpack__=own.__dlpack__, __dlpack_device__=lambda: (1, 0))), array
    )
    assert not waited, "the caller works on the same stream"
    own.__dlpack__(stream=7)
    assert waited == [1, 7], "stream 7 waits for what stream 1 has been given"
    own.__dlpack__(stream=-1)
    assert waited == [1, 7]
    assert own.__cuda_array_interface__["shape"] == (2, 3)
    assert type(own.reshape(6)) is type(own)
