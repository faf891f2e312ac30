"""From a method of ``Robot`` to the formula by "go to definition", as an editor does it: pyright's language server is asked."""

import ast
import json
import subprocess
import sys
from itertools import count
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "src" / "ulna"
SERVER = Path(sys.executable).with_name("pyright-langserver")
pytestmark = pytest.mark.compiler  # a wheel is tested in an environment without pyright

# By method: the names to click on, each in what the one before has led to, and the file of the formula.
WALKS = {
    "forward_kinematics": ("of CompiledForward forward_one chain_pose", "kernels/chain/poses.py"),
    "jacobian": ("of CompiledJacobian jacobian_one chain_jacobian", "kernels/chain/jacobian.py"),
    "in_collision": ("in_collision overlaps overlap_one overlaps_unindexed", "kernels/collision/overlap.py"),
    "signed_distance": ("signed_distance min_distance nearest_batch nearest_unindexed", "kernels/collision/nearest.py"),
    "inverse_kinematics": (
        "inverse_kinematics _solver _solver_for solver_of NumericSolver search_one run_jobs advance",
        "kernels/ik/levenberg_marquardt.py",
    ),
}


class Editor:
    """Asks the language server for definitions."""

    def __init__(self):
        self._server = subprocess.Popen([SERVER, "--stdio"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._numbers, self._opened = count(1), set()
        folder = SOURCES.parents[1].as_uri()
        folders = [{"uri": folder, "name": "ulna"}]
        self._ask("initialize", processId=None, rootUri=folder, capabilities={}, workspaceFolders=folders)
        self._send("initialized", params={})

    def definition(self, file, line, column):
        """The file and the line, from 1 on, of the definition of what stands at a place; of an attribute its assignment."""
        if file not in self._opened:
            self._opened.add(file)
            document = {"uri": file.as_uri(), "languageId": "python", "version": 1, "text": file.read_text(encoding="utf-8")}
            self._send("textDocument/didOpen", params={"textDocument": document})
        place = {"line": line - 1, "character": column}
        found = self._ask("textDocument/definition", textDocument={"uri": file.as_uri()}, position=place)
        assert found, f"{file}:{line}: nothing is found"
        last = found[-1]  # before it is a mention in __slots__
        return Path(last["uri"].removeprefix("file://")), last["range"]["start"]["line"] + 1

    def close(self):
        self._server.kill()
        self._server.communicate()

    def _ask(self, method, **params):
        number = next(self._numbers)
        self._send(method, id=number, params=params)
        while True:
            message = self._receive()
            if message.get("id") == number and "method" not in message:
                return message["result"]
            if "id" in message:  # what the server asks: for settings, of which there are none
                self._send(None, id=message["id"], result=[{} for _ in message["params"].get("items", ())])

    def _send(self, method, **rest):
        text = json.dumps({"jsonrpc": "2.0", **({"method": method} if method else {}), **rest}).encode()
        self._server.stdin.write(b"Content-Length: %d\r\n\r\n%b" % (len(text), text))
        self._server.stdin.flush()

    def _receive(self):
        length = 0
        while header := self._server.stdout.readline().strip():
            if header.startswith(b"Content-Length:"):
                length = int(header.split(b":")[1])
        return json.loads(self._server.stdout.read(length))


@pytest.fixture(scope="module")
def editor():
    editor = Editor()
    yield editor
    editor.close()


def place_of(file, line, name):
    """Where a name first stands in the function, the class or the statement that begins in a line."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    begin = [node for node in ast.walk(tree) if isinstance(node, ast.stmt) and node.lineno == line]
    assert begin, f"{file}:{line}: nothing begins here"
    named = [node for node in ast.walk(begin[0]) if getattr(node, "id", getattr(node, "attr", None)) == name]
    assert named, f"{name} does not stand in what begins at {file}:{line}"
    first = min(named, key=lambda node: (node.end_lineno, node.end_col_offset))
    return first.end_lineno, first.end_col_offset - 1


def line_of(file, name):
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return next(node.lineno for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == name)


@pytest.mark.process
@pytest.mark.parametrize("method", WALKS)
def test_a_method_leads_to_its_formula(method, editor):
    names, formula = WALKS[method]
    file = SOURCES / "robot" / "robot.py"
    line = line_of(file, method)
    for name in names.split():
        file, line = editor.definition(file, *place_of(file, line, name))
    assert file.relative_to(SOURCES).as_posix() == formula


def test_no_dict_makes_what_it_lacks():
    """Tools do not follow ``__missing__``."""
    for file in SOURCES.rglob("*.py"):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        assert not [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == "__missing__"], file
