"""The thread that draws the frames of a page."""

import threading

import ulna
from processes import wait_for
from ulna.viewer.loop import Loop


def test_a_failed_frame_is_logged_and_the_next_one_is_drawn(capsys):
    frames, made = [], threading.Event()

    def frame():
        frames.append(None)
        if len(frames) == 1:
            raise ArithmeticError("of the first frame")
        made.set()

    loop = Loop("test", frame, lambda: 1e-3)
    loop.start()
    assert made.wait(10)
    loop.stop(within=10)
    assert loop.ended
    assert "ArithmeticError: of the first frame" in capsys.readouterr().err


def test_a_wake_ends_the_pause_between_frames():
    made = threading.Event()
    loop = Loop("test", made.set, lambda: 3600.0)
    loop.start()
    loop.wake()
    assert made.wait(10)
    loop.stop(within=10)
    loop.wait()
    assert loop.ended


def test_a_repeated_failure_is_logged_once_and_reported_until_it_ends(capsys):
    failing, seen = threading.Event(), []
    failing.set()

    def frame():
        if failing.is_set():
            raise ArithmeticError("again")

    loop = Loop("test", frame, lambda: 1e-3, seen.append)
    loop.start()
    wait_for(lambda: len(seen) > 2, "three failures")
    failing.clear()
    wait_for(lambda: seen[-1] is None, "the end of them")
    loop.stop(within=60)
    assert {str(error) for error in seen[:-1]} == {"again"}
    assert capsys.readouterr().err.count("ArithmeticError: again") == 1


def test_a_failed_frame_is_shown_on_the_page(panda):
    with ulna.view(panda) as view:
        frame, view._frame = view._frame, lambda: 1 / 0
        wait_for(lambda: "ZeroDivisionError" in view.notice.text, "the failure")
        assert view.notice._element.visible
        view._frame = frame
        wait_for(lambda: view.notice.text == "", "no failure")
        assert not view.notice._element.visible
