"""Batches in parts: all of them have ended when the call ends, whatever made it end."""

from threading import Event

import pytest

from ulna.kinematics.batches import in_parts

ROWS, PARTS = 8000, 8  # threads=2 makes four parts for each


def answer(how):
    if isinstance(how, bool):
        return how
    raise how


@pytest.mark.parametrize("how", [False, True, ZeroDivisionError, KeyboardInterrupt])
def test_no_part_runs_on_behind_the_call(how):
    begun, over, running = Event(), Event(), set()

    def run(rows):
        if rows.start == 0:
            assert begun.wait(10)
            return answer(how)
        running.add(rows.start)
        begun.set()
        over.wait(0.02)  # while the call lasts nobody ends this wait
        running.discard(rows.start)
        return True

    try:
        said = in_parts(run, ROWS, least=ROWS // PARTS, threads=2)
    except (ZeroDivisionError, KeyboardInterrupt) as error:
        said = type(error)
    left = set(running)
    over.set()
    assert said is how
    assert not left
