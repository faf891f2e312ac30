"""The loop of a page."""

import threading

from ulna.viewer.loop import Loop


def test_a_frame_that_fails_is_told_and_the_next_one_is_made(capsys):
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


def test_it_is_woken_before_its_pause_is_over():
    made = threading.Event()
    loop = Loop("test", made.set, lambda: 3600.0)
    loop.start()
    loop.wake()
    assert made.wait(10)
    loop.stop(within=10)
    loop.wait()
    assert loop.ended
