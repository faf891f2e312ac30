"""What Python calls: each entry owns its workspaces and runs kernels over a batch, eight problems at a time.

Callers take an entry by name and import none of the modules here, which load the compiler: ``entry("forward.forward_batch")``.
"""

from functools import cache

from ulna.engine.entries import Entries

# Each of these compiles the distance or the overlap of two bodies in lanes, which takes longest.
DRIVERS = Entries(__name__, compiled_together=frozenset({"continuous", "nearest", "overlap", "planning"}))
entry = cache(DRIVERS.find)
"""An entry by its module and function; looked up once, then found in some 30 ns."""
