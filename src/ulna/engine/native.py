"""Gives the extension the addresses of code that Numba has compiled in this process."""

from functools import cache
from typing import Any

import llvmlite.binding as llvm

from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES, _refuse_unless_permitted
from ulna.engine.plain import plain_module, result_code
from ulna.engine.signatures import Signature, fits, text_of_signature


def native_entry(entry: Any, leading: tuple, calls: Any) -> Any:
    """An entry of the extension for the signature that takes these arguments, compiled if need be; None if none takes them.

    Raises:
        NotCompiledError: It is not compiled yet, and this thread may not compile now.
    """
    for signature in ENTRIES[entry].signatures:
        if all(map(fits, leading, signature)):
            types = numba_types(signature)
            if types not in entry.overloads:
                _refuse_unless_permitted(entry)
                entry.compile(types)
            return _entry(entry, tuple(signature), calls)
    return None


@cache
def _entry(entry: Any, signature: Signature, calls: Any) -> Any:
    compiled, of_entry = entry.overloads[numba_types(signature)], ENTRIES[entry]
    overloads = ((_address(compiled, "plain"), text_of_signature(signature)),)
    return calls.make_entry(of_entry.name, overloads, result_code(compiled), not of_entry.low_latency)


_engines: list[Any] = []  # what holds the wrappers' machine code, for as long as the process runs


def _address(compiled: Any, symbol: str) -> int:
    """The address of a plain wrapper (``plain``) about what Numba has compiled."""
    code = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
    triple = llvm.get_process_triple()
    module = llvm.parse_assembly(str(plain_module(compiled, symbol, triple, code)))
    machine = llvm.Target.from_triple(triple).create_target_machine(opt=3, jit=True)
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    _engines.append(engine)
    return engine.get_function_address(symbol)
