"""Declares records: named values that Python and machine code share.

A record is a class whose annotations are its fields, of type int, float, bool, or ``Annotated[NDArray[...], length]``::

    class Tally(Record):
        checks: int
        longest: float

Python makes records as an array, ``Tally.records(n)``, and passes that to an entry, whose signature has ``Array(Tally, 1)``. On
both sides ``tallies[0]`` is a record, not a copy, and ``tally.checks += 1`` writes to the array. An unknown field is an error: of
the compiler there, and in plain Python an ``AttributeError``.
"""

from collections.abc import Iterator
from operator import itemgetter
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Protocol,
    Self,
    TypeVar,
    cast,
    get_args,
    get_origin,
    get_type_hints,
    overload,
)

import numpy as np
from numpy.typing import NDArray

RecordT_co = TypeVar("RecordT_co", bound="Record", covariant=True)
_ELEMENTS = {int: np.int64, float: np.float64, bool: np.bool_}


class Records(Protocol[RecordT_co]):
    """An array of records, shape (n,), for the type checker; it is a plain NumPy array, which is passed fastest."""

    @overload
    def __getitem__(self, key: int, /) -> RecordT_co: ...
    @overload
    def __getitem__(self, key: str, /) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: slice | list[bool], /) -> "Records[RecordT_co]": ...
    def __setitem__(self, key: str, value: Any, /) -> None: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[RecordT_co]: ...
    def copy(self) -> "Records[RecordT_co]":
        """A copy, which may be written to."""
        ...

    def item(self) -> tuple[Any, ...]:
        """The fields of the only record, as plain numbers in the order of their declaration."""
        ...

    def setflags(self, *, write: bool) -> None:
        """Make it writable, or read-only."""
        ...


class Record(np.void):
    """The base class of records.

    Attributes:
        structure: The type of an array of such records. All fields are aligned, so that machine code reads them directly.
    """

    __slots__ = ()
    structure: ClassVar[np.dtype[np.void]]

    def __init_subclass__(cls) -> None:
        hints = get_type_hints(cls, include_extras=True)
        fields = [(name, *_element_of(hint)) for name, hint in hints.items() if get_origin(hint) is not ClassVar]
        for name, *_ in fields:
            if hasattr(np.void, name):
                raise TypeError(f"{cls.__name__}.{name}: NumPy has this name for what every record has")
            setattr(cls, name, property(itemgetter(name)))
        cls.structure = np.dtype((cls, np.dtype(fields, align=True)))

    if not TYPE_CHECKING:  # the type checker would accept any name

        def __setattr__(self, name, value):
            if name not in type(self).structure.names:
                raise AttributeError(f"{type(self).__name__} has no field {name!r}")
            self[name] = value

    @classmethod
    def records(cls, n: int = 1) -> Records[Self]:
        """An array of n records, shape (n,), whose fields are zero."""
        return cast("Records[Self]", np.zeros(n, cls.structure))


def copied(records: Records[RecordT_co]) -> Records[RecordT_co]:
    """A writable copy of records; NumPy's own ``copy`` takes three times as long for a type with fields."""
    array: Any = records
    copy: Any = np.ndarray(array.shape, array.dtype, bytearray(array.tobytes()))
    return copy


def replaced(records: Records[RecordT_co], **values: Any) -> Records[RecordT_co]:
    """A read-only copy of one record, shape (1,), with other values; entries declare constant settings."""
    copy = copied(records)
    for name, value in values.items():
        copy[name] = value
    copy.setflags(write=False)
    return copy


def _element_of(hint: Any) -> tuple[Any, ...]:
    """The type of a field's numbers, and its shape if it is an array."""
    if get_origin(hint) is not Annotated:
        return (_ELEMENTS[hint],)
    array, length = get_args(hint)
    (*_, element) = get_args(array)  # the type of the numbers from NumPy 2.5 on, np.dtype of it before
    return (get_args(element) or (element,))[0], (length,)
