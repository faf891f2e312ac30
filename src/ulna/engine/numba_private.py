"""Lists the private names of Numba that the engine uses, with their purposes, and finds missing ones.

Numba guarantees ``njit`` with its documented options, and ``numba.extending``. Everything else may change in any version. It is
imported only here, in groups: if a name of a group is missing, the engine does not use the whole group.

========== ===========================================================================================================
group      without it
========== ===========================================================================================================
PASSES     Numba runs all of its passes: compiling takes longer.
MEMORY     Numba resolves the types of each operator again: compiling takes longer.
CODE       Numba's own pipeline, with the documented options alone: compiling takes several times as long. Results may
           differ in their last bits, since each kernel is optimized alone before it is inlined.
CACHE      machine code is not stored on disk: every process compiles.
PERMISSION a thread that may not compile now (``compiling_if``) waits until an entry is compiled.
ROWS       rows of lanes begin at any multiple of 16 bytes: a call takes longer.
AHEAD      no wheel is built, and no compiled entry is called in C.
========== ===========================================================================================================

A name may exist and have another meaning. So with an untested version of Numba, ``compiler`` compiles a small entry first. If
that fails, it turns ``CODE``, ``PASSES`` and ``MEMORY`` off, and then ``CACHE``.
"""

import warnings
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

import numba
from numba import njit

from ulna.errors import CompilerWarning

TESTED = "0.63.0", "0.68.1"
"""The lowest and the highest version of Numba with which all tests were run."""
PASSES, MEMORY, CODE, CACHE, PERMISSION, ROWS, AHEAD = "passes", "memory", "code", "cache", "permission", "rows", "ahead"
_LOST = {
    PASSES: "entries take longer to compile",
    MEMORY: "entries take longer to compile",
    CODE: "entries take several times as long to compile, and results may differ in their last bits",
    CACHE: "machine code is not kept on disk",
    PERMISSION: "a page may wait while an entry is compiled",
    ROWS: "batches take longer",
    AHEAD: "machine code cannot be written for a wheel",
}

LISTED: dict[str, str] = {}
"""The purpose of each name."""
_missing: dict[str, list[str]] = {}
"""By group: the names that are missing, or why it is turned off."""


def have(*groups: str) -> bool:
    """Whether Numba has every name of some groups."""
    return not any(group in _missing for group in groups)


def missing_of(*groups: str) -> list[str]:
    """The missing names of some groups, or the reasons why these are turned off."""
    return sorted({name for group in groups for name in _missing.get(group, ())})


def turned_off() -> tuple[str, ...]:
    """The groups that are not used, in alphabetical order."""
    return tuple(sorted(_missing))


def turn_off(groups: Iterable[str], why: str) -> None:
    """Disable some groups."""
    for group in groups:
        _missing.setdefault(group, []).append(why)


def is_tested() -> bool:
    """Whether Numba's version is between the lowest and the highest tested."""
    low, high = map(_numbers, TESTED)
    return low <= _numbers(numba.__version__) <= high


def warn_of_missing() -> None:
    """Warn once of the missing names and their consequences.

    Warns:
        CompilerWarning: A group is not used.
    """
    if not _missing:
        return
    names = missing_of(*_missing)
    lost = "; ".join(dict.fromkeys(_LOST[group] for group in _LOST if group in _missing))
    message = (
        f"Numba {numba.__version__} differs from the versions that were tested, {TESTED[0]} to {TESTED[1]}: {', '.join(names)}. "
        f'Consequence: {lost}. pip install "numba>={TESTED[0]},<={TESTED[1]}" restores it'
    )
    warnings.warn(CompilerWarning(message, tuple(names)), stacklevel=2)


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int("".join(filter(str.isdigit, part)) or 0) for part in version.split(".")[:3])


class Missing:
    """Placeholder for a missing class of Numba's; classes derived from it are not used."""


def _private(groups: str | tuple[str, ...], path: str, purpose: str) -> Any:
    """The object with a name in a module; if it is missing, record that and return ``Missing``."""
    LISTED[path] = purpose
    module, _, name = path.rpartition(".")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError):
        _note(groups, path)
        return Missing


