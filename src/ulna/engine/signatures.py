"""Defines the types of entries' arguments. All arrays are C-contiguous.

They are described without the compiler: code compiled ahead is found by the same description.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import wraps
from typing import Any, NamedTuple

import numpy as np

from ulna.engine.records import Record


class Scalar(NamedTuple):
    """A plain number, by the name of its type; ``none`` is the type of ``None``."""

    name: str

    def __str__(self) -> str:
        return {"int64": "i", "float64": "d", "none": "-"}[self.name]


class Array(NamedTuple):
    """An array with ``dimensions`` axes; a ``constant`` one is only read, so that it may be read-only.

    element: the name of its elements' type, or the class of its records.
    """

    element: str | type[Record]
    dimensions: int
    constant: bool = False

    @property
    def dtype(self) -> np.dtype[Any]:
        """The NumPy type of its elements."""
        return np.dtype(self.element) if isinstance(self.element, str) else self.element.structure

    def __str__(self) -> str:
        code = _CODES[self.element] if isinstance(self.element, str) else f"[{self.element.__name__} {self.dtype.itemsize}]"
        return f"{self.dimensions}{'r' if self.constant else 'w'}{code}"


class Group(NamedTuple):
    """A tuple of arguments, or a named tuple of the class ``of``: an argument that is passed whole."""

    parts: tuple[Scalar | Array, ...]
    of: type[tuple] = tuple

    def __str__(self) -> str:
        return f"({''.join(map(str, self.parts))})"


Kind = Scalar | Array | Group
Signature = Sequence[Kind]
_CODES = {"float64": "d", "int64": "i", "bool": "b", "int32": "h", "float32": "f", "uint8": "u"}


def fits(value: object, kind: Kind) -> bool:
    """Whether an entry accepts a value's type without conversion."""
    if isinstance(kind, Group):
        return type(value) is kind.of and len(value) == len(kind.parts) and all(map(fits, value, kind.parts))
    if isinstance(kind, Scalar):
        types = {"int64": (int, np.int64), "float64": float, "none": type(None)}[kind.name]
        return isinstance(value, types) and not isinstance(value, bool)
    return (
        type(value) is np.ndarray
        and value.dtype == kind.dtype
        and value.dtype.isnative
        and value.ndim == kind.dimensions
        and value.flags.c_contiguous
        and value.flags.aligned
        and (value.flags.writeable or kind.constant)
    )


def parts_of(signature: Signature) -> Iterator[Scalar | Array]:
    """All parts of a signature, with tuples split into their parts."""
    for kind in signature:
        yield from kind.parts if isinstance(kind, Group) else (kind,)


def checked(function: Callable, signature: Signature) -> Callable:
    """Wrap a function of plain Python to refuse arguments of other types, like a compiled one."""

    @wraps(function)
    def checked_function(*arguments):
        for argument, kind in zip(arguments, signature, strict=True):
            if not fits(argument, kind):
                raise TypeError(f"{type(argument).__name__}, but {kind} is expected")
        return function(*arguments)

    return checked_function


def text_of_signature(signature: Signature) -> str:
    """A signature as one word, such as ``2wdi1wd2wd``: the key of machine code in ``ahead`` and in the extension."""
    return "".join(map(str, signature))


WHOLE, NUMBER, NONE = Scalar("int64"), Scalar("float64"), Scalar("none")
NUMBERS, MATRIX, MATRICES, BLOCKS = (Array("float64", dimensions) for dimensions in (1, 2, 3, 4))
INDICES, INDEX_ROWS = Array("int64", 1), Array("int64", 2)
TRUTHS, TRUTH_ROWS = Array("bool", 1), Array("bool", 2)
# Pictures: the triangle behind each sample and its nearness, the light of each pixel, and its colors.
NUMBERED, NEARNESS, LIGHT, PIXELS = Array("int32", 2), Array("float32", 2), Array("float32", 3), Array("uint8", 3)
SKIN = Group((MATRIX, MATRIX, NUMBERS, INDICES))
# A robot's tables, which are read-only.
CONSTANTS, TABLE = Array("float64", 1, constant=True), Array("float64", 2, constant=True)
POINTS, POINTS_32 = TABLE, Array("float32", 2, constant=True)  # of a cloud, as a sensor gives them
PAIRS, TRUTH_TABLE = Array("int64", 2, constant=True), Array("bool", 2, constant=True)
