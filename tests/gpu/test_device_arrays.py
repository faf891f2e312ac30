"""Arrays of other libraries, taken and given by both protocols: what can be seen of it without a GPU.

An array on a GPU is played by one of NumPy that says so. ``device/test_gpu_robot.py`` has the same on a GPU.
"""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from cuda.core.utils import StridedMemoryView

import ulna
from ulna.gpu import device, device_array
from ulna.gpu.device_array import _class_with_dlpack, as_own, as_shaped, description, is_on_device, with_dlpack
from ulna.gpu.queue import as_stream


class Foreign:
    """An array that has DLPack alone, on a device of some kind."""

    def __init__(self, array, kind, card=0):
        self.array, self.kind, self.card, self.streams = array, kind, card, []

    def __dlpack_device__(self):
        return self.kind, self.card

    def __dlpack__(self, *, stream=None, **asked):
        self.streams.append(stream)
        return self.array.__dlpack__(**asked)


class Interfaced(Foreign):
    """An array that also has ``__cuda_array_interface__``, with a stream or without, as CuPy's and PyTorch's."""

    def __init__(self, array, card=0, **interface):
        super().__init__(array, 2, card)
        self.__cuda_array_interface__ = interface


class Interface:
    """An array that has ``__cuda_array_interface__`` alone."""

    def __init__(self, **interface):
        self.__cuda_array_interface__ = interface


def view_of(foreign, sync):
    """Numba's view by ``__cuda_array_interface__``."""
    assert not sync
    pointer = SimpleNamespace(value=64)
    return SimpleNamespace(owner=foreign, stream=foreign.__cuda_array_interface__.get("stream") or 0, size=3,
                           device_ctypes_pointer=pointer)  # fmt: skip


@pytest.fixture(params=[False, True])
def per_thread(monkeypatch, request):
    """Whether Numba has a stream for each thread; in the place of numba-cuda is what returns a description and its owner."""
    config = SimpleNamespace(CUDA_PER_THREAD_DEFAULT_STREAM=request.param, ENABLE_CUDASIM=False)
    fake = SimpleNamespace(
        config=config, from_cuda_array_interface=lambda desc, owner: (desc, owner), as_cuda_array=view_of,
        get_current_device=lambda: SimpleNamespace(id=0), default_stream=lambda: "default",
    )  # fmt: skip
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
    assert foreign.streams == [1], "PyTorch refuses 2, the default stream of a thread, which waits for 1"
    assert (taken["shape"], taken["strides"], taken["typestr"]) == ((2, 3, 2), array.strides, "<f8")
    assert taken["data"][0] == array.ctypes.data
    assert owner.exporting_obj is foreign


@pytest.fixture
def in_driver(monkeypatch):
    """The driver, which knows the card of each address."""
    cards = {}
    binding = SimpleNamespace(CUdeviceptr=int, CUpointer_attribute=SimpleNamespace(CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL="ordinal"))
    driver = SimpleNamespace(cuPointerGetAttribute=lambda what, pointer: cards.get((what, pointer), 0))
    monkeypatch.setattr(device_array, "_driver", lambda: SimpleNamespace(driver=driver, binding=binding))
    return cards


@pytest.fixture
def waits(per_thread, in_driver):
    """The streams of events: recorded, waiting, and so on."""
    streams = []
    device_array.cuda.event = lambda **_: SimpleNamespace(record=streams.append, wait=streams.append)
    return streams


@pytest.mark.parametrize("stream", [0, 7])
def test_an_interface_without_a_stream_is_left_for_dlpack_which_waits(waits, stream):
    tensor = Interfaced(np.zeros(3), version=2)
    _, owner = as_own("q", tensor, stream)
    assert owner.exporting_obj is tensor
    assert tensor.streams == [stream or 1]
    alone = Interface(version=2)
    assert as_own("q", alone, stream).owner is alone
    assert not waits


def test_the_stream_that_an_interface_names_is_waited_for(waits):
    array = Interfaced(np.zeros(3), version=3, stream=9)
    assert as_own("q", array).owner is array
    assert as_own("q", array, 7).owner is array
    assert waits == [9, "default", 9, 7]
    assert as_own("q", Interfaced(np.zeros(3), version=3, stream=None), 7).stream == 0
    assert not array.streams
    assert len(waits) == 4


