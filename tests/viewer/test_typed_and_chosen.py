"""Values that a person types or chooses, when a frame is drawn before the listener runs; without a browser."""

import inspect
from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from ulna.viewer.move_panel import HandPanel
from ulna.viewer.obstacles import Obstacles
from ulna.viewer.page import Page
from ulna.viewer.session.clearance import ShapeNames
from ulna.viewer.session.session import Session


@pytest.fixture(scope="module")
def server():
    page = Page(port=0)
    yield page.server
    page.stop()


@pytest.fixture
def obstacles(server):
    return Obstacles(server, ulna.World(), np.zeros(3), 1.0, lambda: None)


def person_sets(field, value, between=lambda: None, client=None):
    """Set a field as viser does: first the value, then coroutine listeners, later the others; ``between`` runs before those."""
    field._impl.value = value
    event = SimpleNamespace(client=client or SimpleNamespace(), client_id=0, target=field)
    later = []
    for listener in field._impl.update_cb:
        if inspect.iscoroutinefunction(listener):
            with pytest.raises(StopIteration):
                listener(event).send(None)
        else:
            later.append(listener)
    between()
    for listener in later:
        listener(event)


def choose(obstacles, name):
    obstacles.form.choose(name)
    obstacles.apply_input()
    obstacles.show(set())


def test_a_frame_does_not_overwrite_a_value_that_was_just_typed(obstacles):
    obstacles.world.add("ball", ulna.Sphere(0.1))
    choose(obstacles, "ball")
    person_sets(obstacles.form.sizes["radius"], 0.25, between=lambda: obstacles.show(set()))
    obstacles.apply_input()
    assert obstacles.world.shape("ball") == ulna.Sphere(0.25)


def test_only_the_number_that_was_typed_changes(obstacles):
    T = ulna.pose((0.123456789, 1 / 3, 2 / 3), (0.1234567, 0.2345678, 1 / 3))
    obstacles.world.add("rod", ulna.Cylinder(1 / 30, 1 / 3), T)
    choose(obstacles, "rod")
    form = obstacles.form
    person_sets(form.xyz, (0.5, *form.xyz.value[1:]))
    obstacles.apply_input()
    expected = T.copy()
    expected[0, 3] = 0.5
    assert np.array_equal(obstacles.world.pose("rod"), expected)
    person_sets(form.rpy, (*form.rpy.value[:2], 0.5))
    obstacles.apply_input()
    moved = obstacles.world.pose("rod")
    assert np.allclose(moved, ulna.pose((0.5, 1 / 3, 2 / 3), (0.1234567, 0.2345678, 0.5)), rtol=0, atol=1e-12)
    person_sets(form.sizes["length"], 0.4)
    person_sets(form.name, "post")
    obstacles.apply_input()
    assert obstacles.world.shape("post") == ulna.Cylinder(1 / 30, 0.4)
    assert obstacles.world.names == ("post",)
    assert np.array_equal(obstacles.world.pose("post"), moved)


def test_a_typed_value_changes_the_obstacle_that_was_chosen_at_that_time(obstacles):
    for name in ("a", "b"):
        obstacles.world.add(name, ulna.Sphere(0.1))
    choose(obstacles, "a")
    person_sets(obstacles.form.sizes["radius"], 0.2)
    person_sets(obstacles.form.choice, "b")
    assert obstacles.apply_input()
    assert [obstacles.world.shape(name).radius for name in ("a", "b")] == [0.2, 0.1]


def test_a_bad_value_is_reported_to_the_tab_where_it_was_typed(obstacles):
    notifications = []
    client = SimpleNamespace(add_notification=lambda *words, **_: notifications.append(words))
    obstacles.world.add("ball", ulna.Sphere(0.1))
    choose(obstacles, "ball")
    person_sets(obstacles.form.sizes["radius"], -1.0, client=client)
    obstacles.apply_input()
    assert notifications[0][0] == "Not changed"
    assert obstacles.world.shape("ball") == ulna.Sphere(0.1)
    assert obstacles.form.sizes["radius"].value == 0.1


def test_an_obstacle_cannot_have_the_name_of_a_link_or_shape_of_the_robot(server, panda):
    notifications = []
    client = SimpleNamespace(add_notification=lambda *words, **_: notifications.append(words))
    obstacles = Obstacles(server, ulna.World(), np.zeros(3), 1.0, lambda: None, ShapeNames(panda).reserved)
    obstacles.add("Box")
    obstacles.add("Sphere")
    assert obstacles.world.names == ("new box 1", "sphere 1")
    choose(obstacles, "new box 1")
    for name in ("box 7", "panda_link3", "panda_link1 (box 2)"):
        person_sets(obstacles.form.name, name, client=client)
        obstacles.apply_input()
    assert obstacles.world.names == ("new box 1", "sphere 1")
    assert obstacles.form.name.value == "new box 1"
    assert [words[0] for words in notifications] == 3 * ["Not changed"]


def test_a_frame_does_not_reset_the_link_that_was_just_chosen(server, panda):
    session = Session(panda)
    panel = HandPanel(server, session, 1.0, lambda: None)
    person_sets(panel.link, "panda_link4", between=panel.show)
    assert session.link == "panda_link4"
    session.link = "panda_link5"  # by the program
    panel.show()
    assert panel.link.value == "panda_link5"


def test_a_scene_too_long_to_be_loaded_again_is_not_saved_and_the_page_says_why(obstacles, monkeypatch):
    messages, files = [], []
    client = SimpleNamespace(
        add_notification=lambda *words, **_: messages.append(words),
        send_file_download=lambda name, content, **_: files.append((name, content)),
    )
    obstacles.add("Box")
    obstacles._download(SimpleNamespace(client=client))
    assert (len(files), messages) == (1, [])
    monkeypatch.setattr("ulna.collision.scene_file.LONGEST", 10)
    obstacles._download(SimpleNamespace(client=client))
    assert len(files) == 1
    assert [title for title, _ in messages] == ["The scene was not saved"]
    assert "can be loaded" in messages[0][1]
