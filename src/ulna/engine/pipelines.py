"""Chooses the passes of Numba that a function of ours needs, and where its code goes.

Numba runs some thirty passes over a function. Half of them are for what kernels and drivers do not have: closures and
comprehensions, ``with``, ``literal_unroll``, expressions of whole arrays. They took a tenth of the time of compiling. Numba also
measures each pass and reports it to listeners, which took almost as long.
"""

from types import CodeType
from typing import Any, ClassVar

from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager

from ulna.engine.typing_context import with_memory
from ulna.engine.without_code import IRLibrary, WholeLibrary

_PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.RewriteSemanticConstants,
    untyped_passes.DeadBranchPrune,  # what is not reached where an argument is None
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    untyped_passes.DeadBranchPrune,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.IRLegalization,  # it marks the last use of each variable: only where references are counted
    typed_passes.AnnotateTypes,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)


class _Passes(PassManager):
    """Runs the passes one after the other: it measures nothing, reports nothing and prints nothing."""

    def _runPass(self, index: int, pss: Any, internal_state: Any) -> None:  # noqa: ARG002, N802  # pyright: ignore - it is Numba's own
        pss.analysis = self._analysis
        pss.run_initialization(internal_state)
        pss.run_pass(internal_state)
        pss.run_finalizer(internal_state)


class _LibraryCompiler(Compiler):
    """Numba's compiler, which writes into a library of ours where it is not given one, and remembers the types of operators."""

    library: ClassVar[type[JITCodeLibrary]]

    def __init__(self, typing_context: Any, target_context: Any, library: Any, *arguments: Any) -> None:
        if library is None:
            library = self.library(target_context.codegen(), "ulna")
            library.enable_object_caching()
        super().__init__(typing_context, target_context, library, *arguments)
        self.state.typingctx = self.state.targetctx.typing_context = with_memory(typing_context)  # a copy of Numba's targetctx

    def define_pipelines(self) -> list[PassManager]:
        """The passes; all of Numba's for a function with a closure or a comprehension, which a kernel of a user may have."""
        if any(isinstance(constant, CodeType) for constant in self.state.func_id.code.co_consts):
            return super().define_pipelines()
        passes, counts_references = _Passes("ulna"), self.state.flags.nrt
        for each in _PASSES:
            if counts_references or each is not typed_passes.IRLegalization:
                passes.add_pass(each, each.__name__)
        passes.finalize()
        return [passes]


class IRCompiler(_LibraryCompiler):
    """The compiler of what only compiled code calls."""

    library = IRLibrary


class WholeCompiler(_LibraryCompiler):
    """The compiler of what has machine code."""

    library = WholeLibrary
