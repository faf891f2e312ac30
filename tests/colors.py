"""Counts the red, green and blue pixels of a picture."""

import numpy as np


def count(image: np.ndarray, like: str) -> int:
    """How many pixels are clearly "red", "green" or "blue"."""
    k = ("red", "green", "blue").index(like)
    image = image.astype(int)
    others = np.delete(image, k, axis=-1).max(axis=-1)
    return int(np.count_nonzero(image[..., k] - others > 60))
