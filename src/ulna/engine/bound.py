"""Binds an entry's leading arguments (partial application), in C if the extension is available.

The extension comes with a wheel (``ahead``). Without it a bound entry is a function in Python.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from ulna.engine.ahead import extension
from ulna.engine.signatures import fits

IN_C = extension() is not None
"""Whether the extension is available."""

if TYPE_CHECKING or not IN_C:

    class Bound:
        """An entry bound to its tables: a function of one q, or of one target.

        In a wheel it is in C (``native/bound.c``), and a call goes to machine code, or to ``otherwise``. Here, subclasses define
        their own ``__call__``.
        """

        __slots__ = ()

        def __init__(
            self,
            code: Callable[..., Any] | None,
            way: "Way",
            leading: tuple,
            n: int,
            numbers: tuple[int, ...],
            otherwise: Callable[..., Any],
            like: Any = None,
        ) -> None:
            """Store machine code from ``machine_code``, or None; the other arguments are those of ``bind``."""

        def __call__(self, *arguments: Any, **named: Any) -> Any:
            """Call the entry."""
            raise NotImplementedError

else:
    Bound = extension().Bound


Way = Literal["pose", "truth", "number", "edge", "copy", "search", "branches", "motion"]
"""The arguments and the result of a bound function (native/ways.c).

- ``pose``: ``f(q, out=None)``, an array of the shape ``numbers``.
- ``truth``: ``f(q, first, end)``, False or True for the two codes in ``numbers``.
- ``number``: ``f(q, first, end)``, the first number of the result's record.
- ``edge``: ``f(q_a, q_b, resolution, first, end)``, False or True for the two codes in ``numbers``, the free fraction, and q
  there.
- ``copy``: ``f(T)``, an array of the shape ``numbers``, which T has too.
- ``search``: ``f(target, seed)``, q and its record in an array, or None without a solution.
- ``motion``: ``f(q, qd, qdd)``, an array of ``numbers[0]`` numbers.
- ``branches``: ``f(target)``, q of shape (``numbers[0]``, n), whether each is within the limits, whether each is real, and a code
  below ``numbers[1]``; or None.

``first`` and ``end`` delimit the rows of a scene's objects.
"""


def bind(
    entry: Callable[..., Any],
    way: Way,
    leading: tuple,
    n: int,
    numbers: tuple[int, ...],
    otherwise: Callable[..., Any],
    like: Any = None,
) -> Callable[..., Any]:
    """A function of one q that calls an entry; ``otherwise`` without the extension, or if Python runs the entry.

    Args:
        entry: An entry.
        way: The arguments and the result of the function.
        leading: The arguments of the entry before q; they must not be resized while the function is used.
        n: The number of entries of q.
        numbers: The numbers of the way.
        otherwise: Called with the same arguments if q is not an array that the machine code accepts, or is refused by it.
        like: For ``search`` and ``number``: an array of the record that is written.
    """
    code = machine_code(entry, leading) if n else None
    return otherwise if code is None else Bound(code, way, leading, n, numbers, otherwise, like)


def machine_code(entry: Callable[..., Any], leading: tuple) -> Callable[..., Any] | None:
    """An entry for the extension; None without the extension, or without machine code for these first arguments."""
    calls = extension()
    if calls is None or isinstance(getattr(entry, "__self__", None), calls.Entry):
        return None if calls is None else entry
    if not hasattr(entry, "overloads"):
        return None
    from ulna.engine.native import native_entry  # noqa: PLC0415 - loads the compiler only for such an entry

    return native_entry(entry, leading, calls)


_machine_code: dict[tuple[Any, int], Callable[..., Any]] = {}
"""The function to call, by entry and index of a signature."""


def bind_first(entry: Callable[..., Any], number: int, *leading: Any) -> Callable[..., Any]:
    """Bind the first arguments of an entry: Python checks their types once, not at each call.

    If Numba has compiled the entry, the types of the other arguments are not checked either: they must match the signature.

    Args:
        entry: An entry.
        number: The index of its signature with these types.
        leading: Its first arguments.

    Raises:
        NotCompiledError: It is not compiled yet, and this thread may not compile now.
    """
    function = _machine_code.get((entry, number))
    if function is None:
        function = _machine_code[entry, number] = _called_directly(entry, number, leading)
    return partial(function, *leading)


def _called_directly(entry: Any, number: int, leading: tuple) -> Callable[..., Any]:
    """The machine code of an entry for a signature; the entry itself in plain Python, or with the extension."""
    if not hasattr(entry, "overloads"):
        return entry
    from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - loads the compiler only for such an entry
    from ulna.engine.native import compiled_for  # noqa: PLC0415 - as above

    signature = ENTRIES[entry].signatures[number]
    if not all(map(fits, leading, signature)):
        raise TypeError(f"{ENTRIES[entry].name}: the first arguments have other types than its signature {number}")
    return compiled_for(entry, signature).entry_point
