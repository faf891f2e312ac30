"""Compares the stated size of a file of numbers with limits, and with the file's length, before reading it.

A header of a few bytes can state an array of any size. Each function raises ValueError if a file states more than it contains, or
exceeds the limits.
"""

import ast
import math
import re
from typing import Any

import numpy as np

from ulna.errors import count_of

MAX_NUMBERS = 30_000_000  # of one file: 240 MB as an array
_MAX_LINES = 5_000_000  # of a text; each line is an object for a while
_MAX_HEAD = 1 << 16  # bytes of a header
_MAX_FIELDS = 256  # of a point or a vertex
_MAX_ELEMENTS = 20  # kinds of a .ply: vertices, faces, edges ...
_MAX_ROWS = 3_000_000  # of a .ply as text; trimesh makes an array of each row
_MAX_FACES = 4_000_000  # of a .ply
_SEPARATORS = (b"\n", b"\r", b" ", b",", b";", b"\t", b"\x0b", b"\x0c", b"\x1c", b"\x1d", b"\x1e")
_PLY_TYPES = {
    1: "char uchar int8 uint8",
    2: "short ushort int16 uint16",
    4: "int uint float int32 uint32 float32",
    8: "double float64",
}
_PLY_BYTES = {name: size for size, names in _PLY_TYPES.items() for name in names.split()}


def check_npy(content: bytes) -> None:
    """Check the header of a .npy file. Source: NumPy, numpy.lib.format, versions 1 to 3."""
    begin = 10 if content[6:7] == b"\x01" else 12
    if content[:6] != b"\x93NUMPY" or content[6:7] not in (b"\x01", b"\x02", b"\x03"):
        raise ValueError("it is not a .npy file of versions 1 to 3")
    end = begin + int.from_bytes(content[8:begin], "little")
    if end > min(_MAX_HEAD, len(content)):
        raise ValueError(f"its header has {end - begin} bytes; up to {_MAX_HEAD} are read, and not more than there are")
    try:
        head: Any = ast.literal_eval(content[begin:end].decode("utf-8" if content[6] == 3 else "latin-1").strip())
        kind, shape = np.lib.format.descr_to_dtype(head["descr"]), tuple(head["shape"])
    except (SyntaxError, ValueError, TypeError, KeyError, MemoryError, RecursionError, OverflowError):
        raise ValueError("its header cannot be read") from None
    if kind.hasobject:
        raise ValueError("it has Python objects, whose reading can run code; they are refused")
    if not all(isinstance(n, int) and n >= 0 for n in shape):
        raise ValueError("its shape is not one of whole numbers of at least 0")
    n = math.prod(shape)
    if (n and not kind.itemsize) or n * kind.itemsize > len(content) - end:
        stated = f"{count_of(n, 'entry', 'entries')} of {count_of(kind.itemsize, 'byte')}"
        rest = count_of(len(content) - end, "byte is", "bytes are")
        raise ValueError(f"its header states {stated}, of which {rest} there")
    if n * max(1, len(kind.names or ())) > MAX_NUMBERS:
        raise ValueError(f"it has {n} entries; up to {MAX_NUMBERS} numbers are read")


def check_text(content: bytes, max_numbers: int = MAX_NUMBERS) -> None:
    """Check a text of numbers, by counting its separators."""
    n_lines = content.count(b"\n") + content.count(b"\r")
    if n_lines > _MAX_LINES:
        raise ValueError(f"it has {n_lines} lines; up to {_MAX_LINES} are read")
    n = sum(content.count(separator) for separator in _SEPARATORS)
    if n > max_numbers:
        raise ValueError(f"it has {n} blanks, separators and ends of lines; up to {max_numbers} are read")


