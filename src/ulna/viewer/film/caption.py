"""Writes text over a finished picture."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ulna.viewer.palette import INK

_HEIGHT = 0.03  # the height of the letters, as a part of the picture's
_LEAST = 11  # [pixels] the least height of the letters: smaller ones cannot be read
_PAPER = (255, 255, 255, 215)


@dataclass(frozen=True)
class Caption:
    """Text in a picture.

    Attributes:
        text: The text; nothing is written if it is empty.
        position: Where the middle of their upper edge is, in the base frame [m].
    """

    text: str
    position: tuple[float, float, float]


def write_text(pixels: NDArray[np.uint8], text: str, place: tuple[float, float]) -> None:
    """Write text on a light strip, kept inside the picture.

    Args:
        pixels: The picture, shape (height, width, 3); it is changed.
        text: The text.
        place: The middle of the strip's upper edge [pixels x, y].
    """
    if not text:
        return
    height, width = pixels.shape[:2]
    font = _font(max(round(_HEIGHT * height), _LEAST))
    left, _, right, _ = font.getbbox(text)
    _, top, _, bottom = font.getbbox("Ag")  # as high as any letters
    margin = 0.4 * (bottom - top)
    wide, high = right - left + 2 * margin, bottom - top + 1.6 * margin
    x = min(max(place[0] - wide / 2, margin), width - wide - margin)
    y = min(max(place[1], margin), height - high - margin)
    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image, "RGBA")
    draw.rounded_rectangle((x, y, x + wide, y + high), radius=margin, fill=_PAPER)
    draw.text((x + margin - left, y + 0.8 * margin - top), text, font=font, fill=INK)
    pixels[:] = np.asarray(image)


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own font, so that no font of the system is needed."""
    return ImageFont.load_default(size)
