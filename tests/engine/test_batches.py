"""Batches in parts: their rows are those of small batches, and all have ended when the call ends, whatever made it end."""

from threading import Event

import numpy as np
import pytest

from ulna.engine import threads as batches
from ulna.engine.threads import LEAST_POSES, in_parts
from ulna.errors import InputError

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


LONG = {
    "forward_kinematics": lambda arm, q: arm.forward_kinematics(q),
    "link_poses": lambda arm, q: arm.link_poses(q),
    "jacobian": lambda arm, q: arm.jacobian(q, expressed_in="link"),
    "differential_ik": lambda arm, q: arm.differential_ik(q, q[..., :6], dt=0.01),
}


@pytest.fixture
def three_threads(monkeypatch):
    monkeypatch.setattr(batches, "n_processors", lambda: 3)


@pytest.mark.usefixtures("three_threads")
@pytest.mark.parametrize("name", LONG)
def test_a_batch_that_threads_share_has_the_rows_of_small_ones(panda, name, monkeypatch):
    parts, pool = [], batches._pool
    monkeypatch.setattr(batches, "_pool", lambda *numbers: parts.append(numbers) or pool(*numbers))
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (3 * LEAST_POSES + 5, panda.n_dof))
    whole = LONG[name](panda, q)
    assert parts, "no threads"
    for start in (0, LEAST_POSES - 40, 2 * LEAST_POSES, len(q) - 77):
        assert np.array_equal(whole[start : start + 77], LONG[name](panda, q[start : start + 77]))


@pytest.mark.usefixtures("three_threads")
@pytest.mark.parametrize("name", LONG)
def test_a_row_out_of_range_is_told_whichever_thread_meets_it(panda, name):
    q = np.tile(panda.home, (3 * LEAST_POSES, 1))
    q[-1, 2] = np.nan
    with pytest.raises(InputError, match=rf"q\[{len(q) - 1}, 2\]"):
        LONG[name](panda, q)
