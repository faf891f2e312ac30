"""Gives compiled entries a plain C interface, by which the extension calls them, in this process or from a wheel.

Numba passes an array as seven or more arguments, by rules of its own. Here the interface is ``int32 f(int64 *slots, int64
*result)``. The arguments occupy consecutive slots of 8 bytes: a number one, an array its address and its shape, None none, a
tuple those of its parts. All arrays are C-contiguous, so their strides follow. A nonzero return value means that memory was
exhausted.
"""

from collections.abc import Iterator
from functools import cache
from itertools import count
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types
from numba.core import cgutils

from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES, _refuse_unless_permitted
from ulna.engine.numba_private import AHEAD, have
from ulna.engine.signatures import Signature, fits, text_of_signature

_I64, _I32, _F64 = ir.IntType(64), ir.IntType(32), ir.DoubleType()
_RESULTS = {types.boolean: "b", types.int64: "i", types.none: "-"}


def result_code(compiled: Any) -> str:
    """The result type of an entry: b for True or False, i for an integer, - for None."""
    return _RESULTS[types.unliteral(compiled.signature.return_type)]


def plain_module(compiled: Any, symbol: str, triple: str, address: int | None = None) -> ir.Module:
    """A module with the function ``symbol``, which calls a compiled entry by name, or at an address if given."""
    context, signature = compiled.target_context, compiled.signature
    module = ir.Module(symbol)
    module.triple = triple
    convention = context.call_conv
    kind = convention.get_function_type(signature.return_type, signature.args)
    wrapper = ir.Function(module, ir.FunctionType(_I32, [_I64.as_pointer(), _I64.as_pointer()]), symbol)
    if "windows" in triple:
        wrapper.storage_class = "dllexport"
    builder = ir.IRBuilder(wrapper.append_basic_block())
    if address is None:
        callee = ir.Function(module, kind, compiled.fndesc.llvm_func_name)
    else:
        callee = builder.inttoptr(ir.Constant(_I64, address), kind.as_pointer())
    slots, result = wrapper.args
    places = (builder.gep(slots, [ir.Constant(_I64, k)]) for k in count())
    arguments = [_argument(context, builder, kind, places) for kind in signature.args]
    status, value = convention.call_function(builder, callee, signature.return_type, signature.args, arguments)
    if result_code(compiled) != "-":
        builder.store(value if value.type == _I64 else builder.zext(value, _I64), result)
    builder.ret(builder.zext(status.is_error, _I32))
    return module


def _argument(context: Any, builder: Any, kind: types.Type, places: Iterator[Any]) -> Any:
    """An argument in Numba's form, read from its slots."""
    if isinstance(kind, types.BaseTuple):
        return context.make_tuple(builder, kind, [_argument(context, builder, part, places) for part in kind.types])  # pyright: ignore[reportAttributeAccessIssue] - of every tuple
    if kind == types.none:
        return context.get_dummy_value()
    if not isinstance(kind, types.Array):
        value = builder.load(next(places))
        return value if kind == types.int64 else builder.bitcast(value, _F64)
    return _array(context, builder, kind, places)


def _array(context: Any, builder: Any, kind: types.Array, places: Iterator[Any]) -> Any:
    array = context.make_array(kind)(context, builder)
    element = context.get_data_type(kind.dtype)
    size = context.get_abi_sizeof(element)
    data = builder.inttoptr(builder.load(next(places)), element.as_pointer())
    shape = [builder.load(next(places)) for _ in range(kind.ndim)]
    strides, stride, items = [], ir.Constant(_I64, size), ir.Constant(_I64, 1)
    for length in reversed(shape):
        strides.insert(0, stride)
        stride, items = builder.mul(stride, length), builder.mul(items, length)
    array.meminfo = array.parent = cgutils.get_null_value(ir.IntType(8).as_pointer())
    array.nitems, array.itemsize, array.data = items, ir.Constant(_I64, size), data
    array.shape, array.strides = (cgutils.pack_array(builder, each) for each in (shape, strides))
    return array._getvalue()  # noqa: SLF001 - Numba's own name for it


def native_entry(entry: Any, leading: tuple, calls: Any) -> Any:
    """The extension's entry for these arguments, compiled if needed; None if no signature fits them.

    Raises:
        NotCompiledError: It is not compiled yet, and this thread may not compile now.
    """
    for signature in ENTRIES[entry].signatures if have(AHEAD) else ():
        if all(map(fits, leading, signature)):
            compiled_for(entry, signature)
            return _entry(entry, tuple(signature), calls)
    return None


def compiled_for(entry: Any, signature: Signature) -> Any:
    """Numba's compilation of an entry for a signature, compiled if needed.

    Raises:
        NotCompiledError: It is not compiled yet, and this thread may not compile now.
    """
    types = numba_types(signature)
    if types not in entry.overloads:
        _refuse_unless_permitted(entry)
        entry.compile(types)
    return entry.overloads[types]


@cache
def _entry(entry: Any, signature: Signature, calls: Any) -> Any:
    compiled, of_entry = compiled_for(entry, signature), ENTRIES[entry]
    overloads = ((_address(compiled, "plain"), text_of_signature(signature)),)
    return calls.make_entry(of_entry.name, overloads, result_code(compiled), not of_entry.low_latency)


_engines: list[Any] = []  # they hold the wrappers' machine code for the life of the process


def _address(compiled: Any, symbol: str) -> int:
    """The address of a plain wrapper (``plain``) around Numba's compilation."""
    code = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
    triple = llvm.get_process_triple()
    module = llvm.parse_assembly(str(plain_module(compiled, symbol, triple, code)))
    machine = llvm.Target.from_triple(triple).create_target_machine(opt=3, jit=True)
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    _engines.append(engine)
    return engine.get_function_address(symbol)
