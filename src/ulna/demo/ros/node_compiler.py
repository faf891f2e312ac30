"""Compiles a node's kernels in another thread, so that Ctrl-C ends the node meanwhile."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ulna.viewer.compiler import Compiler

_CTRL_C = 130


@contextmanager
def node_compiler() -> Iterator[Compiler]:
    """A context with a compiler. It is the outermost one of a program, since it may end the process.

    If the block has ended, or was interrupted, while something is being compiled, the process ends at once. A normal exit would
    wait for that, up to half a minute.
    """
    from ulna.viewer.compiler import Compiler  # noqa: PLC0415 -- it imports Numba, which the help of a command does not need

    compiler, status = Compiler(lambda: None), None
    try:
        yield compiler
        status = 0
    except (KeyboardInterrupt, SystemExit):
        status = _CTRL_C
        raise
    finally:
        compiler.stop(0.0)
        if status is not None and not compiler.ended:
            sys.stdout.flush()
            os._exit(status)
