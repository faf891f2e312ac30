"""People with a color vision deficiency can distinguish the colors of free and touching, which never differ in hue alone.

The matrices are those of Machado, Oliveira and Fernandes, A physiologically-based model for simulation of color vision deficiency
(IEEE Transactions on Visualization and Computer Graphics 15(6), 2009), severity 1.0, on linear RGB. Differences are
those of CIE 1976 L*a*b*, of which 2.3 is just noticeable (Mahy, Van Eycken and Oosterlinck 1994).
"""

import numpy as np
import pytest

from ulna.collision.report import Report
from ulna.viewer import html, palette
from ulna.viewer.palette import GREEN, RED
from ulna.viewer.session.clearance import Clearance

SIGHT = {
    "usual": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    "none for colors": np.tile([0.2126, 0.7152, 0.0722], (3, 1)),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([255.0, 255.0, 255.0])
CLEARLY = 15.0


def linear(rgb):
    share = np.asarray(rgb) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(rgb, sight):
    xyz = TO_XYZ @ np.clip(np.asarray(SIGHT[sight]) @ linear(rgb), 0, 1) / (TO_XYZ @ np.ones(3))
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def difference(first, second, sight):
    return float(np.linalg.norm(lab(first, sight) - lab(second, sight)))


def over_white(color, opacity):
    return np.asarray(color) * opacity + WHITE * (1 - opacity)


@pytest.mark.parametrize("sight", SIGHT)
def test_green_and_red_of_the_light_are_distinguishable(sight):
    assert difference(GREEN, RED, sight) > CLEARLY


@pytest.mark.parametrize("sight", SIGHT)
def test_a_touching_shape_of_the_robot_is_darker_than_a_free_one(sight):
    free, touching = over_white(palette.FREE, palette.PALE), over_white(palette.TOUCHING, palette.STRONG)
    assert lab(free, sight)[0] - lab(touching, sight)[0] > CLEARLY


@pytest.mark.parametrize("sight", SIGHT)
def test_a_touching_obstacle_has_a_color_that_no_free_one_has(sight):
    assert all(difference(color, palette.TOUCHING, sight) > CLEARLY for color in palette.OBSTACLES)


def test_results_are_also_given_by_word_and_by_filling():
    """A disc where something is in the way, a ring where nothing is, a dotted ring where that is not known."""
    free = Clearance(Report(()))
    assert free.state == "free"
    for color in (GREEN, palette.TRAIL):
        assert "solid" in html.status_line("free", color)
        assert "background" not in html.status_line("free", color)
    for color in (RED, palette.STOPPED):
        assert "border:" not in html.status_line("collision", color)
        assert "background" in html.status_line("collision", color)
    assert "dotted" in html.status_line("checking ...", palette.UNKNOWN)
    assert "background" not in html.status_line("checking ...", palette.UNKNOWN)
    assert "collision" in html.status_line("collision", RED)


def test_colors_that_deuteranopia_confuses_are_found_similar():
    """Checks the measure itself: two colors that look alike with deuteranopia have a small difference."""
    assert (
        difference((180, 90, 60), (112, 112, 60), "deuteranopia") < CLEARLY < difference((180, 90, 60), (112, 112, 60), "usual")
    )
