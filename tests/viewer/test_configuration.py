"""q as text, written to a file and read from one."""

import numpy as np
import pytest

import ulna
from ulna.viewer.move_panel import as_text, first_row
from ulna.viewer.stage import floor_height


def test_a_saved_q_is_loaded_to_the_last_bit(panda, rng):
    for q in rng.uniform(panda.lower, panda.upper, (20, 7)):
        assert np.array_equal(first_row(f"{as_text(q)}\n".encode(), panda), q)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"1, 2", "2 numbers, but 7 comma-separated numbers"),
        (b"", "0 numbers"),
        (b"a, b", "comma-separated numbers"),
        (b"\xff\xfe", "comma-separated numbers"),
    ],
)
def test_a_file_without_a_valid_q_is_refused(panda, content, message):
    with pytest.raises(ulna.UlnaError, match=message):
        first_row(content, panda)


def test_a_floor_lies_below_the_base():
    robot = ulna.load("ur5").with_convex_hulls()
    world = ulna.World()
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, floor_height(robot, 0.0))))
    pairs = robot.check_collision(robot.home, world, self_collision=False, max_distance=0.01).pairs
    (base,) = (pair for pair in pairs if pair.link_a == "base_link")
    assert base.signed_distance == pytest.approx(1e-3, abs=1e-5)