def _attribute(groups: str | tuple[str, ...], owner: Any, name: str, purpose: str) -> None:
    """Record an attribute that a class, or an object and its class, lacks; does nothing for a missing class."""
    if owner is Missing:
        return
    kind = owner if isinstance(owner, type) else type(owner)
    path = f"{kind.__module__}.{kind.__qualname__}.{name}"
    LISTED[path] = purpose
    if not (hasattr(kind, name) or hasattr(owner, name)):  # the class first: a property is computed once, and kept
        _note(groups, path)


def _note(groups: str | tuple[str, ...], path: str) -> None:
    turn_off((groups,) if isinstance(groups, str) else groups, path)


def _sample(make: Callable[[], Any], *needed: Any) -> Any:
    """An object whose attributes are checked; ``Missing`` if it cannot be made."""
    try:
        return Missing if Missing in needed else make()
    except Exception:  # noqa: BLE001 - another constructor: then the small entry fails, and gives the reason
        return Missing


# ---- samples ----

JITCodeLibrary = _private(
    (CODE, AHEAD), "numba.core.codegen.JITCodeLibrary", "holds a function's LLVM module, and links what it calls into it"
)
Compiler = _private((CODE, PASSES, MEMORY), "numba.core.compiler.Compiler", "njit's pipeline_class: gives a function its library")
PassManager = _private(PASSES, "numba.core.compiler_machinery.PassManager", "runs passes one after the other")
FunctionType = _private(MEMORY, "numba.core.types.Function", "the type of an operator")
CompileResultCacheImpl = _private(CACHE, "numba.core.caching.CompileResultCacheImpl", "what of a compilation is written")
FunctionCache = _private(CACHE, "numba.core.caching.FunctionCache", "the cache of one function, which a dispatcher calls")
IndexDataCacheFile = _private(CACHE, "numba.core.caching.IndexDataCacheFile", "reads and writes its files")
CacheLocator = _private(CACHE, "numba.core.caching._CacheLocator", "names its files")
NullCache = _private(AHEAD, "numba.core.caching.NullCache", "no cache: what is loaded from disk has no module")
populate_array = _private(ROWS, "numba.np.arrayobj.populate_array", "fills in an array")
NRTContext = _private(ROWS, "numba.core.runtime.context.NRTContext", "writes calls of Numba's memory")

_cpu = _private((CODE, ROWS, AHEAD), "numba.core.registry.cpu_target", "the target whose code generator makes libraries")
_options = _private(CODE, "numba.core.cpu.CPUTargetOptions", "the options of njit")
_context = _sample(lambda: _cpu.target_context, _cpu)
_typing = _sample(lambda: _cpu.typing_context, _cpu)
_library = _sample(lambda: JITCodeLibrary(_context.codegen(), "ulna"), JITCodeLibrary, _context)
_operator = _sample(lambda: FunctionType(type("_Template", (), {"key": "ulna"})), FunctionType)
_manager = _sample(lambda: PassManager("ulna"), PassManager)
_files = _sample(lambda: IndexDataCacheFile("", "ulna", None), IndexDataCacheFile)
_dispatcher = njit(lambda: None)

# ---- the passes, in execution order ----

_UNTYPED, _TYPED = "numba.core.untyped_passes", "numba.core.typed_passes"
_PRUNE = _private(PASSES, f"{_UNTYPED}.DeadBranchPrune", "removes what is not reached where an argument is None")
LAST_USES = _private(PASSES, f"{_TYPED}.IRLegalization", "marks the last use of each variable")
PASSES_IN_ORDER = (
    _private(PASSES, f"{_UNTYPED}.TranslateByteCode", "Python's byte code to Numba's IR"),
    _private(PASSES, f"{_UNTYPED}.FixupArgs", "arguments that are left out"),
    _private(PASSES, f"{_UNTYPED}.IRProcessing", "checks the IR"),
    _private(PASSES, f"{_UNTYPED}.RewriteSemanticConstants", "the length of a tuple, and the like"),
    _PRUNE,
    _private(PASSES, f"{_UNTYPED}.GenericRewrites", "constants as indices, and the like"),
    _private(PASSES, f"{_UNTYPED}.ReconstructSSA", "one assignment to each variable"),
    _PRUNE,
    _private(PASSES, f"{_TYPED}.NopythonTypeInference", "types"),
    _private(PASSES, f"{_TYPED}.PreLowerStripPhis", "phi nodes to assignments"),
    LAST_USES,
    _private(PASSES, f"{_TYPED}.AnnotateTypes", "types for messages"),
    _private(PASSES, f"{_TYPED}.NativeLowering", "LLVM's IR"),
    _private(PASSES, f"{_TYPED}.NoPythonBackend", "the compiled function"),
)

