"""Remembers which types operators give, while functions of ours are typed. Used by ``without_code``.

For every ``a * b`` Numba tries the templates of ``*`` one after the other, many of which are for arrays, strings or sets. Our
kernels have thousands of such expressions and few types of operands, so here each is resolved once in a process.
"""

import operator
from functools import cache
from typing import Any

from numba import types


class TypingContext:
    """Numba's typing context, with a memory of what it resolved.

    Remembered is what depends on the types alone. A function that Numba writes in Python, such as ``max``, depends on the flags
    of its caller too: it is compiled with them.
    """

    def __init__(self, context: Any) -> None:
        self._context, self._resolved = context, {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """The signature of a call, as Numba finds it."""
        function = self._context.resolve_value_type(func) if func is operator.getitem else func
        if kws or not isinstance(function, types.Function):
            return self._context.resolve_function_type(func, args, kws)
        key = function, tuple(args)
        signature = self._resolved.get(key)
        if signature is None:
            signature = self._context.resolve_function_type(func, args, kws)
            if signature is not None and function.get_impl_key(signature) is function.typing_key:  # not compiled for this call
                self._resolved[key] = signature
        return signature


with_memory = cache(TypingContext)
"""The one with a memory of a context of Numba's."""
