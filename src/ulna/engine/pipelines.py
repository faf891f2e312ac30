"""Chooses the passes of Numba that a function of ours needs, and the library that its code goes to.

Numba runs some thirty passes over a function. Half of them are for what kernels and drivers do not have: closures and
comprehensions, ``with``, ``literal_unroll``, expressions of whole arrays. They took a tenth of the time of compiling. Numba also
measures each pass and reports it to listeners, which took almost as long.

For every ``a * b`` Numba tries the templates of ``*`` one after the other, many of which are for arrays, strings or sets: when it
types the expression, and again when it lowers it. Our kernels have thousands of such expressions and few types of operands, so
here each is resolved once in a process.
"""

import operator
from collections.abc import Callable
from functools import cache
from types import BuiltinFunctionType, CodeType
from typing import Any, ClassVar

from ulna.engine.numba_private import (
    LAST_USES,
    MEMORY,
    PASSES,
    PASSES_IN_ORDER,
    Compiler,
    FunctionType,
    PassManager,
    have,
)
from ulna.engine.without_code import IRLibrary, WholeLibrary


class _Passes(PassManager):
    """Runs the passes one after the other: it measures nothing, reports nothing and prints nothing."""

    def _runPass(self, index: int, pss: Any, internal_state: Any) -> None:  # noqa: ARG002, N802  # pyright: ignore - it is Numba's own
        pss.analysis = self._analysis
        pss.run_initialization(internal_state)
        pss.run_pass(internal_state)
        pss.run_finalizer(internal_state)


class _TypingContext:
    """Numba's typing context, with a memory of what it resolved.

    Remembered is what depends on the types alone. A function that Numba writes in Python, such as ``max``, depends on the flags
    of its caller too: it is compiled with them.
    """

    def __init__(self, context: Any) -> None:
        self._context, self._resolved, self._operators = context, {}, {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_value_type(self, value: Any) -> Any:
        """The type of a value, as Numba finds it. That of an operator resolves its calls with this memory."""
        if type(value) is not BuiltinFunctionType or value.__module__ != "_operator":
            return self._context.resolve_value_type(value)
        if value not in self._operators:
            self._operators[value] = _Operator.made(self._context.resolve_value_type(value), self)
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
    """The type of an operator, as Numba has it but for the memory."""

    function: Any
    context: _TypingContext

    @classmethod
    def made(cls, function: Any, context: _TypingContext) -> Any:
        """From Numba's own. It is made past the types' ``__call__``, which makes equal types once."""
        of: Any = object.__new__(cls)
        of.__dict__.update(function.__dict__, function=function, context=context)
        return of

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """The signature of a call."""
        if kws:
            return self.function.get_call_type(context, args, kws)
        return self.context.remembered(self.function, args, lambda: self.function.get_call_type(context, args, kws))


_with_memory = cache(_TypingContext)


class _LibraryCompiler(Compiler):
    """Numba's compiler, which writes into a library of ours where it is not given one, and remembers the types of operators."""

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
        """The passes; all of Numba's for a function with a closure or a comprehension, which a kernel of a user may have."""
        if not have(PASSES) or any(isinstance(constant, CodeType) for constant in self.state.func_id.code.co_consts):
            return super().define_pipelines()
        passes, counts_references = _Passes("ulna"), self.state.flags.nrt
        for each in PASSES_IN_ORDER:
            if counts_references or each is not LAST_USES:
                passes.add_pass(each, each.__name__)
        passes.finalize()
        return [passes]


class IRCompiler(_LibraryCompiler):
    """The compiler of what only compiled code calls."""

    library = IRLibrary


class WholeCompiler(_LibraryCompiler):
    """The compiler of what has machine code."""

    library = WholeLibrary
