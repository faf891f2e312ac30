"""The public methods of the robot on a GPU, and the drivers that ``ulna.gpu`` launches, both read from the code itself."""

import ast
import inspect
from pathlib import Path

import ulna.gpu
from ulna.gpu.robot import GpuRobot


def public_methods():
    """The public methods of ``GpuRobot``, by name."""
    return {name: method for name, method in inspect.getmembers(GpuRobot, inspect.isfunction) if not name.startswith("_")}


def methods_with_out():
    return {name for name, method in public_methods().items() if "out" in inspect.signature(method).parameters}


def drivers_of_the_code():
    """The names of all drivers: of the functions ``..._of`` whose result is launched, and of the plain functions."""
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in Path(ulna.gpu.__file__).parent.glob("*.py")]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    factories = {node.name for node in nodes if isinstance(node, ast.FunctionDef) and is_factory(node)}
    given = [node.args[0] for node in nodes if isinstance(node, ast.Call) and node.args and name_of(node.func) == "compiled"]
    functions = {node.name for tree in trees for node in tree.body if isinstance(node, ast.FunctionDef)}
    return factories | ({each.id for each in given if isinstance(each, ast.Name)} & functions)


def is_factory(node):
    """Whether a function makes drivers: it is cached, and named after what they write."""
    return node.name.endswith("_of") and "cache" in map(name_of, node.decorator_list)


def name_of(node):
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", None)
