"""The release of handles, without a browser: it is noticed in whatever order frames and events come."""

from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from coroutines import run_coroutine
from ulna.viewer.move_panel import HandPanel
from ulna.viewer.nodes import Handles
from ulna.viewer.page import Page
from ulna.viewer.session.session import Session


@pytest.fixture(scope="module")
def server():
    page = Page(port=0)
    yield page.server
    page.stop()


def send_event(handles, phase, client=1):
    run_coroutine(handles._update(SimpleNamespace(phase=phase, client_id=client)))


def test_a_release_in_the_middle_of_a_frame_is_not_lost(server, panda):
    session = Session(panda)
    panel = HandPanel(server, session, 1.0, lambda: None)
    panel.show()
    handles = panel.handles
    send_event(handles, "start")
    pop_moved = handles.pop_moved

    def pop_then_end_the_drag():
        moved = pop_moved()
        if handles.dragged:
            handles.control.position = np.add(handles.control.position, (0, 0, -0.02))
            send_event(handles, "update")
            send_event(handles, "end")
        return moved

    handles.pop_moved = pop_then_end_the_drag
    for _ in range(20):
        panel.apply_input()
        session.frame()
    assert session.target is None
    assert np.allclose(session.hand_pose, handles.pose, atol=2e-5)


def test_hiding_handles_releases_them(server):
    handles = Handles(server.scene, "/some", 0.2, lambda: None)
    send_event(handles, "start")
    assert handles.dragged
    handles.show(visible=False)
    assert not handles.dragged
    assert handles.pop_released()
    handles.show(visible=True)
    handles.put(ulna.pose((1, 2, 3)))
    assert np.array_equal(handles.pose, ulna.pose((1, 2, 3)))
