"""Handles that are dragged: drag events that arrive between two frames are not lost."""

from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from coroutines import run_coroutine
from ulna.viewer.nodes import Handles


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
    assert handles.take()
    assert handles.take_release()
    assert not handles.take()
    assert not handles.take_release()


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
    assert handles.take()


def test_handles_dragged_in_two_tabs_are_held_until_both_release(scene, handles):
    scene.send_event("start", client=1)
    scene.send_event("start", client=2)
    scene.send_event("end", client=1)
    assert handles.dragged
    assert not handles.take_release()
    scene.send_event("end", client=2)
    assert handles.take_release()
