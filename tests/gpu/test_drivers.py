"""The drivers for a GPU compile to PTX and on to machine code, within a number of registers and of bytes spilled.

No GPU and no driver is needed: ``make test-cuda``. The ceilings are a tenth above what was measured when they were written: a
kernel that grows beyond them runs in fewer threads at once, or reads its variables back from memory.
"""

import re
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import from_dtype, types

from ulna.gpu import cloud_trees
from ulna.gpu.collision import distances_of, overlaps_of
from ulna.gpu.edges import edges_of
from ulna.gpu.forward import frames_of, jacobians_of, poses_of
from ulna.gpu.rows import converted
from ulna.gpu.scenes import ANY, BOXES, CLOSED
from ulna.gpu.search import choose, searches_of, turned_of
from ulna.gpu.single import in_single
from ulna.gpu.solutions import branches_of
from ulna.gpu.torques import derivatives_of, forward_of, gravity_of, inverse_of, masses_of
from ulna.kernels.collision.scene import Scene
from ulna.kernels.ik.search_records import SearchResult, SearchSettings

SIZES, FRAMES, BALLS = (7, 11, 12), 12, 6  # the Panda: joint positions, joints and bodies; frames; balls
N_DOF, JOINTS, _ = SIZES
A1, A2, A3, A4 = (types.Array(types.float64, n, "C") for n in (1, 2, 3, 4))
FLAG, NEXT, INDICES = types.Array(types.int32, 1, "C"), types.Array(types.int64, 1, "C"), types.Array(types.int64, 2, "C")
BOOLS, BOOLS_2 = (types.Array(types.boolean, n, "C") for n in (1, 2))
COLUMNS, BITS = types.Array(types.int64, 1, "C"), types.Array(types.int8, 1, "C")
SETTINGS, RESULTS = (types.Array(from_dtype(of.structure), 1, "C") for of in (SearchSettings, SearchResult))
COUNTS, BALL = types.Array(types.int32, 1, "C"), types.UniTuple(types.float64, 14)
JOBS = types.Tuple((NEXT, NEXT, *(types.int64,) * 4))
WHOLES = (types.int64,) * 3  # root, first and end
SCENE = types.NamedTuple((A2, A2, A2, INDICES, A2, A2, A2, *WHOLES, BOOLS_2), Scene)
EDGES = types.Tuple((A2, NEXT, NEXT, INDICES, INDICES, NEXT, A1, types.float64))
OF_EDGES = SCENE, EDGES, INDICES, types.UniTuple(types.float64, 2), A2
MARKS, OF_BRANCHES = types.Tuple((FLAG,)), types.Tuple((FLAG, BITS, BOOLS, BOOLS))
OF_FALL = A2, A2, *(types.float64,) * 3
OF_MOTIONS = *OF_FALL, types.Tuple((A2, A2))
OF_FREE = types.Tuple((FLAG, BOOLS, A1))


def of_rows(tables, out=A2, marks=MARKS, rows=A2):
    """The types of the arguments of a driver of ``staged.over_rows``."""
    return types.Tuple(tables), rows, out, marks


# The driver, its arguments' types, and the most registers and bytes spilled (stores).
DRIVERS = {
    "poses": (poses_of(N_DOF), of_rows((A2,)), 76, 0),
    "jacobians": (jacobians_of(N_DOF), of_rows((A2, types.int64)), 80, 0),
    "frames": (frames_of(N_DOF, JOINTS, FRAMES), of_rows((A2, A2)), 74, 0),
    "overlaps of boxes": (overlaps_of(*SIZES, BOXES, False), of_rows((SCENE,), BOOLS_2), 134, 0),
    "overlaps of any shapes": (overlaps_of(*SIZES, ANY, False), of_rows((SCENE,), BOOLS_2), 255, 88),
    "overlaps of many boxes": (overlaps_of(*SIZES, BOXES, True), of_rows((SCENE,), BOOLS_2), 182, 0),
    "overlaps of clouds": (overlaps_of(*SIZES, ANY, True), of_rows((SCENE,), BOOLS_2), 255, 158),
    "distances of boxes": (distances_of(*SIZES, BOXES, False), of_rows((SCENE,)), 255, 64),
    "distances of closed form": (distances_of(*SIZES, CLOSED, False), of_rows((SCENE,)), 255, 200),
    "distances of any shapes": (distances_of(*SIZES, ANY, False), of_rows((SCENE, A3, A3, A3)), 255, 420),
    "distances of clouds": (distances_of(*SIZES, CLOSED, True), of_rows((SCENE,)), 255, 44),
    "distances of clouds and any shapes": (distances_of(*SIZES, ANY, True), of_rows((SCENE, A3, A3, A3)), 255, 766),
    "edges of boxes": (edges_of(*SIZES, BOXES, False, BALLS), of_rows(OF_EDGES, A2, OF_FREE), 255, 200),
    "edges of any shapes": (edges_of(*SIZES, ANY, False, BALLS), of_rows(OF_EDGES, A2, OF_FREE), 255, 2032),
    "edges of clouds": (edges_of(*SIZES, ANY, True, BALLS), of_rows(OF_EDGES, A2, OF_FREE), 255, 2108),
    "gravity torques": (gravity_of(N_DOF, JOINTS), of_rows(OF_FALL), 54, 0),
    "mass matrices": (masses_of(N_DOF, JOINTS), of_rows(OF_FALL), 77, 0),
    "inverse dynamics": (inverse_of(N_DOF, JOINTS, 2), of_rows(OF_MOTIONS), 70, 0),
    "inverse dynamics of joined rows": (inverse_of(N_DOF, JOINTS, 0), of_rows(OF_FALL), 72, 0),
    "forward dynamics": (forward_of(N_DOF, JOINTS, 2), of_rows(OF_MOTIONS), 141, 0),
    "derivatives": (derivatives_of(N_DOF, JOINTS, 2), of_rows(OF_MOTIONS, A2, types.Tuple((FLAG, A2))), 141, 0),
    "searches": (
        searches_of(N_DOF),
        (A2, A2, A2, A2, A1, SETTINGS, JOBS, A3, A2, RESULTS, types.Tuple((FLAG, NEXT))),
        255,
        264,  # it knows the number of joints, and unrolls: twice as fast on an H200 as without spills
    ),
    "choice": (choose, (JOBS, A2, RESULTS, BOOLS_2, A2, RESULTS, NEXT, NEXT, NEXT), 127, 0),
    "turned": (turned_of(), of_rows((A2,), A2, MARKS, A3), 64, 0),
    "extents of points": (cloud_trees.write_extents, (A2, A2), 36, 0),
    "keys of points": (cloud_trees.write_keys, (A2, A2, NEXT), 34, 0),
    "counts of digits": (cloud_trees.count_digits, (NEXT, types.int64, types.int64, COUNTS), 36, 0),
    "sums of counts": (cloud_trees.accumulate, (COUNTS,), 34, 0),
    "moves by digit": (cloud_trees.move_by_digit, (NEXT, types.int64, types.int64, COUNTS, NEXT), 36, 0),
    "leaves of points": (cloud_trees.write_leaves, (A2, NEXT, BALL, types.UniTuple(types.int64, 2), A2), 53, 0),
    "levels of a tree": (cloud_trees.write_levels, (types.int64, types.int64, A2), 44, 0),
    "a tree of trees": (cloud_trees.join, (types.UniTuple(types.int64, 8), types.int64, A2), 38, 0),
    "branches": (branches_of(), of_rows((A2, A2, A1, COLUMNS, A2), A2, OF_BRANCHES, A3), 255, 282),
}


