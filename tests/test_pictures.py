"""Tests the program that draws the pictures of the documentation."""

import runpy

import numpy as np
import pytest

from doc_pages import ROOT
from matrix import matrix

PROGRAM = ROOT / "docs" / "pictures" / "draw.py"
NAMES = runpy.run_path(str(PROGRAM))
PICTURES, FILMS, MOMENT = NAMES["PICTURES"], NAMES["FILMS"], NAMES["ServoMoment"]


@pytest.mark.slow
@pytest.mark.parametrize("name", matrix([*PICTURES], ["collision"]))
def test_a_picture_is_drawn_and_is_on_a_page(name):
    pixels = PICTURES[name]((160, 90))
    assert pixels.shape == (90, 160, 3)
    assert np.ptp(pixels.reshape(-1, 3), axis=0).min() > 100  # from the sky to what is dark
    assert PROGRAM.with_name(f"{name}.png").is_file()
    assert any(f"(pictures/{name}.png)" in page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))


def test_parts_of_a_picture_are_apart_and_have_letters():
    size, gray = (104, 54), np.full(3, 100, np.uint8)
    width, height = NAMES["part_of"](size, 2, 2)
    sheet = NAMES["beside"]([np.tile(gray, (height, width, 1))] * 4, size, 2)
    assert (width, height, sheet.shape) == (50, 25, (54, 104, 3))
    assert (sheet[:, 50:54] == 255).all()
    assert (sheet[25:29] == 255).all()
    parts = [sheet[y : y + height, x : x + width] for y in (0, 29) for x in (0, 54)]
    assert all((part != gray).any() for part in parts)
    assert len({part.tobytes() for part in parts}) == 4


@pytest.mark.slow
@pytest.mark.parametrize("name", FILMS)
def test_a_film_shows_what_changes_and_is_on_a_page(name):
    film = FILMS[name]((160, 90))
    assert len({id(picture.solids[0].shape) for picture in film.pictures}) > 1
    first, middle, _ = film.some(3)  # a loop ends as it begins
    assert first.shape == (90, 160, 3)
    assert np.count_nonzero(np.abs(first.astype(int) - middle).max(axis=2) > 50) > 300
    assert PROGRAM.with_name(f"{name}.gif").stat().st_size < 2_000_000
    assert any(f"(pictures/{name}.gif)" in page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))


def test_the_velocity_among_the_rows_of_a_servo_is_the_nearest_that_all_of_them_allow():
    """The rows are drawn from their formulas, and the velocity is that of a servo's command."""
    moment = MOMENT()
    x, names = moment.command.qd, [name for name, g, b in moment.rows if abs(g @ moment.command.qd - b) < 1e-6]
    plane = np.stack(np.meshgrid(np.linspace(0, 1, 401), np.linspace(0, 1, 401)), axis=-1)
    allowed = plane[np.all([plane @ g >= b for _, g, b in moment.rows], axis=0)]
    assert min(g @ x - b for _, g, b in moment.rows) > -1e-6
    assert names == ["post"]
    assert np.linalg.norm(allowed - moment.desired, axis=1).min() >= np.linalg.norm(x - moment.desired) - 1e-6
    assert len(allowed) > 1000
