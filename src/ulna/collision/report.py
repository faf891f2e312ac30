"""What a collision check found."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Pair:
    """Two shapes that overlap.

    Attributes:
        name_a: The robot's shape.
        name_b: The object of the world.
        link: The link that carries ``name_a``.
        signed_distance: Minus the penetration depth [m]: how far one would have to move out, to 1e-8 of the boxes' size.
        normal: The unit vector from a to b along which they overlap least, in the base frame, shape (3,).
    """

    name_a: str
    name_b: str
    link: str
    signed_distance: float
    normal: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Report:
    """The pairs that overlap, deepest first."""

    pairs: tuple[Pair, ...]

    @property
    def in_collision(self) -> bool:
        """True if any pair overlaps."""
        return bool(self.pairs)

    @property
    def touching(self) -> tuple[str, ...]:
        """The robot's shapes that overlap anything, each once, in the order of the robot."""
        return tuple(dict.fromkeys(pair.name_a for pair in sorted(self.pairs, key=lambda p: _natural(p.name_a))))

    def __str__(self) -> str:
        return f"collision: {', '.join(self.touching)}" if self.pairs else "free"


def _natural(name: str) -> tuple:
    """Sorts "box 7" before "box 12"."""
    return tuple((0, int(word), "") if word.isdigit() else (1, 0, word) for word in name.split())
