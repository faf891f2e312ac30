"""Selects Numba's passes for our functions, makes their libraries with or without machine code, and aligns stacks.

Numba runs about thirty passes over a function. Half of them handle features that kernels and entries do not have: closures and
comprehensions, ``with``, ``literal_unroll``, expressions of whole arrays. They took a tenth of the time of compiling. Numba also
measures each pass and reports it to listeners, which took almost as long.

For every ``a * b`` Numba tries the templates of ``*`` in turn, many of which are for arrays, strings or sets. It does so when it
types the expression, and again when it lowers it. Our kernels have thousands of such expressions and few types of operands. So
here each is resolved once per process.

Numba also optimizes every function that it compiles, with a copy of all its callees, and generates machine code for it. Most of
ours are then inlined into their callers, and optimized there once more, at each level. Here each is only translated and
simplified by itself. An entry, or a shared routine, takes all its callees, direct and indirect, each once; LLVM optimizes the
whole from the bottom up.

A kernel needs more vectors than there are registers, so some are spilled to the stack. A function finds the stack aligned to 16
bytes, and LLVM aligns spilled vectors no further. Then a vector of 64 bytes may span two cache lines, depending on the callers'
frames: a call took up to a tenth longer in one process than in the next.
"""

import operator
from collections.abc import Callable
from functools import cache
from types import BuiltinFunctionType, CodeType
from typing import Any, ClassVar

from ulna.engine.lanes import WIDTH
from ulna.engine.numba_private import (
    LAST_USES,
    MEMORY,
    PASSES,
    PASSES_IN_ORDER,
    Compiler,
    FunctionType,
    JITCodeLibrary,
    PassManager,
    have,
)

_VECTOR_BYTES = 8 * WIDTH


class _Passes(PassManager):
    """Runs the passes in turn, without measurements, reports and output."""

    def _runPass(self, index: int, pss: Any, internal_state: Any) -> None:  # noqa: ARG002, N802  # pyright: ignore - Numba's own
        pss.analysis = self._analysis
        pss.run_initialization(internal_state)
        pss.run_pass(internal_state)
        pss.run_finalizer(internal_state)


class _TypingContext:
    """Numba's typing context with a memory of resolved types.

    It remembers only what depends on the types alone. A function that Numba writes in Python, such as ``max``, also depends on
    the flags of its caller: it is compiled with them.
    """

    def __init__(self, context: Any) -> None:
        self._context, self._resolved, self._operators = context, {}, {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_value_type(self, value: Any) -> Any:
        """The type of a value, as Numba finds it. The type of an operator resolves its calls with this memory."""
        if type(value) is not BuiltinFunctionType or value.__module__ != "_operator":
            return self._context.resolve_value_type(value)
        if value not in self._operators:
            self._operators[value] = _Operator.from_numba(self._context.resolve_value_type(value), self)
        return self._operators[value]

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """The signature of a call, as Numba finds it."""
        function = self._context.resolve_value_type(func) if func is operator.getitem else func
        if kws or not isinstance(function, FunctionType):
            return self._context.resolve_function_type(func, args, kws)
        return self.remembered(function, args, lambda: self._context.resolve_function_type(func, args, kws))

    def remembered(self, function: Any, args: Any, resolve: Callable[[], Any]) -> Any:
        """The signature of a call, resolved unless it is known."""
        key = function, tuple(args)
        signature = self._resolved.get(key)
        if signature is None:
            signature = resolve()
            if signature is not None and function.get_impl_key(signature) is function.typing_key:  # not compiled for this call
                self._resolved[key] = signature
        return signature


class _Operator(FunctionType):
    """The type of an operator, as in Numba, with the memory."""

    function: Any
    context: _TypingContext

    @classmethod
    def from_numba(cls, function: Any, context: _TypingContext) -> Any:
        """Convert Numba's own type, bypassing the types' ``__call__``, which would unify equal types."""
        of: Any = object.__new__(cls)
        of.__dict__.update(function.__dict__, function=function, context=context)
        return of

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """The signature of a call."""
        if kws:
            return self.function.get_call_type(context, args, kws)
        return self.context.remembered(self.function, args, lambda: self.function.get_call_type(context, args, kws))


class AlignedStackLibrary(JITCodeLibrary):
    """A library whose functions align their part of the stack."""

    def add_ir_module(self, ir_module: Any) -> None:
        """Add a module that Numba has written, with the required alignment."""
        for function in ir_module.functions:
            if not function.is_declaration:
                function.attributes.alignstack = _VECTOR_BYTES
                # llvmlite writes the alignment only if this set has a member. This one adds unwind tables and no instruction.
                function.attributes.add("uwtable")
        super().add_ir_module(ir_module)


class IRLibrary(AlignedStackLibrary):
    """A library with LLVM's intermediate representation of its own function only, and its callees' libraries."""

    def finalize(self) -> None:
        """Finish without optimization and machine code."""
        self._raise_if_finalized()
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)  # noqa: SLF001 - Numba's own name for what a caller inherits
        self._finalize_dynamic_globals()
        self._finalized = True

    def own_module(self) -> Any:
        """A module to be linked into others, of its own function alone."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """A module of its own function and all callees, to be linked into a library of Numba's own."""
        module = self.own_module().clone()
        for library in _with_callees(self._linking_libraries):
            module.link_in(_LibraryView(library)._get_module_for_linking(), preserve=True)  # noqa: SLF001 - as below
        return module

    def get_pointer_to_function(self, name: str) -> int:  # noqa: ARG002 - Numba's signature
        """Return 0: there is no machine code."""
        return 0

    @property
    def codegen(self) -> Any:
        """A stub that ignores the environment of the function, which only calls from Python need."""
        return _NoEnvironments


