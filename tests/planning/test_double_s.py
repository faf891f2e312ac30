"""The times of a line with limits of velocity, acceleration and jerk, against worked numbers of an independent implementation."""

import pytest

from ulna.planning.timing import double_s

# Length, velocity, acceleration, jerk; the duration by ruckig 0.19.4 (Berscheid and Kroeger 2021).
# Each case has other phases.
CASES = {
    "all seven phases": ((2.0, 1.0, 2.0, 10.0), 2.7),
    "the acceleration is not reached": ((2.0, 1.0, 5.0, 10.0), 2.632455532033676),
    "the velocity is not reached": ((0.5, 2.0, 1.0, 10.0), 1.5177446878757825),
    "neither is reached": ((0.01, 2.0, 1.0, 10.0), 0.3174802103936399),
    "no limit of velocity": ((1.0, 1e9, 3.0, 100.0), 1.1850901840693364),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_the_duration_is_that_of_ruckig(case):
    arguments, duration = case
    assert double_s(*arguments)[0].sum() == pytest.approx(duration, rel=1e-12)
