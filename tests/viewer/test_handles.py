"""Handles that are dragged: drag events that arrive between two frames are not lost."""

from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from coroutines import run_coroutine
from ulna.viewer.nodes import Handles, project_to_level


class Scene:
    """Replaces viser's scene, and keeps the listener of the handles."""

    def add_transform_controls(self, *_, **__):
        self.control = SimpleNamespace(position=np.zeros(3), wxyz=np.array([1.0, 0, 0, 0]), on_update=self.listen)
        return self.control

    def listen(self, listener):
        self.listener = listener

    def send_event(self, phase, client=0):
        run_coroutine(self.listener(SimpleNamespace(phase=phase, client_id=client)))


@pytest.fixture
def scene():
    return Scene()


@pytest.fixture
def handles(scene):
    return Handles(scene, "/handles", 1.0, lambda: None)


def test_a_whole_drag_between_two_frames_is_noticed(scene, handles):
    for phase in ("start", "update", "end"):
        scene.send_event(phase)
    assert handles.pop_moved()
    assert handles.pop_released()
    assert not handles.pop_moved()
    assert not handles.pop_released()


def test_the_program_does_not_move_handles_that_are_being_dragged(scene, handles):
    T = ulna.pose((1, 2, 3))
    scene.send_event("start")
    handles.put(T)
    assert np.array_equal(handles.pose, np.eye(4))
    scene.send_event("end")
    handles.put(T)
    assert np.array_equal(handles.pose, T)


def test_the_program_does_not_undo_a_move_that_no_frame_has_read(scene, handles):
    scene.send_event("update")
    scene.control.position = np.array([0.5, 0, 0])
    handles.put(np.eye(4))
    assert handles.pose[0, 3] == 0.5
    assert handles.pop_moved()


def test_handles_dragged_in_two_tabs_are_held_until_both_release(scene, handles):
    scene.send_event("start", client=1)
    scene.send_event("start", client=2)
    scene.send_event("end", client=1)
    assert handles.dragged
    assert not handles.pop_released()
    scene.send_event("end", client=2)
    assert handles.pop_released()


def test_a_drag_along_the_floor_stays_on_the_level_of_the_grabbed_point_and_on_the_line_of_sight(rng):
    for eye, seen, point in rng.uniform(-1, 1, (50, 3, 3)) + np.array([[0, 0, 3], [0, 0, 0], [0, 0, 0]]):
        found = project_to_level(eye, seen, point)
        assert found[2] == pytest.approx(point[2])
        np.testing.assert_allclose(np.cross(found - eye, seen - eye), 0.0, atol=1e-9)


def test_a_drag_that_only_grazes_the_floor_is_parallel_to_the_screen():
    eye, point = np.array([0.0, 0, 1.0]), np.array([1.0, 0, 0])
    for seen in ([1.0, 0, 1.0], [1.0, 0, 0.99], [1.0, 0, 2.0], [1.0, 0, 0.9]):
        assert np.array_equal(project_to_level(eye, np.array(seen), point), seen)


def test_what_handles_hold_is_dragged_as_by_them(scene, handles):
    listeners = []
    node = SimpleNamespace(on_drag=lambda *_, **options: lambda dragged: listeners.append((options.get("modifier"), dragged)))
    handles.make_draggable(node, lambda: ulna.pose((1, 0, 0)))
    camera = SimpleNamespace(camera=SimpleNamespace(position=(1.0, 0, 10.0)))

    def send(phase, end, modifier=None):
        event = SimpleNamespace(
            phase=phase, client_id=0, client=camera, modifier=modifier, start_position=(1.0, 0, 0), end_position=end
        )
        run_coroutine(dict(listeners)[modifier](event))

    send("start", (1.0, 0, 0))
    assert handles.dragged
    send("update", (1.2, 0.1, 1.0))
    assert handles.pop_moved()
    np.testing.assert_allclose(handles.pose[:3, 3], (1 + 0.2 * 10 / 9, 0.1 * 10 / 9, 0.0))
    send("end", (1.0, 0.3, 0.0))
    assert handles.pop_released()
    np.testing.assert_allclose(handles.pose[:3, 3], (1.0, 0.3, 0.0))
    send("start", (1.0, 0, 0), "shift")
    send("update", (1.0, 0, 0.5), "shift")
    np.testing.assert_allclose(handles.pose[:3, 3], (1.0, 0.0, 0.5))
