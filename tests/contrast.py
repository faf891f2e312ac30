"""Measures the contrast of each element of a page with its background, in a browser.

Source of the ratios and their minimum values: W3C, Web Content Accessibility Guidelines 2.1, criteria 1.4.3 and 1.4.11.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from playwright.sync_api import Page

OF_TEXT, OF_LARGE_TEXT, OF_CONTROLS = 4.5, 3.0, 3.0
SIZES = {"wide": (1440, 900), "phone": (390, 844)}
OF_INACTIVE_TEXT = 3.0  # of controls that cannot be used; the criteria leave them out

_MEASURE = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


class Seen(NamedTuple):
    """Something that is seen: text, a sign or a control; its words, its element, and its contrast with what is behind it."""

    kind: str
    words: str
    element: str
    contrast: float
    large: bool
    inactive: bool

    @property
    def least(self) -> float:
        """The smallest contrast that it may have."""
        if self.kind == "text":
            return OF_INACTIVE_TEXT if self.inactive else OF_LARGE_TEXT if self.large else OF_TEXT
        return 1.0 if self.inactive else OF_CONTROLS


def seen_on(page: Page) -> list[Seen]:
    """All that a page shows, once nothing fades in or out any more."""
    page.wait_for_function("document.getAnimations().every((one) => one.playState !== 'running')")
    return [Seen(*one) for one in page.evaluate(_MEASURE)]


def faint(seen: Iterable[Seen]) -> list[str]:
    """What has too little contrast, in words, the faintest first."""
    least = sorted((one for one in seen if one.contrast < one.least), key=lambda one: one.contrast)
    return [*dict.fromkeys(f"{one.contrast:.2f}: {one.kind} {one.words!r} ({one.element})" for one in least)]


def resize(page: Page, size: tuple[int, int]) -> None:
    """Give the window of a page another size, and wait until the panel is as it is there: above 36 em beside the scene."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.wait_for_function("(width) => document.querySelector('canvas').getBoundingClientRect().width > 0.6 * width", arg=size[0])
    page.wait_for_timeout(300)
