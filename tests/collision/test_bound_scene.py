"""Entries bound to a scene: what they return is what they return with the scene, and every scene has the types they declare."""

import numpy as np
import pytest

import ulna
from ulna.collision.bound_scene import BoundScene
from ulna.collision.entries import contacts, continuous, nearest, overlap
from ulna.engine import bound
from ulna.engine.signatures import fits
from ulna.kernels.collision.scene import BOXES, SHAPES, NearestPair


def worlds(rng):
    """Of boxes, of all shapes, with a tree of many, and with a cloud."""
    boxes, shapes, many = ulna.World(), ulna.World(), ulna.World()
    boxes.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0, 0.3)))
    shapes.add("ball", ulna.Sphere(0.1), ulna.pose((0.4, 0.2, 0.5)))
    shapes.add("hull", ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]), ulna.pose((0.4, 0, 0.5)))
    shapes.add("cloud", ulna.PointCloud(rng.uniform(0.3, 1.5, (200, 3)), 0.01))
    for k in range(80):
        many.add(f"box {k}", ulna.Box((0.1, 0.05, 0.02)), ulna.pose(rng.uniform(-0.8, 0.8, 3)))
    return {"none": None, "empty": ulna.World(), "boxes": boxes, "shapes": shapes, "many": many}


def results(call, q):
    """What each entry returns and writes; ``call(entry, ...)`` calls it."""
    n, written = len(q), []
    for entry, *out in (
        (overlap.overlap_batch, np.zeros(n, np.bool_)),
        (nearest.nearest_batch, NearestPair.records(n)),
        (continuous.edges_each, q + 0.1, 1e-4, np.zeros(n, np.int64), np.zeros(n)),
        (contacts.contacts_each, np.arange(n), np.tile([0, 5], (n, 1)), np.zeros((n, 10)), np.zeros((n, 7))),
    ):
        assert call(entry, q, *out)
        written += [each for each in out if isinstance(each, np.ndarray)]
    return [call(overlap.overlap_one, one) for one in q], [array.tobytes() for array in written]


def test_a_bound_entry_returns_what_it_returns_with_the_scene(panda, rng):
    q = panda.random(9, seed=1)
    for world in worlds(rng).values():
        scene = panda._checker.scene_of(world, True)
        bound_to = BoundScene(scene)
        with_scene = results(lambda entry, *rest, scene=scene: entry(scene, *rest), q)
        assert results(lambda entry, *rest, to=bound_to: to.bound(entry)(*rest), q) == with_scene


@pytest.mark.parametrize("name", ["none", "empty", "boxes", "shapes", "many"])
def test_a_scene_has_the_types_of_the_signature_that_is_chosen(panda, rng, name):
    """A bound entry looks at them no more."""
    no_joint = ulna.load(
        '<robot name="post"><link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>'
    )
    tool = panda.with_attached("tool", ulna.Sphere(0.02), np.eye(4))
    world = worlds(rng)[name]
    for robot in (panda, tool, no_joint):
        for itself in (True, False) if world is not None else (True,):
            scene = robot._checker.scene_of(world, itself)
            assert [fits(scene, kind) for kind in (BOXES, SHAPES)] == [scene.vertices is None, scene.vertices is not None]


@pytest.mark.compiler
def test_a_scene_of_other_types_is_not_bound(panda, monkeypatch):
    monkeypatch.setattr(bound, "_machine_code", {})
    scene = panda._checker.scene_of(ulna.World(), True)
    with pytest.raises(TypeError, match="overlap_one: the first arguments"):
        BoundScene(scene._replace(nodes=np.zeros((0, 8), np.float32))).bound(overlap.overlap_one)
