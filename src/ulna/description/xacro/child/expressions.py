"""Computes the expressions of a xacro document from their syntax tree.

It supports literals, names, arithmetic, comparisons, ``and``, ``or``, ``not``, ``a if b else c``, subscripts, lists, list
comprehensions, tuples and dicts. It calls offered functions, and methods of texts, dicts, lists and tuples. An attribute is an
entry of a YAML dictionary or of a namespace, never an attribute of a Python object. Everything else is refused before anything is
computed.
"""

import ast
import math
import operator
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from typing import Any

import xacro

from ulna.description.xacro.child.parent import RefusedError

Lookup = Callable[[str], Any]
"""Maps a name to its value; raises ``KeyError`` for an unknown name."""
_WORDS = {ast.GeneratorExp: "a generator", ast.Lambda: "a lambda", ast.JoinedStr: "an f-string"}
_LITERALS = (str, int, float, complex, type(None))  # bool is an int
_OPERATORS: dict[type, Callable] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
    ast.Not: operator.not_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda item, container: item in container,
    ast.NotIn: lambda item, container: item not in container,
}


def evaluate(text: str, lookup: Lookup) -> Any:
    """The value of an expression.

    Raises:
        RefusedError: It has an unsupported part, or calls a function that is not offered.
        SyntaxError, NameError, Exception: As Python raises them.
    """
    return _value(_checked(text.strip()), lookup)


def _value(node: ast.AST, lookup: Lookup) -> Any:
    return _RULES[type(node)](node, lookup)


def _name(node: ast.Name, lookup: Lookup) -> Any:
    try:
        return lookup(node.id)
    except KeyError:
        raise NameError(f"name {node.id!r} is not defined") from None


def _logic(node: ast.BoolOp, lookup: Lookup) -> Any:
    ends = isinstance(node.op, ast.Or)
    value = None
    for part in node.values:
        value = _value(part, lookup)
        if bool(value) is ends:
            break
    return value


def _comparison(node: ast.Compare, lookup: Lookup) -> Any:
    left, holds = _value(node.left, lookup), True
    for kind, part in zip(node.ops, node.comparators, strict=True):
        right = _value(part, lookup)
        holds = _OPERATORS[type(kind)](left, right)
        if not holds:
            break
        left = right
    return holds


def _dictionary(node: ast.Dict, lookup: Lookup) -> dict:
    keys = [_value(key, lookup) for key in node.keys if key is not None]
    return dict(zip(keys, [_value(value, lookup) for value in node.values], strict=True))


def _list_of(node: ast.ListComp, lookup: Lookup) -> list:
    return [_value(node.elt, names) for names in _lookups(node.generators, lookup)]


def _lookups(generators: list[ast.comprehension], lookup: Lookup) -> Iterator[Lookup]:
    """For each item that passes the conditions, the lookup that includes its names."""
    if not generators:
        yield lookup
        return
    first, *others = generators
    for item in _value(first.iter, lookup):
        names = _with_item(first.target, item, lookup)
        if all(_value(condition, names) for condition in first.ifs):
            yield from _lookups(others, names)


def _with_item(target: ast.expr, item: Any, lookup: Lookup) -> Lookup:
    if isinstance(target, ast.Tuple):
        parts = list(item)
        if len(parts) != len(target.elts):
            raise ValueError(f"{len(parts)} values to unpack, but {len(target.elts)} names")
        values = {name.id: part for name, part in zip(target.elts, parts, strict=True) if isinstance(name, ast.Name)}
    else:
        values = {target.id: item} if isinstance(target, ast.Name) else {}
    return lambda name: values[name] if name in values else lookup(name)


def _entry(node: ast.Subscript, lookup: Lookup) -> Any:
    container = _value(node.value, lookup)
    if callable(container):
        raise RefusedError("subscripts a function")
    return container[_value(node.slice, lookup)]


def _slice(node: ast.Slice, lookup: Lookup) -> slice:
    return slice(*(None if part is None else _value(part, lookup) for part in (node.lower, node.upper, node.step)))


def _attribute(node: ast.Attribute, lookup: Lookup) -> Any:
    return _entry_by_name(_value(node.value, lookup), node.attr)