def test_an_array_on_another_card_is_refused_with_both_numbers(per_thread, in_driver, monkeypatch):
    in_driver["ordinal", 64] = 2
    memory = SimpleNamespace(context=SimpleNamespace(device=SimpleNamespace(id=2)))
    numba = SimpleNamespace(__cuda_ndarray__=True, size=3, gpu_data=memory, stream=0)
    interfaced, alone = Interfaced(np.zeros(3), card=2, version=3, stream=None), Interface(version=3, stream=None)
    for array in (Foreign(np.zeros(3), 2, card=2), interfaced, alone, numba):
        with pytest.raises(ulna.DeviceError, match=r"q is on card 2, but Numba has selected card 0"):
            as_own("q", array)
    as_own("q", Foreign(np.zeros(3), 13, card=2))  # managed memory is on every card
    monkeypatch.setattr(device_array.cuda, "get_current_device", lambda: SimpleNamespace(id=2))
    for array in (Foreign(np.zeros(3), 2, card=2), interfaced, alone, numba):
        as_own("q", array)


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


@pytest.fixture
def with_stream(monkeypatch):
    """Makes an array as a call returns it, computed on a stream."""
    monkeypatch.setattr(device_array.cuda.config, "ENABLE_CUDASIM", False)
    data = SimpleNamespace(device_ctypes_pointer=SimpleNamespace(value=64), size=48)
    return lambda stream: device_array._as_shaped(data, (2, 3), np.dtype(float), stream)


@pytest.mark.parametrize(("stream", "number"), [(0, 1), (9, 9)])
def test_every_view_of_a_result_names_its_stream(with_stream, stream, number):
    own = with_stream(stream)
    views = own, own.reshape(6), own.reshape(3, 2), own.reshape((2, 3)), as_shaped(own, (6,)), with_dlpack(own)
    assert [view.__cuda_array_interface__["stream"] for view in views] == [number] * 6
    assert all(view.stream == stream for view in views)


def test_memory_is_freed_before_its_stream_ends(monkeypatch):
    """The driver frees memory in the order of a stream, so this one has to exist."""
    events = []

    class Stream(int):
        def __del__(self):
            events.append("the stream ends")

    class Buffer:
        handle = 64

        def __del__(self):
            events.append("the memory is freed")

    allocated = []
    pool = SimpleNamespace(allocate=lambda size, stream: allocated.append((size, stream)) or Buffer())
    context = SimpleNamespace(device=SimpleNamespace(id=0))
    pointer = lambda *_, owner: SimpleNamespace(owner=owner)  # noqa: E731
    driver = SimpleNamespace(binding=SimpleNamespace(CUdeviceptr=int), MemoryPointer=pointer)
    monkeypatch.setattr(device_array, "_pool", lambda _: pool)
    monkeypatch.setattr(device_array, "_driver", lambda: driver)
    monkeypatch.setattr(device_array, "_core_stream", int)
    monkeypatch.setattr(device_array.cuda, "current_context", lambda: context)
    monkeypatch.setattr(device_array.cuda.config, "ENABLE_CUDASIM", False)
    array = device_array.empty((2, 3), float, Stream(9))
    assert allocated == [(48, 9)]
    data = array.bind(0).gpu_data  # a view without a stream
    del array
    assert not events
    del data
    assert events == ["the memory is freed", "the stream ends"]


def test_the_stream_of_another_library_is_kept_while_it_is_used(monkeypatch):
    monkeypatch.setattr("ulna.gpu.queue.cuda.external_stream", lambda number: SimpleNamespace(number=number))
    theirs = SimpleNamespace(ptr=9)
    assert as_stream(theirs).source is theirs
    assert as_stream(theirs).number == 9


def test_memory_that_the_pool_keeps_is_free(monkeypatch):
    pending = [100]
    deallocations = SimpleNamespace(clear=pending.clear)
    context = SimpleNamespace(get_memory_info=lambda: (1000 - sum(pending), 2000), deallocations=deallocations)
    attributes = SimpleNamespace(reserved_mem_current=500, used_mem_current=200)
    monkeypatch.setattr(device_array, "_pool", lambda _: SimpleNamespace(attributes=attributes))
    monkeypatch.setattr(device_array, "card", lambda: 0)
    monkeypatch.setattr(device_array.cuda.config, "ENABLE_CUDASIM", False)
    monkeypatch.setattr(device_array.cuda, "current_context", lambda: context)
    assert device.free_memory() == 900 + 300
    assert device.free_memory(1200) == 1200
    assert pending
    assert device.free_memory(1201) == 1300, "what Numba would free later is freed"
