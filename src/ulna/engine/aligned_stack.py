"""Lets compiled code keep vectors on the stack at multiples of their size. Used by ``without_code``.

A kernel needs more vectors than there are registers, so some wait on the stack. A function finds the stack aligned to 16 bytes,
and LLVM aligns what waits there no further. Then a vector of 64 bytes lies across two cache lines, or not, as the callers' frames
happen to be: a call took up to a tenth longer in one process than in the next.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary

from ulna.engine.width import WIDTH

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
