"""The demo without a screen."""

from ulna.demo.scenario import make_trajectory


def test_the_arm_does_not_touch_itself_along_the_trajectory(panda):
    assert not panda.in_collision(make_trajectory(panda).samples).any()
