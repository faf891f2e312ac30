"""A kernel is a formula: it allocates nothing, raises nothing and runs one problem. Entries of a room run batches.

Read from the syntax trees of the files below ``src/ulna/kernels``, so that a file is checked that no test imports.
"""

import ast
from pathlib import Path

import pytest

KERNELS = Path(__file__).parents[2] / "src" / "ulna" / "kernels"
DECORATORS = {"kernel", "exact_kernel", "routine", "shared_routine"}
IMPORTS, IMPORTS_FROM = {"math", "numpy"}, {"ulna.engine.decorators", "ulna.engine.lanes"}
NAMES_ONLY = {
    "chain/branch_records.py",
    "collision/scene.py",
    "distance/body_records.py",
    "dynamics/dynamics_records.py",
    "ik/search_records.py",
    "planning/constraint_records.py",
    "planning/time_records.py",
    "servo/objective.py",
    "servo/servo_records.py",
}  # NamedTuples and records, and no formula
BUILTINS = {"abs", "float", "int", "max", "min", "range"}
OF_NUMPY = {"np.ceil", "np.floor", "np.inf", "np.nan", "np.pi", "np.sqrt", "math.pi"}  # constants, and what takes plain numbers
ALLOCATES = ast.List, ast.Dict, ast.Set, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp, ast.JoinedStr
NO_FORMULA = ast.Raise, ast.Try, ast.Assert, ast.With, ast.Lambda, ast.ClassDef, ast.Yield, ast.Await, ast.Global, ast.Import
LANES = {"WIDTH", "lane_count"}
# What has a row for each joint, body, pair ... of one problem, and no row for each problem of a batch; besides ``..._rows``.
TABLES = {
    "acceleration_limits",
    "balls",
    "bodies",
    "chain",
    "goal.hands",
    "groups",
    "hands",
    "jerk_limits",
    "joints",
    "edges",
    "faces",
    "keeps.allowed",
    "limits",
    "objects",
    "out",
    "pairs",
    "points",
    "posture",
    "shadows",
    "space",
    "speeds",
    "state",
    "velocity_limits",
    "vertices",
    *("near.unseen", "margins.touching"),  # empty where a caller does without
    *("intervals.steps", "intervals.bends"),  # of one path
}
LANE_LOOPS = {
    "collision/reached.py lane_minimum": "one box around a body in eight intervals of one edge: a minimum over the lanes",
    "collision/ball_motion.py world_rounding": "the largest coordinate of the bounds of the eight children of the BVH's root",
    "collision/bvh.py end_row": "the first or the last of the eight children of a node of the BVH: one search, no batch",
    "distance/epa.py with_penetration": "EPA grows one polytope: it runs lane by lane, in the few lanes whose cores overlap",
}


def name_of(node):
    return ast.unparse(node) if isinstance(node, (ast.Name, ast.Attribute)) else ""


def functions_in(tree):
    return [node for node in tree.body if isinstance(node, ast.FunctionDef)]


def faults_of_module(tree):
    """What a module does besides constants, imports of formulas, and decorated functions."""
    faults = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            faults += [f"imports {alias.name}" for alias in node.names if alias.name not in IMPORTS]
        if (
            isinstance(node, ast.ImportFrom)
            and node.module not in IMPORTS_FROM
            and not str(node.module).startswith("ulna.kernels.")
        ):
            faults.append(f"imports from {node.module}")
        if isinstance(node, ast.ImportFrom) and node.module == "ulna.engine.decorators":
            faults += [f"imports {alias.name}" for alias in node.names if alias.name not in DECORATORS]
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in {"np", "math"}:
            faults += [f"uses {name_of(node)}"] if name_of(node) not in OF_NUMPY else []
    for function in functions_in(tree):
        if [name_of(d) for d in function.decorator_list] not in [[d] for d in DECORATORS]:
            faults.append(f"{function.name} is decorated with {[ast.unparse(d) for d in function.decorator_list]}")
    return faults


def faults_of_function(function, known):
    """What in a function allocates, raises, calls what is no formula, or is no formula itself."""
    faults = []
    for node in (n for statement in function.body for n in ast.walk(statement)):
        if isinstance(node, (*ALLOCATES, *NO_FORMULA, ast.FunctionDef)):
            faults.append(f"{function.name}: {type(node).__name__}")
        if isinstance(node, ast.Call) and name_of(node.func) not in known | BUILTINS | OF_NUMPY:
            faults.append(f"{function.name} calls {ast.unparse(node.func)}")
    return faults


def known_names(tree):
    imported = {a.asname or a.name for node in tree.body if isinstance(node, ast.ImportFrom) for a in node.names}
    return imported | {f.name for f in functions_in(tree)}


def batches_of(function):
    """The arrays whose length is asked for that are neither a table nor rows of one problem."""
    read = [n.value for n in ast.walk(function) if isinstance(n, ast.Attribute) and n.attr in {"shape", "size"}]
    known = {name: name.removeprefix("scene.") for name in map(ast.unparse, read)}
    return {name for name, part in known.items() if part not in TABLES and not part.endswith("_rows")}


