"""A shared routine is compiled once for all entries that call it, and loaded from disk before them.

Each test runs processes of its own over a module and a cache folder of their own.
"""

import pytest

from fresh_process import run_fresh

pytestmark = pytest.mark.compiler

SUMS = """
from ulna.engine.decorators import entry, shared_routine, routine
from ulna.engine.signatures import NUMBERS, MATRIX

@shared_routine
def power(x, n):
    return x**n

@shared_routine
def total(x, n):
    sum = 0.0
    for i in range(x.shape[0]):
        sum += power(x[i], n)
    return sum

@routine
def doubled(x):
    return 2.0 * total(x, 1.0)

@entry((NUMBERS,))
def twice(x):
    return doubled(x)

@entry((NUMBERS,), (MATRIX,))
def squares(x):
    return total(x.reshape(-1), 2.0)
"""
ASK = """
import numpy as np, sums
print(sums.twice(np.arange(4.0)), sums.squares(np.arange(4.0)), sums.squares(np.ones((2, 3))))
"""
STATS = """
for each in (sums.total.within, sums.power.within, sums.twice, sums.squares):
    print(sum(each.stats.cache_hits.values()), sum(each.stats.cache_misses.values()))
"""


@pytest.fixture
def ask(tmp_path):
    """Runs a text in a process that can import the module."""
    (tmp_path / "sums.py").write_text(SUMS)

    def asked(source=ASK, file=tmp_path / "sums.py"):
        text = f"import sys; sys.path.insert(0, {str(file.parent)!r})\n{source}"
        return run_fresh(text, NUMBA_CACHE_DIR=tmp_path / "cache")

    return asked


@pytest.mark.process
def test_callers_name_it_and_hold_no_copy(ask):
    assert ask(
        ASK
        + """
from ulna.engine.shared import SHARED
print(len(SHARED))
for entry in (sums.twice, sums.squares):
    for text in entry.inspect_llvm().values():
        lines = [line for symbol in SHARED for line in text.splitlines() if f"@{symbol}(" in line]
        print(sum(line.startswith("declare") for line in lines), sum(line.startswith("define") for line in lines))
"""
    ) == ["12.0 14.0 6.0", "2", "1 0", "1 0", "1 0"]


@pytest.mark.process
def test_it_is_compiled_once_and_then_loaded_with_the_first_that_calls_it(ask):
    assert ask(ASK + STATS) == ["12.0 14.0 6.0", "0 1", "0 1", "0 1", "0 2"]
    assert ask(ASK + STATS) == ["12.0 14.0 6.0", "1 0", "1 0", "1 0", "2 0"]
    assert ask("import numpy as np, sums\nprint(sums.twice(np.ones(2)))" + STATS) == ["4.0", "1 0", "1 0", "1 0", "0 0"]


@pytest.mark.process
def test_one_that_is_lost_is_compiled_again_for_callers_on_disk(ask, tmp_path):
    ask()
    lost = [file for file in (tmp_path / "cache").rglob("*total*") if file.is_file()]
    assert lost
    for file in lost:
        file.unlink()
    assert ask(ASK + STATS) == ["12.0 14.0 6.0", "0 1", "1 0", "1 0", "2 0"]


@pytest.mark.process
def test_a_change_in_it_reaches_its_callers(ask, tmp_path):
    ask()
    (tmp_path / "sums.py").write_text(SUMS.replace("x**n", "x**n + 1.0"))
    assert ask() == ["20.0 18.0 12.0"]


@pytest.mark.process
def test_compiled_ahead_it_is_in_one_object_file(ask, tmp_path):
    for folder in ("room_of_sums", "room_of_sums/entries"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").touch()
    (tmp_path / "room_of_sums" / "entries" / "sums.py").write_text(
        SUMS.replace("return doubled(x)", "return doubled(x) > 0.0").replace(
            "return total(x.reshape(-1), 2.0)", "return total(x.reshape(-1), 2.0) > 0.0"
        )
    )
    write = """
import json
from pathlib import Path
from ulna.engine.emit import write_objects
from ulna.engine.entries import Entries
folder = Path(FOLDER)
write_objects(Entries("room_of_sums"), folder, "rest")
index = json.loads((folder / "rest.json").read_text())
objects = [set(overload["objects"]) for entry in index for overload in entry["overloads"]]
print(*map(len, objects), len(set.union(*objects)), all((folder / name).exists() for name in set.union(*objects)))
""".replace("FOLDER", repr(str(tmp_path / "objects")))
    assert ask(write) == ["3 3 3 5 True"]
    assert ask(write) == ["3 3 3 5 True"]  # what is there is kept
