"""The truth of a result is the answer to the question that the call asks; of a batch it is an error that says what to use."""

import numpy as np
import pytest

import ulna


@pytest.fixture(scope="module")
def reached(panda):
    return panda.forward_kinematics(panda.home)


FAR = ulna.pose((3, 0, 0))


def test_what_looks_for_a_solution_is_true_where_there_is_one(panda, reached):
    assert panda.inverse_kinematics(reached)
    assert not panda.inverse_kinematics(FAR)
    assert panda.all_solutions(reached)
    assert not panda.all_solutions(FAR)
    assert panda.follow([reached, reached])
    assert not panda.follow([reached, FAR])
    assert panda.plan(panda.home, reached)
    assert not panda.plan(panda.home, FAR)


def test_what_looks_for_a_collision_is_true_where_something_touches(panda, reached):
    world = ulna.World()
    assert not panda.check_collision(panda.home, world)
    assert not panda.edge_in_collision(panda.home, panda.home + 0.1, world)
    world.add("ball", ulna.Sphere(0.1), reached)
    assert panda.check_collision(panda.home, world)
    assert panda.edge_in_collision(panda.home, panda.home + 0.1, world)
    assert panda.in_collision(panda.home, world)
    near = ulna.World()
    near.add("ball", ulna.Sphere(0.1), ulna.pose((2, 0, 0)))
    report = panda.check_collision(panda.home, near, self_collision=False, max_distance=3.0)
    assert report.pairs
    assert not report


def test_the_truth_of_a_batch_is_an_error_that_names_the_array_to_use(panda, reached):
    batches = {
        "success": panda.inverse_kinematics([reached, FAR]),
        "in_collision": panda.edge_in_collision([panda.home] * 2, [panda.home] * 2),
    }
    for attribute, batch in {**batches, "success ": panda.all_solutions([reached, FAR])}.items():
        with pytest.raises(ulna.TruthError, match=rf"\.{attribute.strip()}\.any\(\)") as refused:
            bool(batch)
        assert isinstance(refused.value, ValueError)
        assert getattr(batch, attribute.strip()).shape == (2,)


def test_a_reason_is_a_sentence_with_data_and_false_where_there_is_none(panda, reached):
    found = (
        panda.inverse_kinematics(reached),
        panda.all_solutions(reached),
        panda.plan(panda.home, reached),
        panda.follow([reached]),
    )
    missed = panda.inverse_kinematics(FAR), panda.all_solutions(FAR), panda.plan(panda.home, FAR), panda.follow([FAR])
    for result in found:
        assert isinstance(result.reason, ulna.Reason)
        assert not result.reason
        assert str(result.reason) == ""
    for result in missed:
        assert isinstance(result.reason, ulna.Reason)
        assert len(str(result.reason)) > 10
        assert result.reason.data is not None
    assert np.isclose(missed[0].reason.data["reach_excess"], missed[0].reach_excess)
