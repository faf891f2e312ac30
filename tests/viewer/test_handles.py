"""Handles that are dragged: what a frame sees of events that came between two frames."""

from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from coroutines import run_coroutine
from ulna.viewer.handles import Handles


class Scene:
    """Stands for viser's scene: keeps the listener."""

    def add_transform_controls(self, *_, **__):
        self.control = SimpleNamespace(position=np.zeros(3), wxyz=np.array([1.0, 0, 0, 0]), on_update=self.listen)
        return self.control

    def listen(self, listener):
        self.listener = listener

    def happens(self, phase, client=0):
        run_coroutine(self.listener(SimpleNamespace(phase=phase, client_id=client)))


@pytest.fixture
def scene():
    return Scene()


@pytest.fixture
def handles(scene):
    return Handles(scene, "/handles", 1.0, lambda: None)


def test_a_whole_drag_between_two_frames_is_seen(scene, handles):
    for phase in ("start", "update", "end"):
        scene.happens(phase)
    assert handles.take()
    assert handles.take_release()
    assert not handles.take()
    assert not handles.take_release()


def test_what_somebody_holds_is_not_moved_by_the_program(scene, handles):
    T = ulna.pose((1, 2, 3))
    scene.happens("start")
    handles.put(T)
    assert np.array_equal(handles.pose, np.eye(4))
    scene.happens("end")
    handles.put(T)
    assert np.array_equal(handles.pose, T)


def test_what_was_just_moved_is_not_moved_back_before_it_is_taken(scene, handles):
    scene.happens("update")
    scene.control.position = np.array([0.5, 0, 0])
    handles.put(np.eye(4))
    assert handles.pose[0, 3] == 0.5
    assert handles.take()


def test_two_hands_hold_until_both_let_go(scene, handles):
    scene.happens("start", client=1)
    scene.happens("start", client=2)
    scene.happens("end", client=1)
    assert handles.held
    assert not handles.take_release()
    scene.happens("end", client=2)
    assert handles.take_release()
