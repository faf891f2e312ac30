"""Handles that are let go, without a browser: no end of a drag is lost, in whatever order frames and events come."""

from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from coroutines import run_coroutine
from ulna.viewer.hand import HandPanel
from ulna.viewer.handles import Handles
from ulna.viewer.page import Page
from ulna.viewer.session.session import Session


@pytest.fixture(scope="module")
def server():
    page = Page(port=0)
    yield page.server
    page.stop()


def tell(handles, phase, client=1):
    run_coroutine(handles._update(SimpleNamespace(phase=phase, client_id=client)))


def test_the_end_of_a_drag_that_comes_amid_a_frame_is_not_lost(server, panda):
    session = Session(panda)
    panel = HandPanel(server, session, 1.0, lambda: None)
    panel.show()
    handles = panel.handles
    tell(handles, "start")
    take = handles.take

    def take_and_then_the_drag_ends():
        moved = take()
        if handles.held:
            handles.control.position = np.add(handles.control.position, (0, 0, -0.02))
            tell(handles, "update")
            tell(handles, "end")
        return moved

    handles.take = take_and_then_the_drag_ends
    for _ in range(20):
        panel.take()
        session.frame()
    assert session.target is None
    assert np.allclose(session.hand_pose, handles.pose, atol=2e-5)


def test_handles_that_are_hidden_are_held_by_nobody(server):
    handles = Handles(server.scene, "/some", 0.2, lambda: None)
    tell(handles, "start")
    assert handles.held
    handles.show(visible=False)
    assert not handles.held
    assert handles.take_release()
    handles.show(visible=True)
    handles.put(ulna.pose((1, 2, 3)))
    assert np.array_equal(handles.pose, ulna.pose((1, 2, 3)))
