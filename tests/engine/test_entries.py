"""Entries are found by name, and nothing loads the compiler before one is asked for."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

from ulna.drivers import DRIVERS, entry
from ulna.engine.decorators import ENTRIES


@pytest.mark.compiler
def test_an_entry_is_found_by_its_module_and_function():
    from ulna.drivers.forward import forward_batch

    assert entry("forward.forward_batch") is forward_batch
    assert pickle.loads(pickle.dumps(DRIVERS)).find("forward.forward_batch") is forward_batch  # noqa: S301 - our own


@pytest.mark.parametrize("name", ["forward.gather", "forward.np", "forward.none", "forward", "", "forward.forward_batch.x"])
def test_a_name_that_is_no_entry_is_refused(name):
    with pytest.raises((LookupError, ImportError)):
        entry(name)


def test_all_entries_of_the_drivers_have_a_name_and_nothing_else_has():
    names = DRIVERS.names()
    assert len(names) == len(set(names)) == sum(marked.__module__.startswith("ulna.drivers.") for marked in ENTRIES)
    assert all(DRIVERS.marked(name) in ENTRIES for name in names)


def test_what_is_compiled_together_is_a_module_with_entries():
    assert DRIVERS.compiled_together <= {name.partition(".")[0] for name in DRIVERS.names()}


def test_an_entry_of_low_latency_is_compiled_when_it_is_asked_for_and_refuses_arguments_of_other_types(panda):
    forward_one, chain, T = entry("forward.forward_one"), panda.tree.chain(panda.tip).copy(), np.empty((4, 4))
    assert forward_one(chain, 7, panda.home.copy(), T)
    for wrong in (panda.home.astype(np.float32), panda.home.tolist(), None):
        with pytest.raises(TypeError):
            forward_one(chain, 7, wrong, T)


CALLERS = [
    "kinematics.forward",
    "kinematics.jacobian",
    "collision.checker",
    "ik.search.restarts",
    "ik.search.single_target",
    "ik.search.textbook_methods",
    "ik.differential",
    "robot",
    "drivers",
]


@pytest.mark.parametrize("module", [*CALLERS, "viewer.film.film", "engine.entries", "engine.threads"])
def test_a_module_that_calls_entries_loads_no_compiler(module):
    code = f"import sys, ulna.{module}; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


def test_a_kernel_can_be_written_where_there_is_no_file():
    source = "from ulna.engine.decorators import kernel\n@kernel\ndef twice(x):\n    return 2.0 * x\n"
    names = {}
    exec(compile(source, "<stdin>", "exec"), names)  # noqa: S102 - as an interpreter does
    assert names["twice"](1.5) == 3.0
