"""What Python calls: each entry owns its workspaces and runs kernels over a batch, eight problems at a time.

``from ulna.drivers import forward`` loads neither the kernels nor the compiler. The first use of ``forward.forward_batch`` does,
where no machine code was compiled ahead (``engine.entries``).
"""

from typing import TYPE_CHECKING

from ulna.engine.entries import Entries

# Each of these compiles the distance or the overlap of two bodies in lanes, which takes longest.
DRIVERS = Entries(__name__, compiled_together=frozenset({"continuous", "nearest", "overlap", "planning", "servo"}))
if not TYPE_CHECKING:  # tools find the modules beside this file
    __getattr__ = DRIVERS.module