def _entry_by_name(container: Any, name: str) -> Any:
    """Evaluate ``config.joint`` as ``config["joint"]``, as xacro does for YAML values and namespaces."""
    if type(container) is xacro.NameSpace:
        try:
            return container[name]
        except KeyError:
            raise NameError(f"name {name!r} is not defined") from None
    if type(container) is xacro.YamlDictWrapper:
        return container[name]
    raise RefusedError(f"reads the attribute {name!r}, which only namespaces and what YAML gives have in expressions")


def _call(node: ast.Call, lookup: Lookup) -> Any:
    function = _callee(node.func, lookup)
    values = [_value(argument, lookup) for argument in node.args]
    named = {str(keyword.arg): _value(keyword.value, lookup) for keyword in node.keywords}
    for value in (*values, *named.values()):
        if callable(value) and not offered(value):
            raise RefusedError(f"passes on a function that is not offered, to {ast.unparse(node.func)}")
    return function(*values, **named)


def _callee(node: ast.expr, lookup: Lookup) -> Callable:
    """The function of a name or a namespace, or the method of a text, dict, list or tuple."""
    function = None
    if isinstance(node, ast.Name):
        function = _name(node, lookup)
    elif isinstance(node, ast.Attribute):
        of = _value(node.value, lookup)
        method = method_of(of, node.attr)
        if method is not None:
            return method
        function = _entry_by_name(of, node.attr) if type(of) is xacro.NameSpace else None
    if function is None or not offered(function):
        raise RefusedError(f"calls {ast.unparse(node)}, which is not a function of expressions")
    return function


_RULES: dict[type, Callable[[Any, Lookup], Any]] = {
    ast.Constant: lambda node, _: node.value,
    ast.Name: _name,
    ast.BinOp: lambda node, names: _OPERATORS[type(node.op)](_value(node.left, names), _value(node.right, names)),
    ast.UnaryOp: lambda node, names: _OPERATORS[type(node.op)](_value(node.operand, names)),
    ast.BoolOp: _logic,
    ast.Compare: _comparison,
    ast.IfExp: lambda node, names: _value(node.body if _value(node.test, names) else node.orelse, names),
    ast.List: lambda node, names: [_value(item, names) for item in node.elts],
    ast.Tuple: lambda node, names: tuple(_value(item, names) for item in node.elts),
    ast.Dict: _dictionary,
    ast.ListComp: _list_of,
    ast.Subscript: _entry,
    ast.Slice: _slice,
    ast.Attribute: _attribute,
    ast.Call: _call,
}
_KNOWN = {*_RULES, *_OPERATORS, ast.And, ast.Or, ast.Load, ast.Store, ast.comprehension, ast.keyword}


@lru_cache(maxsize=4096)
def _checked(text: str) -> ast.expr:
    """The syntax tree of an expression that consists of supported parts only."""
    tree = ast.parse(text, "<expression>", "eval").body
    for node in ast.walk(tree):
        if type(node) not in _KNOWN:
            raise RefusedError(f"uses {_WORDS.get(type(node), type(node).__name__)}, which is not known in expressions: {text}")
        _check_names(node)
        if isinstance(node, ast.comprehension):
            _check_target(node)
    return tree


def _check_names(node: ast.AST) -> None:
    """Refuse Python's own names. Python has already normalized look-alikes (NFKC) to plain letters."""
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
    """Check that the target of a comprehension is a name, or names for the parts of each item."""
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
_offered: dict[int, Any] = {}  # by identity; storing the values prevents that others get their identity


def offered(value: Any) -> bool:
    """Whether a value is a function that expressions may call."""
    return id(value) in _offered


def offer(function: Callable) -> Callable:
    """Let expressions call a function."""
    _offered[id(function)] = function
    return function


def method_of(value: Any, name: str) -> Callable | None:
    """A method of a text, dict, list or tuple, taken from Python's own type; None for any other value."""
    plain, names = _METHODS.get(type(value), (object, set()))
    return partial(getattr(plain, name), value) if name in names else None


def offer_those_of_xacro(symbols: dict[str, Any]) -> None:
    """Offer the supported functions among xacro's names, and remove all other functions."""
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
