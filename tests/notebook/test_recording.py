"""Pictures and films that stay in a notebook, drawn with no display."""

import base64
import io
import re
import sys

import numpy as np
import pytest
from PIL import Image

import ulna
from videos import decoded

SMALL = (160, 120)
SMALL_ARM = """<robot name="small">
  <link name="foot"/><link name="boom"/>
  <link name="hand"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="foot"/><child link="boom"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="end" type="fixed"><parent link="boom"/><child link="hand"/><origin xyz="0.3 0 0"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def arm():
    """A small arm without meshes, whose hand at (0.3, 0, 0.3) turns about z."""
    return ulna.load(SMALL_ARM)


@pytest.fixture(scope="module")
def crate():
    """A world of a crate at the arm's hand."""
    world = ulna.World()
    world.add("crate", ulna.Box((0.15, 0.15, 0.15)), ulna.pose((0.3, 0.0, 0.3)))
    return world


@pytest.fixture(scope="module")
def motion(arm):
    return arm.trajectory(np.array([[0.0], [0.8]]), acceleration=5.0, velocity=1.0)


def pixels(recording):
    return np.asarray(Image.open(io.BytesIO(recording._repr_png_())).convert("RGB")).astype(int)


def colored(picture):
    """How many pixels are neither gray nor nearly so."""
    return np.count_nonzero(np.ptp(picture, axis=-1) > 60)


def test_a_robot_is_shown_as_a_picture_that_is_saved_as_it_is(arm, tmp_path):
    shown = arm.show(size=SMALL)
    assert pixels(shown).shape == (120, 160, 3)
    assert shown._repr_html_() is None
    assert repr(shown).startswith("<Recording of small: png, 160x120, ")
    shown.save(tmp_path / "arm.png")
    assert (tmp_path / "arm.png").read_bytes() == shown._repr_png_()
    assert (pixels(arm.show(arm.home + 0.3, size=SMALL)) != pixels(shown)).any()


def test_what_the_robot_touches_is_red_and_else_in_a_color_of_its_own(arm, crate):
    aside = np.array([1.5])
    touched, free = (pixels(arm.show(q, crate, size=SMALL)) for q in (arm.home, aside))
    assert arm.in_collision(arm.home, crate)
    red = [np.count_nonzero((p[..., 0] > 150) & (p[..., 1:].max(axis=-1) < 95)) for p in (touched, free)]
    assert red[0] > 60 > red[1]
    assert colored(free) > 60


def test_a_world_is_shown_without_a_robot(crate):
    floor = ulna.World()
    floor.add("floor", ulna.HalfSpace())
    assert colored(pixels(ulna.World().show(size=SMALL))) == 0
    assert colored(pixels(floor.show(size=SMALL))) == 0
    share = colored(pixels(crate.show(size=SMALL))) / (160 * 120)
    assert share > 0.2  # the camera comes near to what there is


def test_every_kind_of_obstacle_can_be_shown():
    cloud = ulna.PointCloud([(0.5, 0, 0.2), (0.6, 0, 0.2)], radius=0.1)
    for shape in (cloud, ulna.HeightMap(np.eye(4), 0.1), ulna.Capsule(0.1, 0.3)):
        world = ulna.World()
        world.add("it", shape)
        assert colored(pixels(world.show(size=SMALL))) > 60


def test_a_world_that_changes_later_does_not_change_what_is_saved(crate, tmp_path):
    world = crate.copy()
    shown = world.show(size=SMALL)
    world.remove("crate")
    shown.save(tmp_path / "AGAIN.PNG")
    assert colored(np.asarray(Image.open(tmp_path / "AGAIN.PNG").convert("RGB")).astype(int)) > 60


def test_a_motion_is_shown_as_a_film_with_its_data_in_it(motion, tmp_path):
    shown = motion.show(seconds=0.6, size=(96, 64))
    assert shown._repr_png_() is None
    [source] = re.findall(r'src="data:image/gif;base64,([^"]+)"', shown._repr_html_())
    film = Image.open(io.BytesIO(base64.b64decode(source)))
    assert (film.n_frames, film.size) == (6, (96, 64))
    film.seek(5)
    assert (np.asarray(film.convert("RGB")) != pixels_of_first(shown)).any()
    shown.save(tmp_path / "motion.gif")
    assert (tmp_path / "motion.gif").read_bytes() == shown.data
    shown.save(tmp_path / "motion.mp4")
    assert len(decoded(tmp_path / "motion.mp4")[0]) == 18


def pixels_of_first(film):
    return np.asarray(Image.open(io.BytesIO(film.data)).convert("RGB"))


@pytest.mark.parametrize(
    ("side", "opposite", "angles", "place", "extents"),
    [
        ("front", "back", (0.0, 0.0), (1.0, 0.0, 0.5), (0.02, 1.0, 1.0)),
        ("left", "right", (np.pi / 2, 0.0), (0.0, 1.0, 0.5), (1.0, 0.02, 1.0)),
        ("back", "front", (-np.pi, 0.0), (-1.0, 0.0, 0.5), (0.02, 1.0, 1.0)),
        ("right", "left", (-np.pi / 2, 0.0), (0.0, -1.0, 0.5), (1.0, 0.02, 1.0)),
        ("top", "corner", (0.0, np.pi / 2), (0.0, 0.0, 1.0), (1.0, 1.0, 0.02)),
    ],
)
def test_a_wall_hides_what_is_behind_it_from_its_side_alone(side, opposite, angles, place, extents):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.0, 0.0, 0.05)))
    world.add("wall", ulna.Box(extents), ulna.pose(place))
    found = [pixels(world.show(size=SMALL, camera=camera)) for camera in (side, angles, opposite)]
    orange = [np.count_nonzero(each[..., 0] - each[..., 2] > 60) for each in found]
    assert orange[:2] == [0, 0]
    assert orange[2] > 30


def test_what_cannot_be_shown_is_refused_by_its_name(arm, crate, motion, tmp_path):
    for argument, ask in {
        "size": lambda: arm.show(size="large"),
        "camera": lambda: crate.show(camera="below"),
        "q": lambda: arm.show([0, 0, 0]),
        "world": lambda: arm.show(world=[1]),
        "seconds": lambda: motion.show(seconds=0),
        "path": lambda: crate.show(size=SMALL).save(tmp_path / "world.mp4"),
    }.items():
        with pytest.raises(ulna.InputError, match=f"^{argument}: "):
            ask()
    with pytest.raises(ulna.FileError, match="no such folder"):
        crate.show(size=SMALL).save(tmp_path / "none" / "world.png")


def test_the_missing_extra_is_named(arm, monkeypatch):
    for name in [name for name in sys.modules if name.startswith("ulna.viewer") or name.partition(".")[0] == "av"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ulna.MissingExtraError, match="a picture needs the viewer extra: "):
        arm.show()


def test_a_copy_that_was_installed_before_it_had_pictures_says_so(arm, monkeypatch):
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: ())
    with pytest.raises(ulna.UlnaError, match="install this copy of Ulna again"):
        arm.show()
