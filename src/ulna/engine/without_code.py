"""Compiles what only compiled code calls, and makes no machine code of it. Used by ``compiler``.

Numba makes machine code of every function that it compiles. Most of ours are then copied into their callers, and LLVM makes
machine code of the whole once more: that of an entry is all that is ever run.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class IRLibrary(JITCodeLibrary):
    """A library that has only LLVM's intermediate representation, for its callers."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:  # noqa: ARG002 - Numba's signature
        """0: there is no machine code."""
        return 0

    @property
    def codegen(self) -> Any:
        """What Numba tells where the environment of the function is, which only its call from Python needs."""
        return _NoEnvironments


class _NoEnvironments:
    @staticmethod
    def set_env(env_name: str, env: Any) -> None:
        pass


class IRCompiler(Compiler):
    """Numba's compiler, which writes into such a library."""

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *arguments: Any) -> None:
        ours = IRLibrary(target_context.codegen(), "without code") if library is None else library
        super().__init__(typing_context, target_context, ours, *arguments)
