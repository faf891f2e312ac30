"""The demo without a screen."""

from ulna.demo.scenario import make_trajectory


def test_the_trajectory_has_no_self_collision(panda):
    assert not panda.in_collision(make_trajectory(panda).samples).any()
