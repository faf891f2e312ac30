"""A record has the same fields by name in Python, in machine code and as plain Python."""

import pickle
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from fresh_process import run_fresh
from ulna.engine.records import Record, copied
from ulna.engine.signatures import NONE, NUMBERS, WHOLE, Array, Group, fits, parts_of, text_of_signature


class Tally(Record):
    checks: int
    longest: float
    nodes: Annotated[NDArray[np.int64], 2]
    done: bool


class Twin(Record):
    checks: int
    longest: float
    nodes: Annotated[NDArray[np.int64], 2]
    done: bool


class Sums(NamedTuple):
    tallies: Any
    x: NDArray


TALLIES = """
from typing import Annotated, NamedTuple
import numpy as np
from numpy.typing import NDArray
from ulna.engine.decorators import entry, kernel
from ulna.engine.records import Record
from ulna.engine.signatures import NUMBERS, Array, Group

class Tally(Record):
    checks: int
    longest: float
    nodes: Annotated[NDArray[np.int64], 2]
    done: bool

class Sums(NamedTuple):
    tallies: NDArray
    x: NDArray

@kernel
def grow(tally, x):
    tally.checks += 1
    tally.longest = max(tally.longest, x)
    tally.nodes[1] += 2
    tally.done = tally.checks > 2

@entry((Group((Array(Tally, 1), NUMBERS), Sums), Array(Tally, 1, constant=True)))
def count(sums, limits):
    tally = sums.tallies[0]
    for i in range(sums.x.shape[0]):
        if tally.checks < limits[0].checks:
            grow(tally, sums.x[i])
    return tally.checks

@entry((Array(Tally, 1),))
def misspelt(tallies):
    tallies[0].cheks += 1
    return True
"""
ASK = """
import numpy as np, tallies
from tallies import Sums, Tally, count, misspelt
limits, own = Tally.records(), Tally.records()
limits[0].checks = 3
limits.setflags(write=False)
print(count(Sums(own, np.array([0.5, 2.0, 1.0, 9.0])), limits))
print(own[0].checks, own[0].longest, own[0].nodes.tolist(), own[0].done)
print(len(getattr(count, "signatures", [1])))
try:
    misspelt(own)
except Exception as error:
    print("cheks" in str(error))
"""


@pytest.mark.process
@pytest.mark.parametrize("plain", [pytest.param(0, marks=pytest.mark.compiler), 1])
def test_an_entry_takes_records_whole_and_refuses_a_field_that_does_not_exist(tmp_path, plain):
    (tmp_path / "tallies.py").write_text(TALLIES)
    text = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{ASK}"
    printed = run_fresh(text, NUMBA_CACHE_DIR=tmp_path / "cache", NUMBA_DISABLE_JIT=plain)
    assert printed == ["3", "3 2.0 [0, 6] True", "1", "True"]


def test_a_record_of_an_array_is_no_copy():
    tallies = Tally.records(2)
    second = tallies[1]
    second.checks += 5
    second.nodes[0] = 7
    assert tallies["checks"].tolist() == [0, 5]
    assert tallies["nodes"].tolist() == [[0, 0], [7, 0]]
    assert type(tallies) is np.ndarray


def test_a_copy_of_records_is_writable_and_of_its_own():
    tallies = Tally.records(2)
    tallies[1].nodes[0] = 7
    tallies.setflags(write=False)
    copy = copied(tallies)
    copy[1].checks = 3
    assert tallies[1].checks == 0
    assert (copy[1].nodes.tolist(), copy[1].checks) == ([7, 0], 3)
    assert fits(copy, Array(Tally, 1))


def test_a_field_that_was_not_declared_can_be_neither_read_nor_written():
    tally = Tally.records()[0]
    with pytest.raises(AttributeError):
        tally.cheks = 1  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(AttributeError):
        assert tally.cheks  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize("name", ["sum", "dtype", "item"])
def test_a_field_cannot_have_the_name_of_what_numpy_has(name):
    with pytest.raises(TypeError, match=f"Bad.{name}"):
        type("Bad", (Record,), {"__annotations__": {name: int}})


def test_records_can_be_pickled_and_passed_again():
    tallies = Tally.records(2)
    tallies[1].longest = 0.5
    again = pickle.loads(pickle.dumps(tallies))  # noqa: S301 - our own
    assert type(again[1]) is Tally
    assert again[1].longest == 0.5
    assert fits(again, Array(Tally, 1))


@pytest.mark.compiler
def test_unpickled_records_are_of_the_type_that_an_entry_was_compiled_for():
    from numba import typeof  # a wheel is tested without it

    from ulna.engine.compiler import numba_types

    tallies = Tally.records(3)
    assert {typeof(tallies), typeof(pickle.loads(pickle.dumps(tallies)))} == set(numba_types([Array(Tally, 1)]))  # noqa: S301


def test_a_signature_names_the_records_and_their_size():
    group = Group((Array(Tally, 1), NUMBERS), Sums)
    assert text_of_signature((group, NONE, Array(Tally, 1, constant=True))) == "(1w[Tally 40]1wd)-1r[Tally 40]"
    assert [*parts_of((group, WHOLE))] == [Array(Tally, 1), NUMBERS, WHOLE]


def test_a_named_tuple_fits_where_its_class_is_asked_for():
    group, x = Group((Array(Tally, 1), NUMBERS), Sums), np.zeros(3)
    assert fits(Sums(Tally.records(), x), group)
    assert not fits((Tally.records(), x), group)
    assert not fits(Sums(np.zeros(1), x), group)
    assert not fits(Tally.records(), NUMBERS)
    assert fits(Twin.records(), Array(Twin, 1))
