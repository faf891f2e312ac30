"""The way of the box in the video of RViz, without ROS."""

from itertools import groupby

import numpy as np
import pytest

from ulna.demo.ros.drags import DRAGS, GRIPS, steps
from ulna.demo.scenario import BOX_START, RATE_HZ, Demo
from ulna.description.pose import pose


@pytest.mark.parametrize("n", [60, 120, 301])
def test_every_frame_has_its_step_and_the_box_ends_where_it_began(n):
    found = list(steps(n))
    assert len(found) == n
    moved = [step for step in found if step is not None]
    np.testing.assert_allclose(moved[-1].T_base_box, pose(BOX_START), atol=1e-12)
    assert [event for step in moved for event in step.events if event != "POSE_UPDATE"] == ["MOUSE_DOWN", "MOUSE_UP"] * len(DRAGS)
    for step in moved:
        np.testing.assert_allclose(step.pointer, (step.T_base_box @ [*GRIPS[step.handle], 1.0])[:3], atol=1e-12)


def test_an_arrow_moves_the_box_along_its_own_axis_and_a_ring_turns_it_about_it():
    assert {step.handle for step in steps(300) if step is not None} == {"move_x", "move_y", "move_z", "rotate_z"}
    for handle, drag in {drag.handle: drag for drag in DRAGS}.items():
        axis, T = "xyz".index(handle[-1]), drag.moved(1.0)
        unit = np.eye(3)[axis]
        if handle.startswith("move"):
            np.testing.assert_allclose(T, [[1, 0, 0, T[0, 3]], [0, 1, 0, T[1, 3]], [0, 0, 1, T[2, 3]], [0, 0, 0, 1]])
            np.testing.assert_allclose(T[:3, 3], drag.way * unit)
        else:
            np.testing.assert_allclose(T[:3, 3], 0.0)
            np.testing.assert_allclose(T[:3, :3] @ unit, unit, atol=1e-12)
            assert np.trace(T[:3, :3]) == pytest.approx(1 + 2 * np.cos(drag.way))


@pytest.mark.parametrize("seconds", [6, 12, 30, 60])
def test_the_box_touches_hand_forearm_elbow_and_base_with_no_long_stretch_of_one_color(seconds):
    demo, T, touched, colors = Demo(), pose(BOX_START), set(), []
    for k, step in enumerate(steps(round(seconds * RATE_HZ)), start=1):
        T = T if step is None else step.T_base_box
        demo.move_box(T)
        report = demo.check(demo.trajectory.at(k / RATE_HZ))
        colors.append(report.in_collision)
        touched |= set(report.touching)
    assert touched >= {"box 12", "box 8", "box 7", "box 2"}  # of the hand, the forearm, the elbow and the base
    assert not colors[0]
    assert not colors[-1]
    longest = max(len(list(same)) for _, same in groupby(colors))
    assert longest <= 0.2 * len(colors)
    assert len(list(groupby(colors))) >= 9  # the light turns red four times or more, and green again
