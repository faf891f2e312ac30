"""A version of Numba that lacks a private name, or has another thing under it: the engine does without it and says so.

Such a Numba is imitated in a process of its own, before Ulna is imported: a name is hidden from the module that looks for it,
since Numba itself uses most of them.
"""

import ast
import json
from pathlib import Path

import numpy as np
import pytest

import ulna
from fresh_process import run_fresh
from ulna.engine import numba_private
from ulna.engine.numba_private import AHEAD, CACHE, CODE, LISTED, MEMORY, PASSES, PERMISSION, ROWS

pytestmark = pytest.mark.compiler

HIDE = """
import importlib.util, json, sys, warnings
import numba

def without(path):
    \"\"\"The module that looks for private names, in a Numba that lacks one of them.\"\"\"

    def is_hidden(owner, name):
        kind = owner if isinstance(owner, type) else type(owner)
        return path in (f"{kind.__module__}.{kind.__qualname__}.{name}", f"{getattr(owner, '__name__', '')}.{name}")

    def get(owner, name):
        if is_hidden(owner, name):
            raise AttributeError(name)
        return getattr(owner, name)

    spec = importlib.util.find_spec("ulna.engine.numba_private")
    module = importlib.util.module_from_spec(spec)
    module.getattr, module.hasattr = get, lambda owner, name: not is_hidden(owner, name) and hasattr(owner, name)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
"""
RESULTS = """
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    import numpy as np, ulna
    panda, world = ulna.load("panda"), ulna.World()
    world.add("box", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.4, 0, 0.4)))
    q = panda.random(64, seed=1)
    T = panda.forward_kinematics(q)
    solved = panda.inverse_kinematics(T)
    one = panda.forward_kinematics(q[0]), panda.inverse_kinematics(T[0]).q, panda.in_collision(q[0], world)
arrays = T, solved.q, solved.success, panda.in_collision(q, world), *one
print(json.dumps([np.ascontiguousarray(array, dtype=float).tobytes().hex() for array in arrays]))
print(json.dumps([[warning.category.__name__, str(warning.message)] for warning in caught]))
from ulna.engine import numba_private
print(*numba_private.turned_off())
print(sum(entry.stats.cache_hits.total() for entry in sys.modules["ulna.engine.decorators"].ENTRIES))
"""
T, Q, SUCCESS, TOUCHES = range(4)
# For each group one name; what else is off without it.
EXAMPLES = {
    CODE: ("numba.core.codegen.JITCodeLibrary._get_module_for_linking", ()),
    CACHE: ("numba.core.caching._CacheLocator", ()),
    PASSES: ("numba.core.typed_passes.AnnotateTypes", ()),
    MEMORY: ("numba.core.types.functions.Function.get_impl_key", ()),
    ROWS: ("numba.np.arrayobj.populate_array", ()),
    PERMISSION: ("numba.core.registry.CPUDispatcher._compile_for_args", ()),
    AHEAD: ("numba.core.codegen.JITCodeLibrary._final_module", ()),
}


def results(program, folder):
    """The arrays, the warnings, what is turned off, and how many entries were loaded from disk."""
    arrays, warned, off, hits = run_fresh(HIDE + program + RESULTS, NUMBA_CACHE_DIR=folder)
    return [np.frombuffer(bytes.fromhex(text)) for text in json.loads(arrays)], json.loads(warned), off.split(), int(hits)


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    arrays, warned, off, _ = results("", tmp_path_factory.mktemp("cache"))
    assert (warned, off) == ([], [])
    return arrays


def assert_close(found, expected):
    """Verdicts are equal, numbers to some last bits: LLVM may add up in another order."""
    for which in (SUCCESS, TOUCHES):
        assert np.array_equal(found[which], expected[which])
    assert np.abs(found[T] - expected[T]).max() < 1e-14
    assert np.abs(found[Q] - expected[Q]).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("group", EXAMPLES)
def test_without_a_name_results_are_as_they_were_and_one_warning_names_it(group, expected, tmp_path):
    path, more = EXAMPLES[group]
    arrays, (warned,), off, _ = results(f"without({path!r})", tmp_path)
    assert off == sorted({group, *more})
    kind, message = warned
    assert kind == "CompilerWarning"
    assert path in message
    assert "0.63.0 to" in message
    if group == CODE:
        assert_close(arrays, expected)
    else:
        assert all(map(np.array_equal, arrays, expected))


@pytest.mark.slow
@pytest.mark.parametrize("group", [CODE, CACHE])
def test_machine_code_is_kept_on_disk_unless_names_of_the_cache_are_missing(group, tmp_path):
    program = f"without({EXAMPLES[group][0]!r})"
    first, *_, hits = results(program, tmp_path)
    again, *_, more = results(program, tmp_path)
    assert hits == 0
    assert (more > 0) == (group != CACHE)
    assert all(map(np.array_equal, first, again))


@pytest.mark.process
def test_each_name_that_is_listed_is_looked_for():
    program = f"""
for path in {list(LISTED)!r}:
    module = without(path)
    print(path, path in module.missing_of(*module.turned_off()), len(module.turned_off()) > 0)
"""
    assert run_fresh(HIDE + program) == [f"{path} True True" for path in LISTED]
    assert numba_private.turned_off() == ()


# A version that was not tested, in which a name stands for something else.
OTHER = 'numba.__version__ = "0.99.0"\n'
CHANGED = f"""{OTHER}
import numba.core.codegen as codegen
class JITCodeLibrary(codegen.JITCodeLibrary):
    def add_ir_module(self, module, another_argument):
        pass
codegen.JITCodeLibrary = JITCodeLibrary
"""


@pytest.mark.slow
def test_a_version_that_was_not_tested_is_tried_first(expected, tmp_path):
    arrays, warned, off, _ = results(OTHER, tmp_path)
    assert (warned, off) == ([], [])
    assert all(map(np.array_equal, arrays, expected))


@pytest.mark.process
def test_what_fails_in_a_version_that_was_not_tested_is_done_without(expected, tmp_path):
    arrays, (warned,), off, _ = results(CHANGED, tmp_path)
    assert off == sorted([CODE, MEMORY, PASSES])
    assert "TypeError" in warned[1]
    assert "0.99.0" in warned[1]
    assert_close(arrays, expected)


PUBLIC = {"numba", "numba.extending", "numba.core"}  # of the last: cgutils, which Numba's guide to extensions uses


def test_only_one_module_of_the_engine_imports_private_names():
    for file in Path(ulna.__file__).parent.joinpath("engine").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "numba":
                assert node.module in PUBLIC, file
                if node.module == "numba.core":
                    assert [alias.name for alias in node.names] == ["cgutils"], file
            if isinstance(node, ast.Import):
                assert not any(alias.name.startswith("numba.") for alias in node.names), file


@pytest.mark.process
def test_as_plain_python_nothing_is_missed():
    """``njit`` then returns the function itself, which has none of a dispatcher's attributes."""
    assert run_fresh("import ulna.kinematics.entries.forward; print('quiet')", NUMBA_DISABLE_JIT=1) == ["quiet"]