# ---- attributes ----

_ATTRIBUTES: tuple[tuple[str | tuple[str, ...], Any, str, str], ...] = (
    (CODE, _library, "add_ir_module", "takes a module that Numba has written: the stack is aligned there"),
    (CODE, _library, "finalize", "links, optimizes and makes machine code: not for what is only copied"),
    (CODE, _library, "enable_object_caching", "lets machine code be kept"),
    (CODE, _library, "_raise_if_finalized", "part of finalize"),
    (CODE, _library, "_finalize_dynamic_globals", "part of finalize"),
    (CODE, _library, "_finalized", "part of finalize"),
    (CODE, _library, "_linking_libraries", "what a function calls"),
    (CODE, _library, "_reload_init", "called before code is loaded from disk: it loads a shared routine"),
    (CODE, _library, "_get_module_for_linking", "what a caller copies"),
    ((CODE, AHEAD), _library, "get_pointer_to_function", "the address of machine code"),
    (CODE, _dispatcher, "get_call_template", "types a call: for the twin that is only copied, once for all whole numbers"),
    (CODE, _dispatcher, "get_overload", "what a caller calls: the twin, or the symbol of a shared routine"),
    (CODE, _context, "insert_func_defn", "how a shared routine is called"),
    (CODE, _context, "active_code_library", "the library of the function that calls it"),
    ((CODE, AHEAD), _context, "call_conv", "how Numba passes arguments and errors"),
    (CODE, _options, "_nrt", "leaves out the counting of references, which kernels do not need"),
    (CODE, _options, "no_cpython_wrapper", "leaves out the function for Python, which kernels do not need"),
    (CODE, _options, "no_cfunc_wrapper", "leaves out the function for C, which nothing calls"),
    (PASSES, _manager, "_runPass", "runs one pass: here without measuring and reporting it"),
    (PASSES, _manager, "_analysis", "what passes leave to each other"),
    (MEMORY, _operator, "get_call_type", "the signature of a call"),
    (MEMORY, _operator, "get_impl_key", "whether a function is compiled for one call"),
    (MEMORY, _operator, "typing_key", "whether a function is compiled for one call"),
    (MEMORY, _typing, "resolve_value_type", "the type of a value"),
    (MEMORY, _typing, "resolve_function_type", "the signature of a call"),
    (CACHE, _dispatcher, "_cache", "the dispatcher's cache"),
    (CACHE, CompileResultCacheImpl, "_locator_classes", "what names the files"),
    (CACHE, CompileResultCacheImpl, "filename_base", "a file's name without its hash"),
    (CACHE, FunctionCache, "_impl_class", "what is written"),
    (CACHE, FunctionCache, "_index_key", "what the name of a file depends on"),
    (CACHE, FunctionCache, "load_overload", "called before a function is compiled"),
    (CACHE, FunctionCache, "save_overload", "called when it was"),
    (CACHE, _files, "_data_name_pattern", "the name of a file"),
    (CACHE, _files, "_dump", "a compilation as bytes"),
    (PERMISSION, _dispatcher, "_compile_for_args", "called where there is no machine code, before Numba takes its lock"),
    (ROWS, _context, "nrt", "Numba's memory"),
    (ROWS, NRTContext, "meminfo_alloc_aligned", "memory that begins at a multiple of 64 bytes"),
    (ROWS, NRTContext, "meminfo_data", "where it begins"),
    (AHEAD, _library, "_final_module", "the optimized module, before LLVM makes machine code"),
    (AHEAD, _context, "make_array", "an array as Numba passes it"),
)
for _row in _ATTRIBUTES:
    _attribute(*_row)
