"""The program that draws the pictures of the pages."""

import runpy

import numpy as np
import pytest

from doc_pages import ROOT

PROGRAM = ROOT / "docs" / "pictures" / "draw.py"
PICTURES, FILMS = (runpy.run_path(str(PROGRAM))[name] for name in ("PICTURES", "FILMS"))


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_drawn_and_is_on_a_page(name):
    pixels = PICTURES[name]((160, 90))
    assert pixels.shape == (90, 160, 3)
    assert np.ptp(pixels.reshape(-1, 3), axis=0).min() > 100  # from the sky to what is dark
    assert PROGRAM.with_name(f"{name}.png").is_file()
    assert any(f"(pictures/{name}.png)" in page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))


@pytest.mark.parametrize("name", FILMS)
def test_a_film_shows_what_changes_and_is_on_a_page(name):
    film = FILMS[name]((160, 90))
    assert len({id(picture.solids[0].shape) for picture in film.pictures}) > 1
    first, last = film.some(2)
    assert first.shape == (90, 160, 3)
    assert np.count_nonzero(np.abs(first.astype(int) - last).max(axis=2) > 50) > 300
    assert PROGRAM.with_name(f"{name}.gif").stat().st_size < 2_000_000
    assert any(f"(pictures/{name}.gif)" in page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))
