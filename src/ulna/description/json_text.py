"""Reads JSON of a stranger, which may be nested deeply."""

import json
from typing import Any

_MOST_LEVELS = 50  # of lists in lists: our own files have about ten; Python's recursion ends near a thousand


def json_value(text: str | bytes, **options: Any) -> Any:
    """The value of a JSON text.

    Args:
        text: The text.
        **options: Those of ``json.loads``.

    Raises:
        ValueError: It is not JSON, or has more levels than are read.
    """
    try:
        value = json.loads(text, **options)
    except RecursionError:
        raise ValueError(f"it has more than {_MOST_LEVELS} levels") from None
    level, n_levels = [value], 0
    while level:
        level = [inner for outer in level for inner in _inside(outer) if isinstance(inner, (dict, list))]
        n_levels += 1
        if n_levels > _MOST_LEVELS:
            raise ValueError(f"it has more than {_MOST_LEVELS} levels")
    return value


def _inside(value: Any) -> Any:
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
