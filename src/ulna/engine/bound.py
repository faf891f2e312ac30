"""Binds an entry's leading arguments (partial application), in C where there is the extension, and puts methods in C in a class.

The extension comes with a wheel (``ahead``). Without it there are no functions in C, and callers go Python's own way.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from ulna.engine.ahead import extension
from ulna.engine.signatures import fits

if TYPE_CHECKING or extension() is None:

    class Quick:
        """What a robot inherits: in C, it has a place for each table of prebound entries (``native/bases.h``)."""

        __slots__ = ()

        def _keep_prebound(
            self, forward: dict[Any, Any], jacobian: dict[Any, Any], scene: list[tuple[Any, ...]], searches: dict[Any, tuple],
            solutions: dict[Any, tuple],
        ) -> None:  # fmt: skip
            """Let the methods in C read some tables, and what is added to them later.

            Args:
                forward: By link: the pose, a function made by ``bind``.
                jacobian: By link: the Jacobian in the frame "base", a function made by ``bind``.
                scene: One tuple: the objects of the last scene (None without a world), whether the robot itself is checked, and
                    in this scene ``in_collision``, ``signed_distance`` and, with the class and the resolution of its reports,
                    ``edge_in_collision``, or None where that was not called yet.
                searches: By link: the parts of ``inverse_kinematics`` with default options (``native/method.c``).
                solutions: By link: the parts of ``all_solutions`` with default options.
            """

    class Called:
        """What a function of q inherits: in C, its call goes to ``in_c``, or else to ``_validated``."""

        __slots__ = ("in_c",)
        in_c: Callable[..., Any] | None
        """A bound function, or None."""

    class Seen:
        """What a world inherits: in C, methods of a robot read its ``_objects``, or call ``objects()`` while these are None.

        Where these have the ``layout`` of the last scene's, its entries are called with their rows, ``first`` to before ``end``.
        """

        __slots__ = ("_objects",)

else:
    Quick, Called, Seen = extension().Quick, extension().Called, extension().Seen


Way = Literal["pose", "truth", "number", "edge", "copy", "search", "branches"]
"""What a bound function takes and returns (native/ways.c).

``pose``: ``f(q, out=None)``, an array of the shape ``numbers``. ``truth``: ``f(q)``, False or True for the two
codes in ``numbers``. ``number``: ``f(q)``, the number that the result's record begins with. ``edge``: ``f(q_a, q_b,
resolution)``, False or True for the two codes in ``numbers``, how far it is free, and q there. ``copy``: ``f(T)``, an array of
the shape ``numbers``, which T has too. ``search``: ``f(target, seed)``, q and a record about it in an array, or None if there
is no solution. ``branches``: ``f(target)``, q of shape (``numbers[0]``, n), which of them are within the limits, which are
real, and a code below ``numbers[1]``; or None.
"""


def bind(
    entry: Callable[..., Any],
    way: Way,
    leading: tuple,
    n: int,
    numbers: tuple[int, ...],
    otherwise: Callable[..., Any],
    like: Any = None,
) -> Callable[..., Any] | None:
    """A function of one q of ``n`` entries that calls an entry; None where there is no extension, or Python runs the entry.

    Args:
        entry: An entry of the drivers.
        way: What the function takes and returns.
        leading: The arguments of the entry that come before q; they must not be resized while the function is used.
        n: The number of entries of q, at least 1.
        numbers: Of the way.
        otherwise: Called with the same arguments where q is no array as the machine code takes it, or is refused by it.
        like: For ``search`` and ``number``: an array of the record that is written.
    """
    calls = extension() if n >= 1 else None
    if calls is None:
        return None
    if not isinstance(getattr(entry, "__self__", None), calls.Entry):
        entry = _compiled_now(entry, leading, calls)
    return None if entry is None else calls.bind(entry, way, leading, n, numbers, otherwise, like)


_machine_code: dict[tuple[Any, int], Callable[..., Any]] = {}
"""By entry and number of a signature: what is called for it."""


def bind_first(entry: Callable[..., Any], number: int, *leading: Any) -> Callable[..., Any]:
    """An entry whose first arguments are given: Python looks at their types once, and not at each call.

    Where Numba has compiled the entry, nothing looks at the types of the others either: they have to be those of the signature.

    Args:
        entry: An entry of the drivers.
        number: Of its signature that has these types, from 0 on.
        leading: Its first arguments.

    Raises:
        NotCompiledError: It is not compiled yet, and this thread may not compile now.
    """
    function = _machine_code.get((entry, number))
    if function is None:
        function = _machine_code[entry, number] = _called_directly(entry, number, leading)
    return partial(function, *leading)


def _called_directly(entry: Any, number: int, leading: tuple) -> Callable[..., Any]:
    """What Numba has compiled of an entry for a signature; the entry itself in plain Python, and where the extension calls it."""
    if not hasattr(entry, "overloads"):
        return entry
    from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - the compiler is loaded where there is such an entry
    from ulna.engine.native import compiled_for  # noqa: PLC0415 - as above

    signature = ENTRIES[entry].signatures[number]
    if not all(map(fits, leading, signature)):
        raise TypeError(f"{ENTRIES[entry].name}: the first arguments have other types than its signature {number}")
    return compiled_for(entry, signature).entry_point


def call_in_c(of: type[Called]) -> None:
    """Let objects of a class be called in C, where there is the extension, and no longer by its ``__call__``."""
    if extension() is not None:
        del of.__call__


def put_in_c(of: type[Quick], names: tuple[str, ...]) -> None:
    """Put methods in C in the place of methods of a class, where there is the extension; it calls these where it must.

    Each of them looks up the prebound entry for its arguments in a table of ``Quick``, and calls it.
    """
    calls = extension()
    if calls is None:
        return
    from inspect import signature  # noqa: PLC0415 - a clone does not need it

    for name in names:
        function = vars(of)[name]
        plain = [each.replace(annotation=each.empty) for each in signature(function).parameters.values()]
        shown = str(signature(function).replace(parameters=plain, return_annotation=signature(function).empty))
        text = f"{name}{shown.replace('(self', '($self', 1)}\n--\n\n{function.__doc__}"
        setattr(of, name, calls.make_method(of, name, function, text))


def _compiled_now(entry: Any, leading: tuple, calls: Any) -> Any:
    """An entry of the extension for what Numba has compiled of an entry; None if nothing that takes these arguments."""
    if not hasattr(entry, "overloads"):
        return None
    from ulna.engine.native import native_entry  # noqa: PLC0415 - the compiler is loaded where there is such an entry

    return native_entry(entry, leading, calls)
