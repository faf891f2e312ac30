"""Writes the machine code of entries as object files, for a wheel. Used by ``hatch_build.py``, as two programs for each level.

``python -m ulna.engine.emit ulna.drivers:DRIVERS FOLDER together``, and ``rest``: the entries that are compiled in one process
(``Entries.compiled_together``), and the others.

1. Numba compiles an entry for one signature, for the CPU that ``NUMBA_CPU_NAME`` names, as it does when a program runs.
2. A second function is added to its optimised module: one with a plain C interface, which takes slots of 8 bytes (``plain``).
3. All else in the module becomes private, and what nothing uses any more is removed: Numba's own wrapper, which needs Python.
4. LLVM writes the module as an object file, position-independent. It does not optimise again: the arithmetic is that of step 1.

The index of what was written goes to ``together.json`` and ``rest.json``: for each entry its result, whether it releases the
interpreter's lock, and the symbol and the signature of each of its compilations.
"""

import gc
import hashlib
import importlib
import json
import sys
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from numba.core.config import CPU_FEATURES, CPU_NAME  # pyright: ignore[reportAttributeAccessIssue] - made when it is loaded

from ulna.engine.cache import KernelCache, compiler_hash
from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES
from ulna.engine.entries import Entries
from ulna.engine.plain import plain_module, result_code
from ulna.engine.signatures import Signature, text_of_signature
from ulna.engine.sources import sources_hash, text_of


def write_objects(entries: Entries, folder: Path, part: str) -> None:
    """Write an object file for each signature of each entry of a part, and the index. A file that is there already is kept."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [name for name in sorted(entries.names()) if _part_of(entries, name) == part]
    index = [_write_entry(entries, name, folder) for name in names]
    (folder / f"{part}.json").write_text(json.dumps(index, indent=1))


class _Saved(KernelCache):
    """Saves machine code for tests of what Numba compiles, and loads none: what is loaded has no module any more."""

    def load_overload(self, sig, target_context):  # noqa: ARG002 - Numba's signature
        """None, so that it is compiled."""
        return


def _part_of(entries: Entries, name: str) -> str:
    return "together" if name.partition(".")[0] in entries.compiled_together else "rest"


def _write_entry(entries: Entries, name: str, folder: Path) -> dict[str, Any]:
    marked = entries.marked(name)
    marked._cache = _Saved(marked.py_func)  # noqa: SLF001 - as engine.compiler sets it
    calls, overloads, results = ENTRIES[marked], [], set()
    hashed = f"{sources_hash(marked.py_func.__code__.co_filename)}-{_own_hash()}-{compiler_hash()}"
    for k, signature in enumerate(calls.signatures):
        symbol = f"ulna_{name.replace('.', '_')}_{k}"
        file = folder / f"{symbol}-{hashed}.o"
        result = folder / f"{symbol}-{hashed}.result"
        if not (file.exists() and result.exists()):
            file.write_bytes(_object_code(marked, signature, symbol))
            result.write_text(result_code(_compiled(marked, signature)))
        results.add(result.read_text())
        overloads.append({"symbol": symbol, "signature": text_of_signature(signature), "object": file.name})
    (code,) = results
    return {"name": name, "result": code, "releases_lock": not calls.low_latency, "overloads": overloads}


def _own_hash() -> str:
    """Of what makes an object file of a compiled entry, for which CPU."""
    own = text_of(__file__) + text_of(str(Path(__file__).with_name("plain.py"))) + str(CPU_NAME).encode()
    return hashlib.sha256(own).hexdigest()[:16]


def _compiled(marked: Any, signature: Signature) -> Any:
    types = numba_types(signature)
    marked.compile(types)
    return marked.overloads[types]


def _object_code(marked: Any, signature: Signature, symbol: str) -> bytes:
    compiled = _compiled(marked, signature)
    module = compiled.library._final_module.clone()  # noqa: SLF001 - what Numba gives to LLVM
    module.link_in(llvm.parse_assembly(str(plain_module(compiled, symbol, module.triple))))
    for function in module.functions:
        if not function.is_declaration and function.name != symbol:
            function.linkage = llvm.Linkage.internal
    for variable in module.global_variables:
        if not variable.is_declaration:
            variable.linkage = llvm.Linkage.internal
    _remove_unused(module)
    target = llvm.Target.from_triple(module.triple)
    machine = target.create_target_machine(
        cpu=CPU_NAME or "", features=CPU_FEATURES or "", opt=3, reloc="pic", codemodel="default"
    )
    return machine.emit_object(module)


def _remove_unused(module: llvm.ModuleRef) -> None:
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    machine = llvm.Target.from_triple(module.triple).create_target_machine()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))


def _main() -> None:
    place, folder, part = sys.argv[1:]
    module, _, name = place.partition(":")
    gc.set_threshold(50_000)  # a compilation makes millions of objects, nearly all of them kept
    write_objects(getattr(importlib.import_module(module), name), Path(folder), part)


if __name__ == "__main__":
    _main()
