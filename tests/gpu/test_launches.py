"""Every launch of every method passes the launcher of numba-cuda and compiles for exactly the arguments that it is given.

Two processes see what one does not. The simulator runs the methods and takes any argument; ``launches.py`` writes down what each
launch is given, with its grid and stream. Here the compiler types each recorded array by its shape and strides. numba-cuda's own
``_prepare_args`` and cuda.core's own holder of arguments refuse what no launch can take. It needs no GPU.
"""

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from cuda.core._kernel_arg_handler import ParamHolder
from numba import cuda, types
from numba.cuda import dispatcher
from numba.cuda.cudadrv import devices
from numba.cuda.cudadrv.devicearray import DeviceNDArray

from gpu_parts import drivers_of_the_code, methods_with_out, public_methods
from ulna.gpu.single import in_single

PLAIN = {"int": int, "float": float, "bool": bool, "NoneType": lambda _: None}
MAX_THREADS = 1024  # of a block


@pytest.fixture(scope="module")
def recorded():
    environment = os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    program = [sys.executable, str(Path(__file__).parent / "launches.py")]
    done = subprocess.run(program, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def launches(recorded):
    return recorded["launches"]


def on_device(shape, strides, dtype):
    """An array on the device, as a launch is given it, here without memory."""
    memory = SimpleNamespace(device_ctypes_pointer=SimpleNamespace(value=0), size=0)
    with mock.patch.object(devices, "get_context", SimpleNamespace):  # an array without rows asks for one
        return DeviceNDArray(shape=tuple(shape), strides=tuple(strides), dtype=dtype, gpu_data=memory)


def dtype_of(name):
    module, _, record = name.partition(":")
    return getattr(importlib.import_module(module), record).structure if record else np.dtype(name)


def argument(recorded):
    if "parts" in recorded:
        module, _, name = recorded["of"].partition(":")
        parts = tuple(map(argument, recorded["parts"]))
        kind = getattr(importlib.import_module(module), name)
        return kind(*parts) if hasattr(kind, "_fields") else kind(parts)
    if "dtype" in recorded:
        return on_device(recorded["shape"], recorded["strides"], dtype_of(recorded["dtype"]))
    return PLAIN[recorded["type"]](recorded["value"])


def kinds_of(arguments):
    return tuple(cuda.jit(lambda *_: None).typeof_pyval(each) for each in arguments)


def parts_of(kinds):
    """Types of arguments, those of a tuple's parts one by one."""
    return [part for kind in kinds for part in (parts_of(kind.types) if isinstance(kind, types.BaseTuple) else [kind])]


def prepared(kinds, arguments):
    """Pass each argument through numba-cuda's preparation of a launch, and all of them to cuda.core."""
    launcher, plain = SimpleNamespace(extensions=()), []
    launcher._prepare_args = lambda *rest: dispatcher._Kernel._prepare_args(launcher, *rest)
    for kind, each in zip(kinds, arguments, strict=True):
        launcher._prepare_args(kind, each, 0, [], plain)
    ParamHolder(plain)


def driver_of(module, name, sizes, is_single):
    plain = getattr(importlib.import_module(module), name)
    plain = plain if sizes is None else plain(*sizes)
    return in_single(plain) if is_single else plain


def test_every_launch_is_typed_in_c_order_prepared_and_compiled(launches, ptx_of_driver):
    seen = {}
    for launch in launches:
        arguments = [argument(each) for each in launch["arguments"]]
        kinds = kinds_of(arguments)
        assert all(kind.layout == "C" for kind in parts_of(kinds) if isinstance(kind, types.Array)), launch
        prepared(kinds, arguments)
        seen[json.dumps(launch["driver"]), kinds] = launch["driver"]
    for (_, kinds), source in seen.items():
        assert ".visible .entry" in ptx_of_driver(driver_of(*source), kinds), source


def test_every_driver_of_the_code_is_launched(launches):
    assert {launch["driver"][1] for launch in launches} == drivers_of_the_code()


def test_every_public_method_is_called_and_every_out_is_given(recorded):
    assert {name for name, _ in recorded["calls"]} == set(public_methods())
    assert {name for name, has_out in recorded["calls"] if has_out} == methods_with_out()


def test_every_grid_has_blocks_and_threads(launches):
    for launch in launches:
        blocks, threads = launch["grid"]
        assert blocks >= 1, launch
        assert 1 <= threads <= MAX_THREADS, launch


def test_within_a_block_every_launch_is_on_its_stream(launches):
    in_block = [launch for launch in launches if launch["in_block"]]
    assert [launch for launch in in_block if launch["stream"] != "own"] == []
    assert {launch["driver"][1] for launch in in_block} >= {"poses_of", "edges_of", "searches_of", "choose", "turned_of", "join"}
    assert all(launch["stream"] != "own" for launch in launches if not launch["in_block"])


def test_what_no_launch_can_take_is_seen():
    none = argument({"type": "NoneType", "value": None})
    with pytest.raises(NotImplementedError):
        prepared(kinds_of([none]), (none,))
    with pytest.raises(TypeError, match="NoneType"):
        ParamHolder([none])


def test_a_stride_of_zero_is_seen():
    (kind,) = kinds_of([on_device((1, 7), (0, 8), np.dtype(float))])
    assert kind.layout != "C"
