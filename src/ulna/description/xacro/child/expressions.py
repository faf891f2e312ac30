"""Computes the expressions of a xacro document from their syntax tree.

It supports literals, names, arithmetic, comparisons, ``and``, ``or``, ``not``, ``a if b else c``, subscripts, lists and their
comprehensions, tuples, dicts, and calls of the functions and methods of ``functions``. An attribute is an entry of a YAML
dictionary or of a namespace, never an attribute of a Python object. Everything else is refused before anything is computed.
"""

import ast
import operator
from collections.abc import Callable, Iterator
from typing import Any

import xacro

from ulna.description.xacro.child.parent import RefusedError
from ulna.description.xacro.child.permitted import checked, method_of, offered

Lookup = Callable[[str], Any]
"""From a name to its value; a ``KeyError`` if it has none."""
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
        RefusedError: It has a part that is not known here, or calls what is not offered.
        SyntaxError, NameError, Exception: As Python raises them.
    """
    return _value(checked(text.strip()), lookup)


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
    """For each item that passes the conditions, the lookup that finds its names too."""
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
    """``config.joint`` for ``config["joint"]``, as xacro has it for what YAML gives and for namespaces."""
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
    """The function of a name or of a namespace, or the method of a text, a dict, a list or a tuple."""
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
