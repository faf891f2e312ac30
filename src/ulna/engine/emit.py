"""Writes the machine code of entries as object files, for a wheel.

``python -m ulna.engine.emit ulna FOLDER PART`` writes one of two parts. The part ``together`` contains the entries that are
compiled in one process (``Entries.are_together``). The part ``rest`` contains all other entries.

1. Numba compiles an entry for one signature, for the CPU that ``NUMBA_CPU_NAME`` names, as it does in a running program.
2. A second function is added to its optimized module, with a plain C interface of 8-byte slots (``native``).
3. Everything else in the module becomes private, and unused parts are removed: Numba's own wrapper, which needs Python. The texts
   of Numba's errors are cleared: nothing reads them, and they contain paths of the building machine.
4. LLVM writes the module as a position-independent object file. It does not optimize again: the arithmetic is that of step 1.
5. The same is done with the routines that entries share (``shared``), each once.

The index of the output goes to ``together.json`` and ``rest.json``. It contains for each entry its result, whether it releases
the interpreter's lock, and the symbol, signature and object files of each of its compilations.
"""

import hashlib
import json
import os
import re
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from numba import config

from ulna.engine.cache import compiler_hash
from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES
from ulna.engine.entries import Entries
from ulna.engine.native import plain_module, result_code
from ulna.engine.numba_private import AHEAD, CODE, NullCache, have, missing_of
from ulna.engine.shared import DISPATCHERS, SHARED, Shared
from ulna.engine.signatures import Signature, text_of_signature
from ulna.engine.sources import sources_hash, text_of
from ulna.errors import UlnaError

_settings: Any = config  # its names are created at load time
_CPU, _FEATURES = _settings.CPU_NAME or "", _settings.CPU_FEATURES or ""


def write_objects(entries: Entries, folder: Path, part: str) -> None:
    """Write an object file for each signature of each entry of a part, and the index; existing files are kept."""
    if not have(AHEAD, CODE):
        raise UlnaError(f"no wheel can be built with this version of Numba, which lacks {', '.join(missing_of(AHEAD, CODE))}")
    folder.mkdir(parents=True, exist_ok=True)
    names = [name for name in sorted(entries.names()) if entries.are_together(name) == (part == "together")]
    index = [_write_entry(entries, name, folder) for name in names]
    write_whole(folder / f"{part}.json", json.dumps(index, indent=1).encode())


def write_whole(path: Path, content: bytes) -> None:
    """Write a temporary file and rename it, so that the file is complete or absent.

    A killed process leaves a file that ends in ``.part``.
    """
    handle, beside = tempfile.mkstemp(prefix=path.name, suffix=".part", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(beside).replace(path)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise


def _write_entry(entries: Entries, name: str, folder: Path) -> dict[str, Any]:
    marked = entries.marked(name)
    for dispatcher in (marked, *DISPATCHERS):
        dispatcher._cache = NullCache()  # noqa: SLF001 - as engine.compiler sets it: code loaded from disk has no module
        dispatcher.targetctx.refresh()  # as the cache does: keeps the order of Numba's own functions
    calls, overloads, results = ENTRIES[marked], [], set()
    hashed = sources_hash(marked.py_func.__code__.co_filename)
    for k, signature in enumerate(calls.signatures):
        symbol = f"ulna_{name.replace('.', '_')}_{k}"
        file = folder / f"{symbol}-{hashed}-{_own_hash()}.json"  # written last
        if not file.exists():
            write_whole(file, json.dumps(_write_overload(marked, signature, symbol, folder)).encode())
        overload = json.loads(file.read_text())
        results.add(overload.pop("result"))
        overloads.append(overload)
    (code,) = results
    return {"name": name, "result": code, "releases_lock": not calls.low_latency, "overloads": overloads}


def _write_overload(marked: Any, signature: Signature, symbol: str, folder: Path) -> dict[str, Any]:
    """Write the object files of an entry for one signature: its own, and those of its shared routines."""
    types = numba_types(signature)
    marked.compile(types)
    compiled = marked.overloads[types]
    module = compiled.library._final_module.clone()  # noqa: SLF001 - Numba's input to LLVM
    module.link_in(llvm.parse_assembly(str(plain_module(compiled, symbol, module.triple))))
    own = f"{symbol}-{sources_hash(marked.py_func.__code__.co_filename)}-{_own_hash()}.o"
    write_whole(folder / own, _object_code(module, symbol))
    objects = [own, *(_write_shared(shared, folder) for shared in _called(module))]
    return {"result": result_code(compiled), "symbol": symbol, "signature": text_of_signature(signature), "objects": objects}


def _called(module: llvm.ModuleRef) -> list[Shared]:
    """The shared routines that a module calls, directly or through others."""
    found, modules = {}, [module]
    while modules:
        named = {function.name for function in modules.pop().functions if function.is_declaration}
        new = {symbol: SHARED[symbol] for symbol in sorted(named & SHARED.keys() - found.keys())}
        found |= new
        modules += [shared.compiled.library._final_module for shared in new.values()]  # noqa: SLF001 - as above
    return list(found.values())


def _write_shared(shared: Shared, folder: Path) -> str:
    """Write the object file of a shared routine, unless it exists; returns its name."""
    name = f"{shared.symbol}-{_own_hash()}.o"
    if not (folder / name).exists():
        write_whole(folder / name, _object_code(_module_of(shared), shared.symbol))
    return name


def _module_of(shared: Shared) -> llvm.ModuleRef:
    """A copy of a shared routine's module, with the symbol that its callers use."""
    module = shared.compiled.library._final_module.clone()  # noqa: SLF001 - as above
    function = module.get_function(shared.compiled.fndesc.llvm_func_name)
    function.name, function.visibility = shared.symbol, "hidden"
    return module


@cache
def _own_hash() -> str:
    """Hash of the modules that write object files, the CPU, and the compiler."""
    own = text_of(__file__) + text_of(str(Path(__file__).with_name("native.py"))) + str(_CPU).encode()
    return f"{hashlib.sha256(own).hexdigest()[:16]}-{compiler_hash()}"


_PICKLED = re.compile(r'^(@\.const\.pickledata\.\w+(?:\.sha1)? = [^"\n]*\] )c"[^"\n]*"', re.MULTILINE)
"""The initial value of an error's text, and of its hash."""


def _object_code(module: llvm.ModuleRef, symbol: str) -> bytes:
    """The object code of a module; all functions but one become private, and unused ones are removed."""
    module = llvm.parse_assembly(_PICKLED.sub(r"\1zeroinitializer", str(module)))
    for function in module.functions:
        if not function.is_declaration and function.name != symbol:
            function.linkage = llvm.Linkage.internal
    for variable in module.global_variables:
        if not variable.is_declaration:
            variable.linkage = llvm.Linkage.internal
    _remove_unused(module)
    target = llvm.Target.from_triple(module.triple)
    machine = target.create_target_machine(cpu=_CPU, features=_FEATURES, opt=3, reloc="pic", codemodel="default")
    return machine.emit_object(module)


def _remove_unused(module: llvm.ModuleRef) -> None:
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    machine = llvm.Target.from_triple(module.triple).create_target_machine()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))


def _main() -> None:
    package, folder, part = sys.argv[1:]
    write_objects(Entries(package), Path(folder), part)


if __name__ == "__main__":
    _main()
