"""The way of the box in the video of RViz, without ROS."""

import numpy as np
import pytest

from ulna.demo.ros.drags import DRAGS, GRIP, steps
from ulna.demo.scenario import BOX_START


@pytest.mark.parametrize("n", [30, 120, 301])
def test_every_frame_has_its_step_and_the_box_ends_where_it_began(n):
    found = list(steps(n))
    assert len(found) == n
    moved = [step for step in found if step is not None]
    np.testing.assert_allclose(moved[-1].box, BOX_START, atol=1e-12)
    assert [event for step in moved for event in step.events if event != "POSE_UPDATE"] == ["MOUSE_DOWN", "MOUSE_UP"] * len(DRAGS)
    assert all(np.linalg.norm(step.pointer - step.box) == pytest.approx(GRIP) for step in moved)
