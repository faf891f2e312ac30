"""Entries are functions that callers import, and nothing loads the compiler before one is taken."""

import pickle
import subprocess
import sys
from types import ModuleType

import numpy as np
import pytest

from ulna.engine.decorators import ENTRIES
from ulna.engine.entries import Entries, modules_of, ready
from ulna.errors import UlnaError
from ulna.kinematics.entries import forward

ULNA, stand_in_for = Entries("ulna"), modules_of("ulna.kinematics.entries")


def test_a_function_is_the_same_by_either_import():
    from ulna.kinematics.entries.forward import forward_batch

    assert forward.forward_batch is forward_batch is ULNA.marked("kinematics.entries.forward.forward_batch")
    assert stand_in_for("forward").forward_batch is forward_batch


def test_a_stand_in_is_a_plain_module_so_that_a_function_is_found_in_it_as_fast_as_in_any():
    stand_in = stand_in_for("forward")
    assert type(stand_in) is ModuleType
    assert "forward_batch" not in vars(stand_in)
    function = stand_in.forward_batch
    assert vars(stand_in)["forward_batch"] is function


def test_what_a_module_has_besides_entries_is_taken_from_it_too():
    assert stand_in_for("forward").WIDTH == 8


@pytest.mark.parametrize("name", ["forwrd", "forward.none", "forward.forward_batch.x", "__wrapped__", "forward.__wrapped__"])
def test_a_name_that_there_is_not_is_refused(name):
    module, _, attribute = name.partition(".")
    with pytest.raises(AttributeError, match="has no attribute"):
        getattr(stand_in_for(module), attribute)


@pytest.mark.parametrize(
    "name",
    [
        "kinematics.entries.forward.gather",
        "kinematics.entries.forward.np",
        "kinematics.entries.forward.none",
        "kinematics.entries.forward.forward_batch.x",
        "kinematics.forward.forward_batch",
        "forward.forward_one",
    ],
)
def test_a_name_that_is_no_entry_is_not_listed(name):
    with pytest.raises(LookupError):
        ULNA.marked(name)


def test_all_entries_have_a_name_and_nothing_else_has():
    names = ULNA.names()
    assert len(names) == len(set(names)) == sum(calls.name.startswith("ulna.") for calls in ENTRIES.values())
    assert all(ULNA.marked(name) in ENTRIES for name in names)


def test_the_list_of_entries_can_be_given_to_another_process():
    assert pickle.loads(pickle.dumps(ULNA)) == ULNA  # noqa: S301 - our own


def test_what_is_compiled_together_is_that_of_three_rooms():
    assert {name.split(".")[0] for name in ULNA.names() if ULNA.are_together(name)} == {"collision", "planning", "servo"}


def test_without_machine_code_and_compiler_an_entry_is_refused(monkeypatch):
    """Python would take a thousand times as long."""
    monkeypatch.setattr("ulna.engine.entries.ahead_entry", lambda *_: None)
    monkeypatch.setattr("ulna.engine.decorators.compiler", None)
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    with pytest.raises(UlnaError, match="neither machine code nor a compiler"):
        _ = stand_in_for("forward").forward_one


def test_an_entry_of_low_latency_is_compiled_when_it_is_made_ready_and_refuses_arguments_of_other_types(panda):
    forward_one, chain, T = ready(forward.forward_one), panda.tree.chain(panda.tip).copy(), np.empty((4, 4))
    assert forward_one(chain, 7, panda.home.copy(), T)
    for wrong in (panda.home.astype(np.float32), panda.home.tolist(), None):
        with pytest.raises(TypeError):
            forward_one(chain, 7, wrong, T)


CALLERS = [
    "kinematics.forward",
    "kinematics.jacobian",
    "collision.checker",
    "ik.search.restarts",
    "ik.search.numeric",
    "ik.differential",
    "robot",
    "collision.entries",
    "viewer.film.entries",
]


@pytest.mark.process
@pytest.mark.parametrize("module", [*CALLERS, "viewer.film.film", "engine.entries", "engine.threads"])
def test_a_module_that_calls_entries_loads_no_compiler(module):
    code = f"import sys, ulna.{module}; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


def test_a_kernel_can_be_written_where_there_is_no_file():
    source = "from ulna.engine.decorators import kernel\n@kernel\ndef twice(x):\n    return 2.0 * x\n"
    names = {}
    exec(compile(source, "<stdin>", "exec"), names)  # noqa: S102 - as an interpreter does
    assert names["twice"](1.5) == 3.0
