"""Names for all that crosses into machine code: no entry of a state, of settings or of a report is read by a number.

Read from the syntax trees of a room: its face, its entries and its kernels. A numbered place is a subscript whose index has a
name that stands for a plain number in a module of kernels, however it was imported, or an integer where such a name indexes the
same variable in the same file. Tables of many rows have columns, so these are left out.
"""

import ast
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "src" / "ulna"
# By room: how many numbered places it has. A room that has none stays so.
ROOMS = {"planning": 0, "servo": 0}
# Tables whose rows are joints, bodies, frames, pairs, nodes or eight problems: the names of their last part.
TABLES = {"bodies", "chain", "curve", "frames", "joints", "nodes", "objects", "pairs", "points", "steps", "table"}
TABLES |= {"contact_rows", "pair_rows"}


def numbers_in(tree):
    """The names that a module gives to literal whole numbers, alone or several at once."""
    names = set()
    for node in tree.body:
        if isinstance(node, ast.Assign):
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            ranged = isinstance(node.value, ast.Call) and ast.unparse(node.value.func) == "range"
            if ranged or all(isinstance(value, ast.Constant) and type(value.value) is int for value in values):
                names |= {each.id for target in node.targets for each in ast.walk(target) if isinstance(each, ast.Name)}
    return names


def kernel_numbers():
    """By module of kernels: the numbers that it names."""
    files = [*(SOURCES / "kernels").rglob("*.py")]
    return {
        f"ulna.{'.'.join(path.relative_to(SOURCES).with_suffix('').parts)}": numbers_in(ast.parse(path.read_text()))
        for path in files
    }


def numbered_in(tree, numbers):
    """The numbered places of a module."""
    named, modules = {}, {}
    for node in (n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)):
        for alias in node.names:
            own = alias.asname or alias.name
            if alias.name in numbers.get(str(node.module), ()):
                named[own] = alias.name
            modules |= {own: numbers[f"{node.module}.{alias.name}"]} if f"{node.module}.{alias.name}" in numbers else {}
    own = numbers_in(tree)

    def is_number(node):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            return node.attr in modules.get(node.value.id, ())
        return isinstance(node, ast.Name) and (node.id in named or node.id in own)

    places = [node for node in ast.walk(tree) if isinstance(node, ast.Subscript) and last_part(node.value) not in TABLES]
    by_name = [node for node in places if any(map(is_number, parts_of_index(node.slice)))]
    bases = {ast.unparse(node.value) for node in by_name}
    by_literal = [node for node in places if ast.unparse(node.value) in bases and isinstance(node.slice, ast.Constant)]
    return sorted({f"{node.lineno}: {ast.unparse(node)}" for node in (*by_name, *by_literal)})


def parts_of_index(index):
    """An index, the indices of several axes, where a slice begins, and the terms of a sum: ``state[PLACE + k]``."""
    if isinstance(index, ast.Tuple):
        return [part for each in index.elts for part in parts_of_index(each)]
    if isinstance(index, ast.Slice):
        return [] if index.lower is None else parts_of_index(index.lower)
    return [*parts_of_index(index.left), *parts_of_index(index.right)] if isinstance(index, ast.BinOp) else [index]


def last_part(node):
    """The name of what is subscripted, without what it is an attribute or an entry of."""
    while isinstance(node, ast.Subscript):
        node = node.value
    return node.attr if isinstance(node, ast.Attribute) else ast.unparse(node)


def files_of(room):
    """Its face with its entries, and its kernels."""
    folders = [folder for folder in (SOURCES / room, SOURCES / "kernels" / room) if folder.is_dir()]
    return sorted(path for folder in folders for path in folder.rglob("*.py"))


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_has_no_more_numbered_places_than_it_says(room):
    numbers = kernel_numbers()
    found = {str(path.relative_to(SOURCES)): numbered_in(ast.parse(path.read_text()), numbers) for path in files_of(room)}
    assert sum(map(len, found.values())) == ROOMS[room], {file: places for file, places in found.items() if places}


NUMBERS = {"ulna.kernels.planning.layout": {"CHECKS", "UNTIL"}}


@pytest.mark.parametrize(
    ("source", "n"),
    [
        ("from ulna.kernels.planning.layout import CHECKS\nstate[CHECKS] += 1", 1),
        ("from ulna.kernels.planning.layout import CHECKS as C\nstate[0, C], state[C + 1], state[C : C + 3]", 3),
        ("from ulna.kernels.planning import layout\nsearch.state[layout.CHECKS] = 0", 1),
        ("from ulna.kernels.planning.layout import CHECKS\nstate[CHECKS] = state[1]", 2),
        ("CHECKS, UNTIL = 0, 1\nstate[UNTIL] = 3", 1),
        ("CHECKS, UNTIL = range(2)\nstate[UNTIL] = 3", 1),
        ("from ulna.kernels.planning.layout import CHECKS\ntree.joints[3, CHECKS]", 0),
        ("CHECKS = 4\nq[0], state.checks, names[:CHECKS]", 0),
    ],
)
def test_a_numbered_place_is_found(source, n):
    assert len(numbered_in(ast.parse(source), NUMBERS)) == n


def trees():
    """The syntax trees of all files, by their paths below ``src/ulna``."""
    return {path.relative_to(SOURCES).as_posix(): ast.parse(path.read_text()) for path in SOURCES.rglob("*.py")}


def test_a_scene_is_built_in_one_place_and_passed_whole():
    """A launch of a GPU takes no None, so that there a scene of boxes is built of one with tables without rows."""
    nodes = [(file, node) for file, tree in trees().items() for node in ast.walk(tree)]
    scenes = {file for file, tree in trees().items() if "from ulna.kernels.collision.scene import" in ast.unparse(tree)}
    built = {file for file, node in nodes if isinstance(node, ast.Call) and ast.unparse(node.func) == "Scene" and file in scenes}
    assert built == {"collision/bodies.py", "gpu/collision.py"}
    assert not [file for file, node in nodes if isinstance(node, ast.Starred) and last_part(node.value) == "scene"]


def test_an_entry_has_at_most_eight_parameters():
    functions = [node for tree in trees().values() for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    entries = [each for each in functions if any("entry(" in ast.unparse(mark) for mark in each.decorator_list)]
    assert len(entries) > 30
    assert [each.name for each in entries if len(each.args.args) > 8] == []
