"""Converts a kernel over float64 to float32.

A kernel is a formula over a number, but its constants are float64, and in Numba a float32 times a float64 is a float64. So
``in_single`` copies a function, and every function of Ulna that it calls, with all constants as float32. An explicit float64 (the
scratch of a driver) becomes float32 too. It also replaces:

- the primitives of ``lanes``, by forms for one plain number;
- sine and cosine, whose reduction depends on the digits of a float64;
- the thresholds that depend on the rounding of a float64 (``THRESHOLDS``).
"""

import math
from collections.abc import Callable
from dis import get_instructions
from functools import cache
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

# By module and name: the threshold for the rounding of a float32, which is 2^29 times that of a float64.
THRESHOLDS = {
    ("ulna.kernels.layout", "CONTACT"): 1e-6,
    ("ulna.kernels.distance.box_sat", "_PARALLEL"): 1e-7,
    ("ulna.kernels.distance.box_sat", "_ROUNDING"): 1e-6,
    ("ulna.kernels.collision.posed_pair", "BALLS"): 1.0 + 4e-6,
}


@cache
def in_single(function: Callable) -> Any:
    """A function over float32: a driver, or a kernel; compiled if the function itself is."""
    plain: Any = getattr(function, "py_func", function)
    if (plain.__module__, plain.__name__) == _SINCOS:
        return _primitive("sincos")
    known = plain.__globals__
    loaded = {step.argval for step in get_instructions(plain.__code__) if step.opname == "LOAD_GLOBAL"}  # no attributes' names
    names = {name: _value(plain, name, known[name]) for name in plain.__code__.co_names if name in loaded & known.keys()}
    if "float" not in names:
        names["float"] = np.float32
    cells = tuple(CellType(_value(plain, "", cell.cell_contents)) for cell in plain.__closure__ or ())
    twin = FunctionType(_code(plain.__code__), names, plain.__name__, plain.__defaults__, cells)
    twin.__module__ = f"{plain.__module__}.single"
    twin.__dict__.update(plain.__dict__)
    return _as_compiled(twin, function)


def _as_compiled(twin: Callable, function: Any) -> Any:
    from ulna.engine import compiler  # noqa: PLC0415 - imports Numba, which an ahead-compiled wheel does not need

    options = getattr(function, "targetoptions", None)
    if options is None or compiler.is_disabled():
        return twin
    return compiler.compiled(twin, {key: value for key, value in options.items() if key != "nopython"})


def _code(code: CodeType) -> CodeType:
    return code.replace(co_consts=tuple(_number(constant) for constant in code.co_consts))


def _number(value: Any) -> Any:
    """Convert a float64, or a tuple of them, to float32; other values are unchanged."""
    if isinstance(value, float):
        with np.errstate(over="ignore"):
            return np.float32(value)
    return tuple(map(_number, value)) if type(value) is tuple else value


def _value(function: Any, name: str, value: Any) -> Any:
    """The value of a name in the copy of a function."""
    if value is np.float64:
        return np.float32
    if isinstance(value, float):
        home = next((home for home, known in THRESHOLDS if known == name and home in {function.__module__, _LAYOUT}), None)
        return _number(value if home is None else THRESHOLDS[home, name])
    if isinstance(value, ModuleType) and value.__name__ in _MODULES:
        return _MODULES[value.__name__]
    module = getattr(value, "__module__", None) or ""
    if module == "ulna.engine.lanes":
        return _primitive(value.__name__)
    if module.startswith("ulna.") and not isinstance(value, type) and callable(value):
        return in_single(value)
    return _number(value)


@cache
def _primitive(name: str) -> Any:
    if name not in _PRIMITIVES:
        raise LookupError(f"lanes.{name} has no form over float32")
    from ulna.engine import compiler  # noqa: PLC0415 - imports Numba too

    function = _PRIMITIVES[name]
    return function if compiler.is_disabled() else compiler.compiled(function, {})


def _module(name: str, **constants: Any) -> ModuleType:
    module = ModuleType(name)
    module.__dict__.update(constants)
    return module


def _sqrt(x):
    return np.sqrt(x)


def _sincos(x):
    return np.sin(x), np.cos(x)


def _where(mask, x, y):
    return x if mask else y


def _logical_not(mask):
    return not mask


def _any_lane(mask):
    return mask


def _splat(x, like):  # noqa: ARG001 - a primitive's arguments
    return np.float32(x)


def _load(rows, i):
    return rows[i]


def _store(rows, i, x):
    rows[i] = x


_LAYOUT, _SINCOS = "ulna.kernels.layout", ("ulna.kernels.spatial.elementary", "sincos")
_MODULES = {
    "numpy": _module("single_numpy", inf=np.float32(np.inf), nan=np.float32(np.nan), pi=np.float32(np.pi), float64=np.float32),
    "math": _module("single_math", pi=np.float32(math.pi)),
}
_PRIMITIVES: dict[str, Callable] = {
    "sqrt": _sqrt, "sincos": _sincos, "where": _where, "logical_not": _logical_not, "any_lane": _any_lane, "splat": _splat,
    "load": _load, "store": _store,
}  # fmt: skip