def check_pcd(content: bytes) -> None:
    """Check the header of a .pcd file, and the length of the data after it."""
    found = re.search(rb"^DATA +(\w+)\r?\n", content[:_MAX_HEAD], re.MULTILINE)
    if found is None:
        raise ValueError(f"it has no line DATA within its first {_MAX_HEAD} bytes")
    head = {words[0]: words[1:] for words in map(bytes.split, content[: found.start()].splitlines()) if words}
    for key in (b"FIELDS", b"SIZE", b"TYPE", b"COUNT"):
        if len(head.get(key, ())) > _MAX_FIELDS:
            raise ValueError(f"its line {key.decode()} has {len(head[key])} entries; up to {_MAX_FIELDS} are read")
    counts = [_whole(word, "COUNT") for word in head.get(b"COUNT", [b"1"] * len(head.get(b"FIELDS", ())))]
    sizes = [_whole(word, "SIZE") for word in head.get(b"SIZE", [])]
    n, rest = _whole(next(iter(head.get(b"POINTS", ())), b""), "POINTS"), len(content) - found.end()
    if found[1] not in (b"ascii", b"binary"):
        return  # this format is not read
    each = sum(size * count for size, count in zip(sizes, counts, strict=False)) if found[1] == b"binary" else 2 * sum(counts) - 1
    if n * max(1, each) > max(rest + 1, _MAX_HEAD):  # the reader reports a file that is slightly too short
        raise ValueError(f"its header states {n} points of at least {each} bytes each, of which {rest} bytes are there")
    if n * 3 > MAX_NUMBERS:
        raise ValueError(f"it has {n} points; up to {MAX_NUMBERS // 3} are read")
    if found[1] == b"ascii":
        check_text(content)


def check_ply(content: bytes) -> None:
    """Check the header and the length of a .ply file. Source: Turk, The PLY polygon file format, 1994."""
    head, found, _ = content[:_MAX_HEAD].partition(b"end_header")
    if not found:
        raise ValueError(f"it has no end_header within its first {_MAX_HEAD} bytes")
    is_text, elements = b"ascii" in head[:100], []
    for words in map(bytes.split, head.splitlines()):
        if words[:1] == [b"element"]:
            elements.append([_whole(words[-1], "element"), 0])
        elif words[:1] == [b"property"] and elements and len(words) > 2:
            kind = words[2] if words[1] == b"list" else words[1]  # a list contains at least its length
            elements[-1][1] += 2 if is_text else _PLY_BYTES.get(kind.decode("latin-1"), 1)
    if len(elements) > _MAX_ELEMENTS or head.count(b"\nproperty") > _MAX_FIELDS:
        raise ValueError(f"its header has more than {_MAX_ELEMENTS} elements, or more than {_MAX_FIELDS} properties")
    rest, rows = len(content) - len(head) - len(found), sum(n for n, _ in elements)
    least = sum(n * each for n, each in elements)
    if least > rest + 1 or rows > max(rest, 0) + 1:
        raise ValueError(f"its header states {rows} rows of at least {least} bytes in all, of which {rest} bytes are there")
    if rows > _MAX_FACES + MAX_NUMBERS // 3 or any(n > _MAX_FACES for n, _ in elements[1:]):
        raise ValueError(f"it has {rows} vertices and faces; up to {MAX_NUMBERS // 3} and {_MAX_FACES} are read")
    if is_text and max(rows, content.count(b"\n"), content.count(b"\r")) > _MAX_ROWS:
        raise ValueError(f"it has more than {_MAX_ROWS} lines, the most that are read of a text; a binary .ply may have more")


def _whole(word: bytes, key: str) -> int:
    if not re.fullmatch(rb"\d{1,15}", word):
        raise ValueError(f"its {key} is {word[:40].decode(errors='replace')!r}; a whole number of at least 0 is expected")
    return int(word)


CHECKS = {".npy": check_npy, ".ply": check_ply, ".pcd": check_pcd}
"""By the extension of a file; any other is a text."""


def check_numbers(ending: str, content: bytes, max_numbers: int = MAX_NUMBERS) -> None:
    """Check a file of numbers in the format of its extension, such as ``.csv``."""
    if ending in CHECKS:
        CHECKS[ending](content)
    else:
        check_text(content, max_numbers)
