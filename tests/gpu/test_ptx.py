"""Every kernel of kinematics, inverse kinematics and collision compiles for a GPU as it is, with a float64 for the number.

No GPU and no driver is needed: ``make test-cuda``.
"""

import importlib
import inspect
import pkgutil

import numpy as np
import pytest
from numba import types
from numba.core.dispatcher import Dispatcher

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

import ulna.kernels
from cuda_arguments import POSED_BOX, SCENE_OF_BOXES, argument_types, place_of

COMPILED = "chain", "collision", "distance", "dynamics", "ik", "servo", "spatial"
LEFT_OUT = {"planning": "one search at a time, on the CPU", "render": "films are drawn by the CPU"}
SHAPES_ALONE = {  # not called where all are boxes
    "collision.bounding_planes.write_plane",
    "collision.posed_pair.convex_body",
    "collision.posed_pair.convex_overlap",
}


def kernels():
    """Every kernel below ``ulna.kernels``, by its folder, module and name."""
    modules = [importlib.import_module(m.name) for m in pkgutil.walk_packages(ulna.kernels.__path__, "ulna.kernels.")]
    found = [
        f.py_func for m in modules for f in vars(m).values() if isinstance(f, Dispatcher) and f.py_func.__module__ == m.__name__
    ]
    return {place_of(kernel): kernel for kernel in found}


KERNELS = {place: kernel for place, kernel in kernels().items() if place.split(".")[0] not in LEFT_OUT}
# A robot and a world of boxes have no vertices: these kernels are compiled a second time, without the search for distances.
OF_BOXES = {
    p: k
    for p, k in KERNELS.items()
    if p.startswith("collision.") and not {"vertices", "posed", "ours", "scene"}.isdisjoint(inspect.signature(k).parameters)
}


def check(text, kernel):
    assert ".target sm_90" in text
    assert ".visible .func" in text
    assert kernel.__name__ in text
    assert ".extern" not in text, "it calls what is not there: an allocator, or a function of the CPU"
    assert ".f32" not in text, "the number is no longer a float64"


def test_every_folder_of_kernels_is_compiled_or_left_out_by_name():
    folders = {m.name for m in pkgutil.iter_modules(ulna.kernels.__path__) if m.ispkg}
    assert folders == {*COMPILED, *LEFT_OUT}
    assert {place.split(".")[0] for place in KERNELS} == set(COMPILED)


@pytest.mark.parametrize("place", sorted(KERNELS))
def test_a_kernel_compiles_to_ptx(place, ptx):
    check(ptx(KERNELS[place], argument_types(KERNELS[place])), KERNELS[place])


@pytest.mark.parametrize("place", sorted(set(OF_BOXES) - SHAPES_ALONE))
def test_a_kernel_of_boxes_compiles_to_ptx(place, ptx):
    instead = {"vertices": types.none, "points": types.none, "scene": SCENE_OF_BOXES}
    instead |= dict.fromkeys(("posed", "ours", "theirs"), POSED_BOX)
    check(ptx(OF_BOXES[place], argument_types(OF_BOXES[place], **instead)), OF_BOXES[place])


def test_a_kernel_that_the_table_of_arguments_lacks_is_a_failure():
    def kernel(pose, unheard_of):
        return pose

    kernel.__module__ = "ulna.kernels.chain.new"
    with pytest.raises(LookupError, match=r"chain.new.kernel.*unheard_of"):
        argument_types(kernel)


def test_what_allocates_does_not_compile(ptx):
    def kernel(x):
        return np.empty(3)[0] + x

    with pytest.raises(Exception, match="empty"):
        ptx(kernel, (types.float64,))
