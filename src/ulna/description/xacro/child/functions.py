"""Lists the functions and methods that an expression may call.

Of what xacro offers, these only compute.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import xacro


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
