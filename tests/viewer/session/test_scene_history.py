"""Steps of a scene that are undone and redone; without a page."""

import numpy as np
import pytest

import ulna
from ulna.viewer.session.scene_history import SceneHistory, scene_of


@pytest.fixture
def world():
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.2, 0.3)), ulna.pose((0.5, 0, 0)), touch_links=["panda_hand"])
    return world


def plain(world):
    return {name: (shape, T.tolist(), world.touch_links(name)) for name, shape, T in world.items()}


ACTS = {
    "add": lambda world: world.add("ball", ulna.Sphere(0.1)),
    "move": lambda world: world.move("crate", ulna.pose((0, 0.5, 0))),
    "resize": lambda world: world.reshape("crate", ulna.Box((0.4, 0.2, 0.3))),
    "remove": lambda world: world.remove("crate"),
    "rename": lambda world: (
        world.add("chest", world.shape("crate"), world.pose("crate"), touch_links=world.touch_links("crate")),
        world.remove("crate"),
    ),
}


@pytest.mark.parametrize("act", ACTS.values(), ids=ACTS)
def test_a_step_is_undone_and_done_again(world, act):
    history, before = SceneHistory(world), plain(world)
    with history.step():
        act(world)
    after = plain(world)
    assert after != before
    history.undo()
    assert plain(world) == before
    assert (history.can_undo, history.can_redo) == (False, True)
    history.redo()
    assert plain(world) == after
    assert (history.can_undo, history.can_redo) == (True, False)


def test_all_steps_are_undone_in_turn_and_a_new_one_ends_the_undone(world):
    history, seen = SceneHistory(world), [plain(world)]
    for act in (ACTS["add"], ACTS["move"], ACTS["resize"], ACTS["rename"]):
        with history.step():
            act(world)
        seen.append(plain(world))
    for scene in reversed(seen[:-1]):
        history.undo()
        assert plain(world) == scene
    assert history.undo() == ()
    history.redo()
    with history.step():
        ACTS["remove"](world)
    assert not history.can_redo
    assert history.redo() == ()


def test_what_changes_nothing_is_no_step(world):
    history = SceneHistory(world)
    with history.step():
        world.move("crate", world.pose("crate"))
    assert not history.can_undo


def test_what_the_program_changes_stays(world):
    history = SceneHistory(world)
    with history.step():
        ACTS["add"](world)
    world.add("belt", ulna.Box((1, 1, 1)))  # by the program
    world.remove("ball")
    assert history.undo() == ()
    assert world.names == ("crate", "belt")
    history.redo()
    assert world.names == ("crate", "belt", "ball")


def test_steps_of_a_drag_are_of_the_dragged_object_alone(world):
    history, before = SceneHistory(world), scene_of(world)
    world.add("belt", ulna.Box((1, 1, 1)))
    for y in (0.1, 0.2, 0.3):
        world.move("crate", ulna.pose((0.5, y, 0)))
    history.add(before, {"crate": scene_of(world)["crate"]})
    assert history.undo() == ("crate",)
    assert np.array_equal(world.pose("crate"), ulna.pose((0.5, 0, 0)))
    assert "belt" in world.names


def test_at_most_a_hundred_steps_are_kept(world):
    history = SceneHistory(world)
    for k in range(1, 121):
        with history.step():
            world.move("crate", ulna.pose((k / 8, 0, 0)))
    for _ in range(130):
        history.undo()
    assert world.pose("crate")[0, 3] == 20 / 8


def test_other_acts_are_steps_between_those_of_the_obstacles(world):
    history, seen = SceneHistory(world), []
    with history.step():
        ACTS["add"](world)
    history.add_acts(lambda: seen.append("undone") or (), lambda: seen.append("done") or ())
    assert history.undo() == ()
    assert seen == ["undone"]
    assert "ball" in world.names
    history.undo()
    assert "ball" not in world.names
    history.redo()
    history.redo()
    assert seen == ["undone", "done"]