# The same over float32.
IN_FLOAT32 = {"poses": (58, 0), "jacobians": (67, 0), "frames": (53, 0), "overlaps of boxes": (70, 0)}
# The sine and cosine of CUDA reduce angles beyond 105615 by a product over float64; nothing else is over float64.
OF_LARGE_ANGLES = ("cvt.rn.f64.s64", "mul.f64", "cvt.rn.f32.f64", ".reg .f64")


def over_float32(kind):
    if isinstance(kind, types.NamedTuple):
        return types.NamedTuple(tuple(map(over_float32, kind.types)), kind.instance_class)
    if isinstance(kind, types.BaseTuple):
        return types.Tuple(tuple(map(over_float32, kind.types)))
    return types.Array(types.float32, kind.ndim, "C") if isinstance(kind, types.Array) and kind.dtype == types.float64 else kind


def resources(ptx, folder):
    """Registers, bytes of stack, and bytes of spill stores, by ptxas for sm_90."""
    ptxas = Path(sysconfig.get_path("purelib")) / "nvidia" / "cuda_nvcc" / "bin" / "ptxas"
    (folder / "driver.ptx").write_text(ptx)
    command = [ptxas, "-arch=sm_90", "-v", folder / "driver.ptx", "-o", folder / "driver.cubin"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    used = [int(n) for n in re.findall(r"Used (\d+) registers", told)]
    spills = [int(n) for n in re.findall(r"(\d+) bytes spill stores", told)]
    stack = [int(n) for n in re.findall(r"(\d+) bytes stack frame", told)]
    return max(used), max(stack), max(spills)


SLOW = {"edges of any shapes", "edges of clouds"}  # minutes of the compiler


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in DRIVERS])
def test_a_driver_becomes_machine_code_within_its_registers(name, ptx_of_driver, tmp_path, record_property):
    driver, signature, most_registers, most_spilled = DRIVERS[name]
    text = ptx_of_driver(driver, signature)
    assert ".visible .entry" in text
    assert ".f32" not in text
    registers, stack, spilled = resources(text, tmp_path)
    record_property("registers, stack, spilled", (registers, stack, spilled))
    assert registers <= most_registers
    assert spilled <= most_spilled


@pytest.mark.parametrize("name", IN_FLOAT32)
def test_a_driver_over_float32_becomes_machine_code_without_float64(name, ptx_of_driver, tmp_path, record_property):
    driver, signature, *_ = DRIVERS[name]
    most_registers, most_spilled = IN_FLOAT32[name]
    text = ptx_of_driver(in_single(driver), tuple(map(over_float32, signature)))
    of_float64 = [line.strip() for line in text.splitlines() if ".f64" in line]
    assert all(line.startswith(OF_LARGE_ANGLES) for line in of_float64)
    products = [line for line in of_float64 if line.startswith("mul")]
    assert all(line.endswith("0d3BF921FB54442D19;") for line in products), "pi / 2^65 alone"
    assert len(products) <= 4
    registers, stack, spilled = resources(text, tmp_path)
    record_property("registers, stack, spilled", (registers, stack, spilled))
    assert registers <= most_registers
    assert spilled <= most_spilled


def test_numbers_are_converted_on_the_device(ptx_of_driver, tmp_path):
    text = ptx_of_driver(converted, (over_float32(A2), A2))
    assert "cvt.f64.f32" in text
    assert resources(text, tmp_path)[2] == 0


def test_what_does_not_compile_is_seen(ptx_of_driver):
    def driver(x):
        x[0] = np.empty(3)[0]

    with pytest.raises(Exception, match="empty"):
        ptx_of_driver(driver, (A1,))
