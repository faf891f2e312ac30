"""The batch kernels do their arithmetic on vectors of eight doubles: the LLVM code says so.

An entry that was loaded from the disk cache has machine code but no LLVM, so each is compiled afresh here.
"""

import re

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

import kernel_modes
import kernel_probes
from matrix import matrix
from ulna.collision.entries.overlap import overlap_batch
from ulna.engine import decorators as compiling
from ulna.ik.entries.multi_start import Jobs, search_jobs
from ulna.kernels.chain.closed_form import closed_form
from ulna.kernels.chain.closed_form_layout import N_BRANCHES, N_KNOWN, N_ROWS
from ulna.kernels.collision.collision_layout import NO_NODE
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.ik.search_records import SearchResult, SearchSettings
from ulna.kernels.layout import BODY_WIDTH, BOX, HULL
from ulna.kinematics.entries.forward import forward_batch, forward_one, frames_batch
from ulna.kinematics.entries.jacobian import jacobian_batch

pytestmark = pytest.mark.compiler

N, DOF, LINKS = 8, 7, 10
CHAIN, FRAMES, BOXES = np.zeros((8, 17)), np.zeros((LINKS, 14)), np.zeros((12, BODY_WIDTH))
NO_TOUCH = np.zeros((12, 1), dtype=np.bool_)
Q, BOUNDS, SETTINGS = np.zeros((N, DOF)), np.zeros((1, 4, DOF)), SearchSettings.records()
TARGETS, INFO, ORDER = np.zeros((N, 4, 4)), SearchResult.records(N), np.arange(N)
CLOSED_FORM, ROWS = np.zeros((N_ROWS, 3)), [np.zeros((n, 8)) for n in (12, 6, 12, 6 * N_BRANCHES, N_KNOWN * N_BRANCHES)]
PAIRS, NODES = np.zeros((3, 2), dtype=np.int64), np.zeros((0, 8))

NO_VERTICES, SCRATCH_ARRAYS = np.zeros((0, 3)), tuple(np.zeros(shape) for shape in SCRATCH)
TWO_BODIES = (BOX, NO_VERTICES, HULL, NO_VERTICES, SCRATCH_ARRAYS, np.zeros((32, 8)), np.zeros((11, 8)))

ENTRIES = {
    "forward_batch": (forward_batch, (CHAIN, Q, TARGETS)),
    "frames_batch": (frames_batch, (CHAIN, FRAMES, Q, np.zeros((N, LINKS, 4, 4)))),
    "jacobian_batch": (jacobian_batch, (CHAIN, 0, Q, np.zeros((N, 6, DOF)))),
    "overlap_batch": (
        overlap_batch,
        (Scene(CHAIN, BOXES, None, PAIRS, BOXES, None, NODES, NO_NODE, 0, 12, NO_TOUCH), Q, np.zeros(N, dtype=np.bool_)),
    ),
    "search_jobs": (search_jobs, (CHAIN, SETTINGS, Jobs(TARGETS, ORDER, Q, BOUNDS, Q[:1], Q[0]), Q, INFO)),
    "closed_form": (closed_form, (CLOSED_FORM, *ROWS[:2], 2, *ROWS[2:])),  # that of ``all_branches``, and shared
    "two_bodies": (kernel_modes.compiled(kernel_probes.two_bodies), TWO_BODIES),
}
# Targets come and results go lane by lane, a tree is searched and a depth worked out in plain numbers.
IN_PART = {"closed_form", "search_jobs", "overlap_batch", "two_bodies"}
ARITHMETIC = re.compile(r"= f(?:mul|add|sub)\b[^\n]*<8 x double>|@llvm\.fmuladd\.v8f64|@llvm\.fma\.v8f64")


def code_of(entry, arguments):
    fresh = njit(**compiling._FLAGS)(entry.py_func)
    signature = tuple(map(fresh.typeof_pyval, arguments))
    fresh.compile(signature)
    return fresh.inspect_llvm(signature)


@pytest.mark.parametrize("name", matrix(list(ENTRIES), ["forward_batch"]))
def test_a_batch_kernel_computes_on_eight_doubles_at_once(name):
    code = code_of(*ENTRIES[name])
    assert len(ARITHMETIC.findall(code)) > 100
    scalar = re.findall(r"= f(?:mul|add|sub)\b[^\n]* double ", code)
    assert name in IN_PART or len(scalar) < 100


def test_a_kernel_of_one_configuration_does_not():
    code = code_of(forward_one, (CHAIN, DOF, Q[0], TARGETS[0]))
    assert not ARITHMETIC.search(code)


def allocate(n):
    return np.empty(n)


def test_a_kernel_that_allocates_is_not_compiled():
    for decorator in (compiling.kernel, compiling.exact_kernel, compiling.routine):
        with pytest.raises(TypingError, match="Only accept returning of array passed into the function"):
            decorator(allocate)(3)
