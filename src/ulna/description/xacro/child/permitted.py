"""Lists what an expression may consist of and call: checked before anything is computed."""

import ast
import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import xacro

from ulna.description.xacro.child.parent import RefusedError

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


def _words(text: str) -> set[str]:
    return set(text.split())


_PLAIN = _words(
    "list dict map len str float int bool min max round sorted range abs all any complex divmod enumerate filter frozenset"
    " isinstance ord repr reversed set sum tuple zip"
)
_OF_XACRO = _words("load_yaml abs_filename dotify arg message warning error print_location fatal tokenize")
_OF_TEXTS = _words(
    "split rsplit splitlines join lower upper title capitalize strip lstrip rstrip startswith endswith find rfind index count"
    " replace zfill partition rpartition removeprefix removesuffix isdigit isalpha isalnum isnumeric"
)  # not `format`, which reads attributes
_OF_DICTS, _OF_LISTS = _words("items keys values get"), _words("index count")
_METHODS: dict[type, tuple[type, set[str]]] = {
    str: (str, _OF_TEXTS),
    dict: (dict, _OF_DICTS),
    xacro.YamlDictWrapper: (dict, _OF_DICTS),
    list: (list, _OF_LISTS),
    xacro.YamlListWrapper: (list, _OF_LISTS),
    tuple: (tuple, _OF_LISTS),
}
_offered: dict[int, Any] = {}  # by identity; the values are kept, so that no other takes their identity


def offered(value: Any) -> bool:
    """Whether a value is a function that expressions may call."""
    return id(value) in _offered


def offer(function: Callable) -> Callable:
    """Let expressions call a function."""
    _offered[id(function)] = function
    return function


def method_of(value: Any, name: str) -> Callable | None:
    """A method of a text, a dict, a list or a tuple; None for any other. It is that of Python's own type."""
    plain, names = _METHODS.get(type(value), (object, set()))
    return partial(getattr(plain, name), value) if name in names else None


def offer_those_of_xacro(symbols: dict[str, Any]) -> None:
    """Offer the known ones of xacro's names, and take all other functions out."""
    mathematical = {name for name in vars(math) if not name.startswith("_")}
    _keep(symbols, _PLAIN | _OF_XACRO | mathematical)
    for namespace, known in (("python", _PLAIN), ("math", mathematical), ("xacro", _OF_XACRO)):
        _keep(symbols[namespace], known)


def _keep(table: dict[str, Any], known: set[str]) -> None:
    for name, value in list(table.items()):
        if callable(value) and name not in known:
            dict.pop(table, name)
        elif callable(value):
            offer(value)