def loops_over_lanes(function):
    """Whether a loop counts lanes: over WIDTH or lane_count, or from one block of WIDTH problems to the next."""
    loops = [n for n in ast.walk(function) if isinstance(n, (ast.For, ast.While))]
    counted = [loop.iter if isinstance(loop, ast.For) else loop.test for loop in loops]
    return any(isinstance(n, ast.Name) and n.id in LANES for count in counted for n in ast.walk(count))


def faults_in(source):
    tree = ast.parse(source)
    return faults_of_module(tree) + [fault for f in functions_in(tree) for fault in faults_of_function(f, known_names(tree))]


def kernel_files():
    files = (path for path in KERNELS.rglob("*.py") if path.name != "__init__.py")
    return sorted(path for path in files if path.relative_to(KERNELS).as_posix() not in NAMES_ONLY)


def all_functions():
    """Every function by its file and name."""
    return {
        f"{path.relative_to(KERNELS).as_posix()} {function.name}": function
        for path in kernel_files()
        for function in functions_in(ast.parse(path.read_text()))
    }


def test_a_kernel_allocates_nothing_and_raises_nothing():
    files = kernel_files()
    assert len(files) > 40
    found = {path.relative_to(KERNELS).as_posix(): faults_in(path.read_text()) for path in files}
    assert {file: faults for file, faults in found.items() if faults} == {}


def names_numbers_or_a_type(node):
    """Whether a statement gives names to literal numbers, or one to a type: ``NDArray[np.void]``, or a ``Group``."""
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.Subscript):
        return True
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and ast.unparse(node.value.func) == "Group":
        return True
    return isinstance(node, ast.Assign) and all(isinstance(n, ast.Constant) for n in getattr(node.value, "elts", [node.value]))


@pytest.mark.parametrize("name", sorted(NAMES_ONLY))
def test_what_names_the_parts_of_an_argument_does_nothing_else(name):
    """It imports types. Its classes have fields and their documentation alone, and it may name plain numbers too."""
    nodes = [node for node in ast.parse((KERNELS / name).read_text()).body if not names_numbers_or_a_type(node)]
    assert {node.module for node in nodes if isinstance(node, ast.ImportFrom)} <= {
        "typing",
        "numpy.typing",
        "ulna.engine.records",
        "ulna.engine.signatures",
        "ulna.kernels.planning.constraint_records",
    }
    classes = [node for node in nodes if isinstance(node, ast.ClassDef)]
    assert {type(node) for node in nodes} - {ast.Import} == {ast.Expr, ast.ImportFrom, ast.ClassDef}
    assert {ast.unparse(base) for node in classes for base in node.bases} <= {"NamedTuple", "Record"}
    assert {type(part) for node in classes for part in node.body} == {ast.Expr, ast.AnnAssign}


def test_a_package_of_kernels_has_no_code():
    for path in KERNELS.rglob("__init__.py"):
        assert [type(node) for node in ast.parse(path.read_text()).body] == [ast.Expr], path


def test_no_kernel_loops_over_a_batch():
    """Lanes hold the problems of a batch: a loop over them belongs to an entry, but for those that are listed with a reason."""
    assert {name for name, function in all_functions().items() if loops_over_lanes(function)} == set(LANE_LOOPS)
    assert {name: batches_of(function) for name, function in all_functions().items() if batches_of(function)} == {}


KERNEL = "from ulna.engine.decorators import kernel\n@kernel\ndef f(x, rows):\n    "


@pytest.mark.parametrize(
    ("source", "fault"),
    [
        ("import numpy as np\n" + KERNEL + "return np.empty(3)", "uses np.empty"),
        ("import numpy as np\n" + KERNEL + "return np.linalg.norm(x)", "uses np.linalg"),
        ("import numpy\n" + KERNEL + "return numpy.zeros(3)", "f calls numpy.zeros"),
        ("from numpy import empty\n" + KERNEL + "return empty(3)", "imports from numpy"),
        (KERNEL + "return rows.copy()", "f calls rows.copy"),
        (KERNEL + "return [x, x]", "f: List"),
        (KERNEL + "return tuple(2 * y for y in x)", "f: GeneratorExp"),
        (KERNEL + "raise ValueError", "f: Raise"),
        (KERNEL + "import os", "f: Import"),
        ("from ulna.engine.decorators import entry\n@entry((1,))\ndef f(x):\n    return x", "imports entry"),
        ("from ulna.engine.decorators import workspace\n@workspace\ndef f(x):\n    return x", "imports workspace"),
        ("def f(x):\n    return x", "f is decorated with []"),
        ("from ulna.kinematics.entries.batch import gather", "imports from ulna.kinematics.entries.batch"),
    ],
)
def test_what_is_no_formula_is_found(source, fault):
    assert fault in faults_in(source)


@pytest.mark.parametrize(
    "loop", ["for lane in range(WIDTH): pass", "for start in range(0, n, WIDTH): pass", "while i < WIDTH: i += 1"]
)
def test_a_loop_over_a_batch_is_found(loop):
    assert loops_over_lanes(ast.parse(f"def f(n, i):\n    {loop}").body[0])


def test_the_length_of_a_batch_is_found():
    assert batches_of(ast.parse("def f(q, joints, q_rows):\n    return q.shape[0], joints.shape[0], q_rows.shape[0]")) == {"q"}
