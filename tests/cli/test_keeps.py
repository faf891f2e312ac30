"""``--keep``: a constraint in words."""

import numpy as np
import pytest

import ulna
from ulna.cli.keeps import keep_of

PLANE = ulna.pose((0.4, 0, 0.5), (0, 0.1, 0))


@pytest.mark.parametrize(
    ("text", "keep"),
    [
        ("upright", ulna.Keep.upright()),
        ("upright=5deg", ulna.Keep.upright(np.radians(5))),
        ("upright=0.1", ulna.Keep.upright(0.1)),
        ("hand:upright=0.1rad", ulna.Keep.upright(0.1, link="hand")),
        ("orientation=pi/8", ulna.Keep.orientation(np.pi / 8)),
        ("line=0.4,0,0.5,0.4,0,0.8,2mm", ulna.Keep.on_line((0.4, 0, 0.5), (0.4, 0, 0.8), within=2e-3)),
        ("line=0.4,0,0.5,0.4,0,0.8", ulna.Keep.on_line((0.4, 0, 0.5), (0.4, 0, 0.8))),
        ("plane=0.4,0,0.5,0,0.1,0,0.01m", ulna.Keep.in_plane(PLANE, within=0.01)),
        ("inside=0.4,0,0.5,0,0.1,0,1,2,0.5", ulna.Keep.inside((1, 2, 0.5), PLANE)),
        ("camera:looking=0.4,0,0.5,3deg", ulna.Keep.looking_at((0.4, 0, 0.5), within=np.radians(3), link="camera")),
        ("together=left,right", ulna.Keep.together("left", "right")),
        ('together="left,hand", right', ulna.Keep.together("left,hand", "right")),
        ('together="the left hand","right",2mm,1deg', ulna.Keep.together("the left hand", "right", within=(2e-3, np.radians(1)))),
        ("left,hand:upright=0.1", ulna.Keep.upright(0.1, link="left,hand")),
        ("together=left,right,2mm,1deg", ulna.Keep.together("left", "right", within=(2e-3, np.radians(1)))),
    ],
)
def test_a_text_is_the_constraint_that_the_library_makes(text, keep):
    read = keep_of(text)
    assert (read.link, read.relative_to, read.towards, read.along) == (keep.link, keep.relative_to, keep.towards, keep.along)
    assert read.task.axis == keep.task.axis
    np.testing.assert_allclose(read.task.slack, keep.task.slack, rtol=1e-14)
    assert (read.T is None) == (keep.T is None)
    assert keep.T is None or np.allclose(read.T, keep.T, atol=1e-15)


def test_degrees_are_of_angles_without_a_unit():
    assert keep_of("upright=5", degrees=True).task.slack[3] == pytest.approx(np.radians(5))
    tilted = keep_of("plane=0.4,0,0.5,0,45,0,1mm", degrees=True)
    np.testing.assert_allclose(tilted.T, ulna.pose((0.4, 0, 0.5), (0, np.pi / 4, 0)), atol=1e-15)
    assert tilted.task.slack[2] == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("uprigt=5deg", "did you mean 'upright'"),
        ("upright=5mm", "such as 5deg"),
        ("upright=1deg,2deg", "such as 5deg"),
        ("upright=0deg", "from 1e-06 to below pi"),
        ("line=0,0,0,1mm", "6 are expected"),
        ("line=0,0,0,0,0,0,1mm", "other than the first"),
        ("inside=0,0,0,0,0,0,1,1,1,1mm", "no tolerance"),
        ('together="left,right', "put a name with a comma in double quotes"),
        ("together=left", "LINK,LINK"),
        ("together=left,left", "never moves"),
        ("together=left,right,1mm", "such as 1mm,5deg"),
    ],
)
def test_what_cannot_be_read_names_the_option(text, message):
    with pytest.raises(ulna.InputError, match=message) as refused:
        keep_of(text)
    assert refused.value.argument == "--keep"
