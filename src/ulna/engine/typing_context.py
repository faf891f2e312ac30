"""Remembers which types operators give, while functions of ours are typed and lowered.

For every ``a * b`` Numba tries the templates of ``*`` one after the other, many of which are for arrays, strings or sets: when it
types the expression, and again when it lowers it. Our kernels have thousands of such expressions and few types of operands, so
here each is resolved once in a process.
"""

import operator
from collections.abc import Callable
from functools import cache
from types import BuiltinFunctionType
from typing import Any

from numba import types


class TypingContext:
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
        if kws or not isinstance(function, types.Function):
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


class _Operator(types.Function):
    """The type of an operator, as Numba has it but for the memory."""

    function: Any
    context: TypingContext

    @classmethod
    def made(cls, function: Any, context: TypingContext) -> Any:
        """From Numba's own. It is made past the types' ``__call__``, which makes equal types once."""
        of: Any = object.__new__(cls)
        of.__dict__.update(function.__dict__, function=function, context=context)
        return of

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """The signature of a call."""
        if kws:
            return self.function.get_call_type(context, args, kws)
        return self.context.remembered(self.function, args, lambda: self.function.get_call_type(context, args, kws))


with_memory = cache(TypingContext)
"""The one with a memory of a context of Numba's."""
