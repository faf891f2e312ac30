"""What was compiled ahead, as data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ulna.answers.plain import Data

if TYPE_CHECKING:
    from ulna.warmup import Compiled  # which loads the compiler

WARMUP_KEYS = (
    "folder: where the machine code lies; seconds: in all; compiled: entry, shapes (boxes or any, where that is two), seconds, "
    "was_cached: it lay there already."
)


def warmup_data(folder: str, seconds: float, compiled: Iterable[Compiled]) -> Data:
    """What every kernel took; see ``WARMUP_KEYS``."""
    rows = [
        {"entry": one.name, "shapes": one.shapes, "seconds": one.seconds, "was_cached": one.was_cached}
        for one in sorted(compiled, key=lambda one: -one.seconds)
    ]
    return {"folder": folder, "seconds": seconds, "compiled": rows}
