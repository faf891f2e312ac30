"""Scene files: what is written is read again, and what is wrong is said with its place."""

import dataclasses
import json

import numpy as np
import pytest

import ulna
from ulna.collision.scene_file import load_world, save_world, world_from_json, world_to_json
from ulna.description.pose import matrix_from_quaternion
from ulna.errors import DescriptionError, FileError

POINTS = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
SHAPES = [
    ulna.Box((0.15, 0.09, 0.126)),
    ulna.Sphere(1 / 3),
    ulna.Cylinder(0.1, 0.0),
    ulna.Capsule(0.1, 0.7),
    ulna.ConvexMesh(POINTS),
    ulna.HalfSpace(),
    ulna.PointCloud(POINTS, 0.01),
    ulna.HeightMap([[0.1, 0.2], [0.3, 1 / 3]], 0.05),
    ulna.VoxelGrid([[[0, 1], [1, 1]]], 0.05, corner=(0.1, 1 / 3, 0)),
]


NESTED: list = []
for _ in range(300):
    NESTED = [NESTED]


def scene(**entry):
    return json.dumps({"ulna_scene": 1, "objects": [{"name": "crate", "shape": "box", "extents": [1, 2, 3], **entry}]})


class Fickle(ulna.World):
    """A world that another thread empties as soon as somebody has its names."""

    @property
    def names(self):
        names = super().names
        for name in names:
            self.remove(name)
        return names


def test_a_world_that_changes_meanwhile_is_written_as_it_was_at_one_moment():
    world = Fickle()
    world.add("ball", ulna.Sphere(0.1))
    assert world_from_json(world_to_json(world)).names == ("ball",)


def test_the_objects_of_one_moment_are_in_order_and_ones_own():
    world = ulna.World()
    world.add("b", ulna.Sphere(0.1), ulna.pose((1, 2, 3)))
    world.add("a", ulna.Box((1, 1, 1)))
    items = world.items()
    assert [(name, shape) for name, shape, _ in items] == [("b", ulna.Sphere(0.1)), ("a", ulna.Box((1, 1, 1)))]
    items[0][2][:] = 0.0
    assert np.array_equal(world.pose("b"), ulna.pose((1, 2, 3)))


def test_a_world_comes_back_equal_to_the_last_digit(tmp_path, rng):
    world = ulna.World()
    for k in range(60):
        T = (
            ulna.pose(rng.normal(size=3), wxyz=rng.normal(size=4))
            if k % 2
            else ulna.pose(rng.normal(size=3), rng.normal(size=3).round(2))
        )
        world.add(f"thing {k} é", SHAPES[k % len(SHAPES)], T)
    save_world(world, tmp_path / "scene.json")
    again = load_world(tmp_path / "scene.json")
    assert again.names == world.names
    for name in world.names:
        assert np.array_equal(again.pose(name), world.pose(name))
        one, other = again.shape(name), world.shape(name)
        assert type(one) is type(other)
        assert all(np.array_equal(getattr(one, field.name), getattr(other, field.name)) for field in dataclasses.fields(other))
    assert world_to_json(again) == world_to_json(world)


def test_angles_that_a_person_typed_are_written_as_they_were():
    world = world_from_json(scene(xyz=[0.5, 0, 0.25], rpy=[0.1, -0.2, 1.5]))
    entry = json.loads(world_to_json(world))["objects"][0]
    assert entry == {"name": "crate", "shape": "box", "extents": [1, 2, 3], "xyz": [0.5, 0, 0.25], "rpy": [0.1, -0.2, 1.5]}


def test_a_turn_may_be_given_in_three_ways():
    turn = matrix_from_quaternion((0.5, 0.5, 0.5, 0.5))
    for way in ({"wxyz": [1, 1, 1, 1]}, {"rotation": turn.tolist()}, {"rpy": [np.pi / 2, 0, np.pi / 2]}):
        assert np.allclose(world_from_json(scene(**way)).pose("crate")[:3, :3], turn, atol=1e-15)