class _NoEnvironments:
    @staticmethod
    def set_env(env_name: str, env: Any) -> None:
        pass


class WholeLibrary(AlignedStackLibrary):
    """A library of machine code: of a function and all callees, optimized together."""

    def finalize(self) -> None:
        """Link all callees, optimize, and generate machine code."""
        self._linking_libraries = list(map(_LibraryView, _with_callees(self._linking_libraries)))
        super().finalize()


class _LibraryView:
    """The part of a library that Numba links: without callees, if those are linked separately."""

    def __init__(self, library: Any) -> None:
        self._library, self._reload_init = library, library._reload_init  # noqa: SLF001 - Numba's own names

    def _get_module_for_linking(self) -> Any:
        return self._library.own_module() if isinstance(self._library, IRLibrary) else self._library._get_module_for_linking()  # noqa: SLF001


def _with_callees(libraries: list[Any]) -> list[Any]:
    """Libraries and their callees, each once, callers first, since LLVM links only what is already named."""
    ended: dict[Any, None] = {}

    def visit(library: Any) -> None:
        if library not in ended:
            for callee in library._linking_libraries if isinstance(library, IRLibrary) else ():  # noqa: SLF001 - as above
                visit(callee)
            ended[library] = None

    for library in libraries:
        visit(library)
    return list(ended)[::-1]


_with_memory = cache(_TypingContext)


class _LibraryCompiler(Compiler):
    """Numba's compiler, which writes into our libraries by default, and remembers the types of operators."""

    library: ClassVar[Any]

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *arguments: Any) -> None:
        if library is None:
            library = self.library(target_context.codegen(), "ulna")
            library.enable_object_caching()
        super().__init__(typing_context, target_context, library, *arguments)
        if have(MEMORY):
            self.state.typingctx = self.state.targetctx.typing_context = _with_memory(
                typing_context
            )  # a copy of Numba's targetctx

    def define_pipelines(self) -> list[Any]:
        """The passes; all of Numba's for a function with a closure or a comprehension, as in a user's kernel."""
        if not have(PASSES) or any(isinstance(constant, CodeType) for constant in self.state.func_id.code.co_consts):
            return super().define_pipelines()
        passes, counts_references = _Passes("ulna"), self.state.flags.nrt
        for each in PASSES_IN_ORDER:
            if counts_references or each is not LAST_USES:
                passes.add_pass(each, each.__name__)
        passes.finalize()
        return [passes]


class IRCompiler(_LibraryCompiler):
    """The compiler of functions that only compiled code calls."""

    library = IRLibrary


class WholeCompiler(_LibraryCompiler):
    """The compiler of functions with machine code."""

    library = WholeLibrary
