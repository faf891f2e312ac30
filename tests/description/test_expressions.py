"""The values of xacro expressions: as Python computes them, and for xacro's own dictionaries, lists and namespaces."""

import builtins
import math

import pytest
import xacro

from ulna.description.xacro.child.expressions import evaluate, offer_those_of_xacro
from ulna.description.xacro.child.parent import RefusedError

NAMES = {"a": 2, "b": 0.5, "s": "left arm", "xs": [3, 1, 2], "d": {"k": "v", "n": 1}, "t": (1, 2), "yes": True, "none": None}
EXPRESSIONS = [
    "1",
    "-1.5e-3",
    "'text'",
    "a",
    "True",
    "None",
    "1j * 1j",
    "(1, 2, 'x')",
    "[1, [2]]",
    "(1,)",
    "()",
    "dict(k=1)",
    "a if yes else b",
    "a + b * 3 - 1 / 4",
    "7 // 2",
    "-7 % 3",
    "2 ** -1",
    "-2 ** 2",
    "1 << 3 | 1 & 3 ^ 2",
    "6 >> 1",
    "~a",
    "not a",
    "+b",
    "- -a",
    "1 < a < 3",
    "1 < a > 3",
    "3 < a < 1 / 0",
    "a == 2 != b",
    "a <= 2 >= 1",
    "a in xs",
    "a not in xs",
    "none is None",
    "a is not None",
    "a and b",
    "0 and 1 / 0",
    "none or s",
    "a or 1 / 0",
    "'' or 0 or []",
    "1 and 2 and 3",
    "xs[0]",
    "xs[-1]",
    "xs[1:]",
    "xs[::-1]",
    "s[2:4]",
    "d['k']",
    "t[1]",
    "xs[a - 1]",
    "xs[:a]",
    "len(xs)",
    "max(xs)",
    "min(3, 1)",
    "max(xs, key=str)",
    "round(2.567, 1)",
    "str(1.0)",
    "int('7')",
    "float('1e-3')",
    "bool('')",
    "list(t)",
    "sorted(xs)",
    "sorted(xs, reverse=True)",
    "list(map(str, xs))",
    "list(range(3))",
    "python.abs(-1)",
    "python.sum(xs)",
    "python.tuple(xs)",
    "s.split()",
    "s.split(' ')",
    "'-'.join(s.split())",
    "s.upper().lower()",
    "s.startswith('le')",
    "s.replace('l', 'r')",
    "' a '.strip()",
    "list(d.items())",
    "list(d.keys())",
    "d.get('z', 5)",
    "xs.index(1)",
    "'%s_%d' % (s, a)",
    "'%(k)s' % d",
    "'a' * 3",
    "'a' 'b'",
    "sin(pi / 2)",
    "radians(180)",
    "atan2(1, 1)",
    "math.pi",
    "math.sqrt(4)",
    "math.floor(2.5)",
    "python.isinstance(s, str)",
    "[x + a for x in xs]",
    "[x for x in xs if x > 1 if x < 3]",
    "[k + str(v) for k, v in d.items()]",
    "[(x, y) for x in xs for y in range(x) if x != y]",
    "[[y for y in range(x)] for x in xs]",
    "[a for a in xs] + [a]",
    "[c for c in 'ab']",
    "python.any([c in s for c in ',; '])",
    "dict([(k.upper(), v) for k, v in d.items()])",
]


def lookup():
    symbols = xacro.create_global_symbols()
    offer_those_of_xacro(symbols)
    return xacro.Table(symbols | NAMES).__getitem__


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_an_expression_has_the_value_that_python_computes(text):
    expected = eval(text, {**vars(math), "math": math, "python": builtins, **NAMES})  # noqa: S307 - our own texts
    value = evaluate(text, lookup())
    assert (type(value), value) == (type(expected), expected)


@pytest.mark.parametrize(
    "text",
    [
        "1 / 0",
        "xs[9]",
        "d['z']",
        "unknown",
        "int('x')",
        "'a' + 1",
        "1 +",
        "a.b.",
        "(" * 300,
        "[x for x in a]",
        "[1 for x, y in xs]",
    ],
)
def test_an_error_has_the_type_that_python_raises(text):
    with pytest.raises(Exception) as expected:
        eval(text, {}, dict(NAMES))  # noqa: S307
    with pytest.raises(type(expected.value)):
        evaluate(text, lookup())


def test_keys_of_yaml_are_read_as_attributes_as_in_xacro():
    names = {"c": xacro.YamlDictWrapper({"joint": {"limits": [{"upper": 2}], "items": 1}})}
    assert evaluate("c.joint.limits[0].upper", names.__getitem__) == 2
    assert evaluate("c['joint'].limits[0]['upper']", names.__getitem__) == 2
    with pytest.raises(AttributeError, match="no key 'lower'"):
        evaluate("c.lower", names.__getitem__)
    with pytest.raises(RefusedError):
        evaluate("d.k", NAMES.__getitem__)


def test_names_of_an_included_namespace_are_read_as_attributes():
    namespace = xacro.NameSpace(parent=xacro.Table({}))
    namespace["width"] = "0.5"
    assert evaluate("box.width * 2", {"box": namespace}.__getitem__) == 1.0
    with pytest.raises(NameError, match="'depth' is not defined"):
        evaluate("box.depth", {"box": namespace}.__getitem__)


def test_only_allowed_functions_can_be_called():
    symbols = {**xacro.create_global_symbols(), "stranger": lambda: 1}
    offer_those_of_xacro(symbols)
    assert "stranger" not in symbols
    for text in ("f()", "list(map(f, [1]))", "sorted([1], key=f)"):
        with pytest.raises(RefusedError, match=r"not a function of expressions|passes on a function"):
            evaluate(text, {**symbols, "f": print}.__getitem__)
