"""Checks the syntax of expressions before anything is computed."""

import ast
from functools import lru_cache

from ulna.description.xacro.child.refused import RefusedError

KNOWN = (
    *(ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.List, ast.Tuple, ast.Dict, ast.Call, ast.keyword),
    *(ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.operator, ast.unaryop, ast.boolop, ast.cmpop, ast.Load),
    *(ast.ListComp, ast.comprehension, ast.Store),
)
_WORDS = {ast.GeneratorExp: "a generator", ast.Lambda: "a lambda", ast.JoinedStr: "an f-string"}
_LITERALS = (str, int, float, complex, type(None))  # bool is an int


@lru_cache(maxsize=4096)
def checked(text: str) -> ast.expr:
    """The syntax tree of an expression that consists of known parts only.

    Raises:
        RefusedError: It has a part that is not known, such as a lambda.
        SyntaxError: It is not an expression.
    """
    tree = ast.parse(text, "<expression>", "eval").body
    for node in ast.walk(tree):
        if not isinstance(node, KNOWN) or isinstance(node, ast.MatMult):
            raise RefusedError(f"uses {_WORDS.get(type(node), type(node).__name__)}, which is not known in expressions: {text}")
        _check_names(node)
        if isinstance(node, ast.comprehension):
            _check_target(node)
    return tree


def _check_names(node: ast.AST) -> None:
    """No name of Python's own. Python has turned look-alikes (NFKC) into plain letters by now."""
    if isinstance(node, ast.Name) and node.id.startswith("__"):
        raise RefusedError(f"uses the invalid name {node.id}")
    if isinstance(node, ast.Attribute) and node.attr.startswith("_"):
        raise RefusedError(f"uses the invalid name {node.attr}")
    if isinstance(node, ast.keyword) and node.arg is None:
        raise RefusedError("uses '**', which is not known in expressions")
    if isinstance(node, ast.Dict) and None in node.keys:
        raise RefusedError("uses '**', which is not known in expressions")
    if isinstance(node, ast.Constant) and not isinstance(node.value, _LITERALS):
        raise RefusedError(f"uses {node.value!r}, which is neither a number nor a text")


def _check_target(node: ast.comprehension) -> None:
    """What runs through a list is a name, or names that take the parts of each item."""
    names = node.target.elts if isinstance(node.target, ast.Tuple) else [node.target]
    if node.is_async or not all(isinstance(name, ast.Name) for name in names):
        raise RefusedError("a comprehension runs through something that is not a name")
