"""Films of a robot that moves along rows of q among obstacles: an obstacle is red when the collision checker says so."""

from itertools import product

import numpy as np
import pytest

import ulna
from ulna.viewer.film import recording
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.film import Film
from ulna.viewer.film.painter import Ground, Picture
from ulna.viewer.film.recording import make_form, record_moving, report_at, solids_at
from ulna.viewer.film.skin import BoundingBall, Model
from ulna.viewer.palette import TOUCHING, Solid
from ulna.viewer.visuals import touching_links
from videos import decoded


@pytest.fixture
def world():
    world = ulna.World()
    world.add("crate", ulna.Box((0.15, 0.15, 0.15)), ulna.pose((0.45, 0.0, 0.35)))
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -0.1)))
    return world


def is_red(frame):
    return np.count_nonzero((frame[..., 0] > 150) & (frame[..., 1:].max(axis=-1) < 110)) > 60


@pytest.mark.slow
def test_an_obstacle_is_red_in_the_frames_in_which_the_checker_finds_a_collision(panda, world, tmp_path):
    away, into = panda.home + np.array([1.2, 0, 0, 0, 0, 0, 0]), panda.home + np.array([0, 0.35, 0, 0, 0, 0, 0])
    path = np.array([away, into, away])
    record_moving(make_form(tmp_path / "a.mp4", 1.5, (320, 240), 10), panda, path, world, boxes=False)
    q = np.array([np.interp(place, range(3), path[:, k]) for place in np.linspace(0, 2, 15) for k in range(7)]).reshape(15, 7)
    expected = panda.in_collision(q, world)
    frames = decoded(tmp_path / "a.mp4")[0]
    assert len(frames) == 15
    assert [is_red(frame.astype(int)) for frame in frames] == expected.tolist()
    assert 0 < expected.sum() < 15


@pytest.mark.slow
def test_obstacles_of_any_shape_are_drawn(panda, tmp_path):
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0.6, 0, 0.3)))
    world.add("rod", ulna.Capsule(0.03, 0.3), ulna.pose((0.0, 0.5, 0.3)))
    world.add("cloud", ulna.PointCloud(points=[(0.5, 0.5, 0.5), (0.6, 0.5, 0.5)], radius=0.02))
    record_moving(make_form(tmp_path / "a.png", 1.0, (320, 240)), panda, panda.home[None], world)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_each_obstacle_has_a_color_of_its_own_and_what_is_attached_is_drawn(panda):
    world = ulna.World()
    for k, y in enumerate((-0.4, 0.4)):
        world.add(f"crate {k}", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, y, 0.3)))
    held = panda.with_attached("part", ulna.Box((0.05, 0.05, 0.1)), ulna.pose((0.0, 0.0, 0.12)))
    ball = BoundingBall.of(np.eye(3))
    solids = {solid.name: solid for solid in solids_at(held, report_at(held, panda.home, world), world, ball, boxes=False)}
    assert set(solids) == {"obstacle crate 0", "obstacle crate 1", "attached part"}
    assert len({solid.color for solid in solids.values()}) == 3
    assert solids["attached part"].link == panda.tip
    world.move("crate 0", panda.forward_kinematics(panda.home) @ ulna.pose((0.0, 0.0, 0.12)))
    touching = solids_at(held, report_at(held, panda.home, world), world, ball, boxes=False)
    assert [solid.name for solid in touching if solid.color == TOUCHING] == ["attached part", "obstacle crate 0"]


def test_the_links_in_contact_are_red_in_a_picture(panda):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 0.9)), ulna.pose((0.307, 0, 0.45)))
    links = touching_links(panda, report_at(panda, panda.home, world))
    assert {"panda_link8", "panda_ee"} <= links  # fixed joints connect them
    assert "panda_link0" not in links
    model = Model(panda)
    colors, _ = model.paints(model.skin, (), links)
    own = np.array([name in links for name in panda.link_names])[model.skin.owners]
    assert (colors[own, 0] > 2.0 * colors[own, 1]).all()
    assert np.array_equal(colors[~own], model.skin.colors[~own])
    assert touching_links(panda, report_at(panda, panda.home, ulna.World())) == frozenset()


@pytest.mark.slow
def test_each_picture_of_a_film_has_solids_of_its_own(panda, rng):
    """Clouds and boxes that come and go: a picture in the film is the one that another film has of it alone."""
    shapes = [ulna.PointCloud(rng.uniform(0.3, 0.6, (n, 3)), 0.01) for n in (40, 300)]
    T, blue = ulna.pose((0.4, 0.2, 0.2)), (20, 40, 220)
    seen = [Solid("seen", panda.base, np.eye(4), shape, blue) for shape in shapes]
    crate = Solid("crate", panda.tip, T, ulna.Box((0.2, 0.2, 0.2)), (200, 160, 20))
    pane = Solid("pane", panda.base, T, ulna.Box((0.3, 0.3, 0.3)), (200, 0, 0), 0.4)
    sets = [(seen[0],), (seen[1], crate), (), (pane, seen[1]), (crate, seen[0]), (seen[0],)]
    camera, ground = Camera((1.5, 1.0, 1.0), (0.3, 0.2, 0.3)), Ground((0.3, 0.0, 0.3), 1.0)
    pictures = [Picture(panda.home, camera, solids) for solids in sets]

    def frames(some):
        return list(Film(Model(panda), some, (160, 90), 10, ground).frames())

    found = frames(pictures)
    for picture, pixels in zip(pictures, found, strict=True):
        assert np.array_equal(pixels, frames([picture])[0])
    blues = [np.count_nonzero(pixels[..., 2].astype(int) - pixels[..., 0] > 100) for pixels in found]
    assert blues[2] == 0 < blues[0] == blues[5] < blues[1]


SCENES = {
    "nothing": (),
    "a far box": (((9.0, 0.0, 0.5), True),),
    "a box beside it": (((0.6, 0.0, 0.2), False),),
    "boxes on three sides": (((0.5, 0.4, 0.1), False), ((0.5, -0.4, 0.1), False), ((0.7, 0.0, 0.1), False)),
}


def seen_at(camera, points, size):
    """Where points (n, 3) are seen, as shares of the width and the height."""
    x, y, depth = camera.view(*size) @ np.column_stack([points, np.ones(len(points))]).T
    return np.column_stack([x, y]) / depth[:, None] / size


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("size", [(640, 360), (360, 640)])
def test_the_arm_is_as_large_as_the_picture_allows(panda, tmp_path, monkeypatch, name, size):
    """As a pinhole sees it: arm and near obstacles fill the picture in one direction, and nothing of them is cut off."""
    world, near = ulna.World(), []
    for k, (place, is_far) in enumerate(SCENES[name]):
        world.add(f"box {k}", ulna.Box((0.1, 0.1, 0.1)), ulna.pose(place))
        near += [] if is_far else [np.array(place) + 0.05 * np.array(corner) for corner in product((-1, 1), repeat=3)]
    shots = []
    monkeypatch.setattr(recording, "write_pictures", lambda _, model, pictures, *__: shots.append((model, *pictures)))
    record_moving(make_form(tmp_path / "a.png", 1.0, size), panda, panda.home[None], world)
    model, picture = shots[0]
    own = seen_at(picture.camera, model.points_at(panda.home), size)
    seen = np.vstack([own, *(seen_at(picture.camera, point[None], size) for point in near)])
    assert seen.min() > 0
    assert seen.max() < 1
    assert np.ptp(seen, axis=0).max() > 0.9
    assert np.ptp(own, axis=0).max() > (0.9 if not near else 0.5)