def test_an_empty_world_is_a_scene_too():
    assert world_from_json(world_to_json(ulna.World())).names == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (scene(extent=1), r"scene: object 1 'crate': key 'extent' is not known; did you mean 'extents'"),
        (scene(shape="bix"), r"object 1 'crate': 'bix' is not a known shape; did you mean 'box'"),
        (scene(shape=["box"]), "is not a known shape"),
        (scene(shape="sphere"), "key 'extents' is not known"),
        (scene(extents=[1, 2]), "object 1 'crate': extents: "),
        (scene(extents=[1, 2, -3]), "extents: "),
        (scene(extents="big"), "extents: "),
        (scene(xyz=[0, 0]), "object 1 'crate': xyz: "),
        (scene(rpy=[0, 0, 0], wxyz=[1, 0, 0, 0]), "rpy and wxyz are given"),
        (scene(rotation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]), "reflection"),
        (scene(rotation=[[1, 0], [0, 1]]), "rotation: three rows"),
        (scene(name=""), "object 1 has no name"),
        ('{"ulna_scene": 1, "objects": [3]}', "object 1 is 3"),
        ('{"ulna_scene": 1, "objects": [{"name": "a", "shape": "sphere"}]}', "object 1 'a': a sphere needs 'radius'"),
        ('{"ulna_scene": 1, "objects": [{"name": "a", "shape": "sphere", "radius": NaN}]}', "NaN is not a finite number"),
        ('{"ulna_scene": 1, "objects": [], "objets": []}', "the scene: key 'objets' is not known; did you mean 'objects'"),
        ('{"ulna_scene": 1, "objects": [{"name": "a", "name": "b"}]}', "key 'name' is given twice in one object"),
        ('{"ulna_scene": 2, "objects": []}', '"ulna_scene" is 2; this version'),
        ("[]", "is not a scene"),
        ('{"ulna_scene": 1,\n "objects": [}', "scene:2: is not valid JSON"),
        ("[" * 100_000, "is not valid JSON"),
        (scene(extents=NESTED), "is not valid JSON: it has more than 50 levels"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(text, said):
    with pytest.raises(DescriptionError, match=said.replace("[", r"\[")):
        world_from_json(text)


def test_two_objects_of_one_name_are_refused():
    entry = {"name": "a", "shape": "sphere", "radius": 1}
    with pytest.raises(DescriptionError, match="object 2 'a': name: the world already has"):
        world_from_json(json.dumps({"ulna_scene": 1, "objects": [entry, entry]}))


def test_a_name_that_can_be_sent_to_no_file_and_no_page_is_refused(panda):
    with pytest.raises(ulna.InputError, match=r"name: '\\ud800' has a character that cannot be written"):
        ulna.World().add("\ud800", ulna.Sphere(0.1))
    with pytest.raises(ulna.InputError, match="cannot be written"):
        panda.with_attached("a\udfff", ulna.Sphere(0.1), ulna.pose())
    with pytest.raises(ulna.UlnaError, match="cannot be written"):
        world_from_json(scene(name="\ud800"))


@pytest.mark.parametrize("control", [*"\u202a\u202d\u202e\u2066\u2069"])
def test_a_name_that_reorders_its_letters_is_refused(panda, control):
    name = f"safe{control}egac"
    with pytest.raises(ulna.InputError, match="changes the order of letters") as caught:
        ulna.World().add(name, ulna.Sphere(0.1))
    assert control not in str(caught.value)
    with pytest.raises(ulna.UlnaError, match="changes the order of letters"):
        panda.with_attached(name, ulna.Sphere(0.1), ulna.pose())
    with pytest.raises(ulna.UlnaError, match="changes the order of letters"):
        ulna.load(f'<robot name="r"><link name="{name}"/></robot>')


def test_lists_in_lists_without_end_are_refused_as_numbers():
    nested = NESTED
    for _ in range(5000):
        nested = [nested]
    with pytest.raises(ulna.InputError, match="extents"):
        ulna.Box(nested)


def test_files_that_cannot_be_read_or_written_are_named(tmp_path):
    with pytest.raises(FileError, match=r"none\.json"):
        load_world(tmp_path / "none.json")
    with pytest.raises(FileError, match="no folder"):
        save_world(ulna.World(), tmp_path / "no folder" / "scene.json")


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "scene.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DescriptionError, match=r"scene\.json: is not valid JSON"):
        load_world(tmp_path / "scene.json")
