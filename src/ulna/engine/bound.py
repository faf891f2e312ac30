"""Binds an entry's leading arguments in C, so that a call with one q costs little. Used by what answers for one q or one target.

The extension comes with a wheel (``ahead``). Without it there are no such functions, and callers go Python's own way.
"""

from collections.abc import Callable
from typing import Any, Literal

Way = Literal["pose", "truth", "number", "search"]
"""What a bound function takes and returns (native/bound.c).

``pose``: ``f(q, out=None, threads=None)``, an array of the shape ``numbers``. ``truth``: ``f(q)``, False or True for the two
codes in ``numbers``. ``number``: ``f(q)``, the first of the result's ``numbers[0]`` numbers. ``search``: ``f(target, seed)``,
q and the ``numbers[0]`` numbers about it, or None if there is no solution.
"""


def bind(
    entry: Callable[..., Any], way: Way, leading: tuple, n: int, numbers: tuple[int, ...], otherwise: Callable[..., Any]
) -> Callable[..., Any] | None:
    """A function of one q of ``n`` entries that calls an entry; None where there is no extension, or Python runs the entry.

    Args:
        entry: As ``Entries.find`` has it.
        way: What the function takes and returns.
        leading: The arguments of the entry that come before q; they must not be resized while the function is used.
        n: The number of entries of q, at least 1.
        numbers: Of the way.
        otherwise: Called with the same arguments where q is no array as the machine code takes it, or is refused by it.
    """
    if n < 1:
        return None
    try:
        from ulna.engine import _calls  # noqa: PLC0415 # pyright: ignore[reportAttributeAccessIssue] - a clone has none
    except ImportError:
        return None
    if not isinstance(getattr(entry, "__self__", None), _calls.Entry):
        entry = _compiled_now(entry, leading, _calls)
    return None if entry is None else _calls.bind(entry, way, leading, n, numbers, otherwise)


def _compiled_now(entry: Any, leading: tuple, calls: Any) -> Any:
    """An entry of the extension for what Numba has compiled of an entry; None if nothing that takes these arguments."""
    if not hasattr(entry, "overloads"):
        return None
    from ulna.engine.native import native_entry  # noqa: PLC0415 - the compiler is loaded where there is such an entry

    return native_entry(entry, leading, calls)
