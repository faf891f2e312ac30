"""The word beside the light, written over the finished picture."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ulna.viewer.palette import INK

_HEIGHT = 0.03  # of the letters, as a part of the picture's
_LEAST = 11  # pixels: letters smaller than these are not read
_PAPER = (255, 255, 255, 215)


def write_word(pixels: NDArray[np.uint8], word: str, place: tuple[float, float]) -> None:
    """Write a word on a strip of paper, its upper edge centred at a place, and moved where it would leave the picture."""
    if not word:
        return
    height, width = pixels.shape[:2]
    font = _font(max(round(_HEIGHT * height), _LEAST))
    left, _, right, _ = font.getbbox(word)
    _, top, _, bottom = font.getbbox("Ag")  # as high as any word
    margin = 0.4 * (bottom - top)
    wide, high = right - left + 2 * margin, bottom - top + 1.6 * margin
    x = min(max(place[0] - wide / 2, margin), width - wide - margin)
    y = min(max(place[1], margin), height - high - margin)
    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image, "RGBA")
    draw.rounded_rectangle((x, y, x + wide, y + high), radius=margin, fill=_PAPER)
    draw.text((x + margin - left, y + 0.8 * margin - top), word, font=font, fill=INK)
    pixels[:] = np.asarray(image)


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own letters: no font of the system is needed."""
    return ImageFont.load_default(size)
