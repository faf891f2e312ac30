"""Translates what only compiled code calls, leaves its optimisation to its callers, and aligns stacks.

Numba optimises every function that it compiles, with a copy of all that this calls, and makes machine code of it. Most of ours
are then copied into their callers, and optimised there once more, at each level. Here each is translated, and made short by
itself. An entry, or a shared routine, takes all that it calls, directly or through others, each once; LLVM optimises the whole
from the bottom up.

A kernel needs more vectors than there are registers, so some wait on the stack. A function finds the stack aligned to 16 bytes,
and LLVM aligns what waits there no further. Then a vector of 64 bytes lies across two cache lines, or not, as the callers' frames
happen to be: a call took up to a tenth longer in one process than in the next.
"""

from typing import Any

from ulna.engine.lanes import WIDTH
from ulna.engine.numba_private import JITCodeLibrary

_VECTOR_BYTES = 8 * WIDTH


class AlignedStackLibrary(JITCodeLibrary):
    """A library whose functions align their part of the stack."""

    def add_ir_module(self, ir_module: Any) -> None:
        """Add a module that Numba has written, with the alignment asked for."""
        for function in ir_module.functions:
            if not function.is_declaration:
                function.attributes.alignstack = _VECTOR_BYTES
                # llvmlite writes the alignment only where this set has a member. This one adds unwind tables and no instruction.
                function.attributes.add("uwtable")
        super().add_ir_module(ir_module)


class IRLibrary(AlignedStackLibrary):
    """A library that has only LLVM's intermediate representation of its own function, and the libraries of what that calls."""

    def finalize(self) -> None:
        """Keep it as it is."""
        self._raise_if_finalized()
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)  # noqa: SLF001 - Numba's own name for what a caller inherits
        self._finalize_dynamic_globals()
        self._finalized = True

    def own_module(self) -> Any:
        """A module to be linked into others, of its own function alone."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """The same with all that it calls, for a library of Numba's own."""
        module = self.own_module().clone()
        for library in _with_callees(self._linking_libraries):
            module.link_in(_Own(library)._get_module_for_linking(), preserve=True)  # noqa: SLF001 - as below
        return module

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


class WholeLibrary(AlignedStackLibrary):
    """A library of machine code: of a function and of all that it calls, optimised at once."""

    def finalize(self) -> None:
        """Take what is called, optimise, and make machine code."""
        self._linking_libraries = list(map(_Own, _with_callees(self._linking_libraries)))
        super().finalize()


class _Own:
    """Of a library what Numba links: without what it calls, if that is linked beside it."""

    def __init__(self, library: Any) -> None:
        self._library, self._reload_init = library, library._reload_init  # noqa: SLF001 - Numba's own names

    def _get_module_for_linking(self) -> Any:
        return self._library.own_module() if isinstance(self._library, IRLibrary) else self._library._get_module_for_linking()  # noqa: SLF001


def _with_callees(libraries: list[Any]) -> list[Any]:
    """Some libraries, and those of what they call, each once: callers first, for LLVM links only what is named already."""
    ended: dict[Any, None] = {}

    def visit(library: Any) -> None:
        if library not in ended:
            for callee in library._linking_libraries if isinstance(library, IRLibrary) else ():  # noqa: SLF001 - as above
                visit(callee)
            ended[library] = None

    for library in libraries:
        visit(library)
    return list(ended)[::-1]
