"""The script of the demo's film: what the box touches, and how it moves."""

from itertools import groupby

import numpy as np
import pytest

from ulna.demo.film import VISITS, Script
from ulna.demo.scenario import BOX, BOX_START, Demo


@pytest.fixture(scope="module")
def demo():
    return Demo()


@pytest.mark.parametrize("seconds", [1.0, 3.0, 9.0, 30.0, 60.0, 61.7])
def test_the_light_turns_red_once_for_each_visit_whatever_the_length(demo, seconds):
    moments = list(Script(demo, seconds).moments(1200 / seconds))
    switches = [is_red for is_red, _ in groupby(moment.report.in_collision for moment in moments)]
    assert switches == [False, *[True, False] * len(VISITS)]
    touched = [
        {name for moment in visit for name in moment.report.touching}
        for is_red, visit in groupby(moments, lambda moment: moment.report.in_collision)
        if is_red
    ]
    assert all(visit.box in names for visit, names in zip(VISITS, touched, strict=True))
    assert len(set().union(*touched)) >= 8, "the light names boxes of the whole arm"


def test_the_box_moves_smoothly_and_returns_to_its_start(demo):
    story = Script(demo, 30.0)
    assert np.allclose(story.box_pose(0.0)[:3, 3], BOX_START)
    assert np.allclose(story.box_pose(0.0), story.box_pose(1.0), atol=1e-9)
    poses = np.array([story.box_pose(part) for part in np.linspace(0, 1, 3001)])
    steps = np.diff(poses[:, :3, 3], axis=0) * 100  # [m/s]
    assert np.linalg.norm(steps, axis=1).max() < 1.0
    assert np.linalg.norm(np.diff(steps, axis=0), axis=1).max() < 0.03


def test_the_box_stays_above_the_floor(demo):
    story = Script(demo, 30.0)
    for part in np.linspace(0, 1, 500):
        T = story.box_pose(part)
        assert T[2, 3] - np.abs(T[2, :3]) @ BOX.half_extents > 0.0


def test_the_moments_of_a_film_are_evenly_spaced_and_agree_with_the_checker(demo):
    story = Script(demo, 3.0)
    moments = list(story.moments(10))
    assert len(moments) == 30
    for k in (0, 7, 29):
        assert np.array_equal(moments[k].q, demo.trajectory.at(k / 10))
        assert np.allclose(moments[k].T_base_box, story.box_pose(k / 30), atol=1e-12)
        demo.move_box(moments[k].T_base_box)
        assert moments[k].report.touching == demo.check(moments[k].q).touching
