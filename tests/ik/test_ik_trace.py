"""The trace of a search: its errors are those of its path, and it ends at the result."""

import numpy as np
import pytest

import formulas
from ulna import InputError


def errors(panda, q, T):
    """The position and the rotation error, as a trace has them."""
    error = formulas.pose_error(panda.description, q, panda.tip, T)
    return np.linalg.norm(error[:3]), np.linalg.norm(error[3:])


def test_a_trace_of_levenberg_marquardt_ends_at_the_result_below_where_it_began(panda, targets):
    for T in targets:
        result = panda.inverse_kinematics(T, trace=True)
        trace = result.trace
        assert trace.shape == (result.iterations + 1, 4)
        assert trace[-1, :2] == pytest.approx([result.position_error, result.rotation_error], abs=1e-11)
        assert trace[0, 2] == 0.0
        squares = (trace[:, :2] ** 2).sum(axis=1)
        assert squares[-1] < squares[0]
        np.testing.assert_allclose(trace[:, 3], 0.05 * squares + 1e-12, rtol=1e-6, atol=1e-12)


def test_a_trace_from_a_seed_begins_with_the_seeds_own_error(panda, targets, q):
    for T, x in zip(targets, np.clip(q + 0.05, panda.lower, panda.upper), strict=True):
        trace = panda.inverse_kinematics(T, q_seed=x, trace=True).trace
        assert trace[0, :2] == pytest.approx(errors(panda, x, T), abs=1e-12)


def test_a_trace_is_of_one_target_and_only_if_asked_for(panda, targets):
    with pytest.raises(InputError, match=r"^trace: a trace is of one target"):
        panda.inverse_kinematics(targets, trace=True)
    with pytest.raises(AttributeError, match=r"trace=True"):
        _ = panda.inverse_kinematics(targets[0]).trace


def test_a_trace_of_what_was_not_met_ends_at_the_result_too(panda, targets):
    """To a tenth of a millimeter: where no target calms the steps, the rounding of the replay grows."""
    refused = 0
    for T in targets:
        result = panda.inverse_kinematics(T, q_seed=panda.home, max_step=0.3, trace=True)
        assert result.trace[-1, :2] == pytest.approx([result.position_error, result.rotation_error], abs=1e-4)
        refused += not result.success
    assert refused > 20


def test_a_trace_with_a_posture_ends_at_the_result_whichever_round_led_there(panda, rng):
    """Where the start with the posture fails, the same seed starts again without: the trace is of that start."""
    for _ in range(40):
        q = rng.uniform(panda.lower, panda.upper)
        seed = np.clip(q + 0.2 * rng.normal(size=7), panda.lower, panda.upper)
        result = panda.inverse_kinematics(panda.forward_kinematics(q), seed, posture="mid_range", trace=True)
        assert result.trace[-1, :2] == pytest.approx([result.position_error, result.rotation_error], abs=1e-6)
