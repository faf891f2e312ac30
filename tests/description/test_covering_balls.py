"""``robot.with_spheres()``: balls that contain a mesh and what it encloses, and reach no farther beyond it than said."""

import pickle

import numpy as np
import pytest
import trimesh

import ulna
from ell_mesh import CORNERS, FACES, cache, robot_of_the_ell
from matrix import matrix
from ulna.description.meshes import spheres
from ulna.description.meshes.cover import cover
from ulna.description.meshes.filled_solid import FilledSolid, wound_alike
from ulna.description.meshes.hulls import in_place_of_meshes, mesh_reader
from ulna.description.meshes.mesh_files import MeshFiles

ELL = trimesh.Trimesh(CORNERS, FACES, process=False)
THICK = trimesh.creation.icosphere(3, 1.0)
TORUS = trimesh.creation.torus(1.0, 0.3, major_sections=24, minor_sections=12)
CAPPED = trimesh.creation.cylinder(0.5, 2.0, sections=16)
SOLIDS = {"an L": (ELL, 0.2), "a ball": (THICK, 0.1), "a torus": (TORUS, 0.1), "a cylinder": (CAPPED, 0.15)}
URDF = """<robot name="l"><link name="base"/><link name="part"><collision name="ell">
  <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><geometry><mesh filename="ell.obj" scale="{}"/></geometry></collision>
  <collision name="bar"><origin xyz="0 0 5"/><geometry><cylinder radius="0.1" length="1"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="part"/><axis xyz="0 0 1"/>
  <limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"""


__all__ = ["cache"]


@pytest.fixture
def make(tmp_path, cache):
    """The robot of an L-shaped mesh and a cylinder."""

    def robot(scale="1 1 1"):
        return robot_of_the_ell(tmp_path, URDF.format(scale))

    return robot


def outside(balls, points):
    """How far each point lies outside the nearest ball."""
    return np.min([np.linalg.norm(points - ball[:3], axis=1) - ball[3] for ball in balls], axis=0)


def in_the_ell(points):
    x, y, z = points.T
    return (z >= 0) & (z <= 1) & (np.minimum(x, y) >= 0) & (np.minimum(x, y) <= 1) & (np.maximum(x, y) <= 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", matrix(list(SOLIDS), 2))
def test_every_sampled_point_of_the_surface_and_of_the_volume_is_in_a_ball(name):
    mesh, within = SOLIDS[name]
    balls = cover(np.asarray(mesh.vertices), np.asarray(mesh.faces), within)
    surface = trimesh.sample.sample_surface(mesh, 20_000, seed=1)[0]
    low, high = mesh.bounds
    volume = np.random.default_rng(1).uniform(low, high, (1_500, 3))
    volume = volume[np.abs([trimesh_winding(mesh, point) for point in volume]) > 0.5]
    assert len(volume) > 100
    assert outside(balls, np.concatenate([surface, mesh.vertices, volume])).max() <= 1e-9


def trimesh_winding(mesh, point):
    """The solid angles of the triangles from a point, by the formula for their dihedral angles, over 4 pi."""
    a, b, c = (one / np.linalg.norm(one, axis=1, keepdims=True) for one in (mesh.triangles - point).transpose(1, 0, 2))
    sides = [np.arccos(np.clip((one * other).sum(axis=1), -1, 1)) for one, other in ((b, c), (c, a), (a, b))]
    half = sum(sides) / 2
    product = np.tan(half / 2) * np.prod([np.tan((half - side) / 2) for side in sides], axis=0)
    angles = 4 * np.arctan(np.sqrt(np.maximum(product, 0.0)))  # L'Huilier
    return (angles * np.sign(np.einsum("ij,ij->i", a, np.cross(b, c)))).sum() / (4 * np.pi)


@pytest.mark.slow
@pytest.mark.parametrize("name", matrix(list(SOLIDS), 2))
def test_no_sampled_point_of_a_ball_is_farther_from_the_solid_than_said(name):
    mesh, within = SOLIDS[name]
    balls = cover(np.asarray(mesh.vertices), np.asarray(mesh.faces), within)
    directions = np.random.default_rng(2).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = (balls[:, None, :3] + balls[:, None, 3:] * directions).reshape(-1, 3)
    closest = np.full(len(points), np.inf)
    for triangle in mesh.triangles:
        nearest = trimesh.triangles.closest_point(np.repeat(triangle[None], len(points), axis=0), points)
        closest = np.minimum(closest, np.linalg.norm(nearest - points, axis=1))
    far = np.flatnonzero(closest > within)
    assert all(abs(trimesh_winding(mesh, points[k])) > 0.5 for k in far), "what is farther from the surface is within it"
    assert closest.max() > 0.9 * within


def test_the_middle_of_a_thick_solid_that_its_surface_leaves_open_is_in_a_ball():
    """Balls about the corners of a cube are enough for its surface. Those that its middle needs are found by a power diagram."""
    from ulna.description.meshes.cover import _uncovered

    cube = trimesh.creation.box((2.0, 2.0, 2.0))
    solid = FilledSolid(np.asarray(cube.vertices), np.asarray(cube.faces))
    grid = np.array([(x, y, z) for x in (-0.7, 0, 0.7) for y in (-0.7, 0, 0.7) for z in (-0.7, 0, 0.7) if (x, y, z) != (0, 0, 0)])
    shell = np.column_stack([grid, np.full(len(grid), 0.6)])
    shell = shell[np.abs(grid).max(axis=1) > 0]
    voids = _uncovered(shell, solid, 1e-9)
    assert np.linalg.norm(voids, axis=1).min() < 1e-6
    assert not len(_uncovered(np.concatenate([shell, [(0, 0, 0, 0.9)]]), solid, 1e-9))


def test_a_hole_is_closed_and_a_cavity_is_filled():
    cube = trimesh.creation.box((2.0, 2.0, 2.0))
    cavity = trimesh.creation.box((1.0, 1.0, 1.0))
    cavity.invert()
    both = trimesh.util.concatenate([cube, cavity])
    opened = np.asarray(both.faces)[1:]
    solid = FilledSolid(np.asarray(both.vertices), opened)
    assert solid.depth(np.zeros(3)) == pytest.approx(1.0)
    assert solid.depth(np.array([0.75, 0.1, 0.2])) == pytest.approx(0.25)
    assert solid.depth(np.array([2.0, 1.0, 0.0])) == pytest.approx(-1.0)
    assert solid.depth(np.array([2.0, 2.0, 0.0])) == pytest.approx(-np.sqrt(2.0))


@pytest.mark.parametrize("triangles", [[(0, 1, 2)], [(0, 1, 2), (0, 2, 1)], [(0, 1, 2), (0, 1, 1)]])
def test_a_surface_without_volume_is_covered_too(triangles):
    corners = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)])
    balls = cover(corners, np.array(triangles), 0.2)
    shares = np.random.default_rng(0).dirichlet((1, 1, 1), 5000)
    assert outside(balls, shares @ corners).max() <= 1e-9
    assert balls[:, 3].max() <= 0.2
    assert np.abs(balls[:, 2]).max() < 0.2


def test_the_balls_of_a_robot_cover_the_scaled_mesh_in_its_place_and_the_cylinder_stays(make):
    robot = make("2 -1 1").with_spheres(within=0.3)
    *balls, bar = robot.description.links[1].collisions
    assert isinstance(bar.shape, ulna.Cylinder)
    assert bar.excess is None
    assert [ball.name for ball in balls] == [f"ell ball {k}" for k in range(1, len(balls) + 1)]
    assert all(isinstance(ball.shape, ulna.Sphere) and ball.excess == 0.3 for ball in balls)
    points = np.random.default_rng(3).uniform((0, 0, 0), (3, 3, 1), (3000, 3))
    points = points[in_the_ell(points)] * (2, -1, 1) @ ulna.pose((0, 0, 0), (0, 0, np.pi / 2))[:3, :3].T + (1, 0, 0)
    centers = np.array([(*ball.pose[:3, 3], ball.shape.radius) for ball in balls])
    assert outside(centers, points).max() <= 1e-9


@pytest.mark.slow
def test_a_free_verdict_holds_for_the_hulls_of_the_arms_of_an_l(make):
    """Random balls beside the robot: where the covering balls are free of one, so are the two boxes that the L is."""
    robot, world, free = make().with_spheres(within=0.15), ulna.World(), 0
    world.add("ball", ulna.Sphere(0.4), ulna.pose((0, 0, 0)))
    random = np.random.default_rng(5)
    for center in random.uniform((-4, -4, -1), (4, 4, 2), (200, 3)):
        world.move("ball", ulna.pose(center))
        q = random.uniform(-3, 3, (50, 1))
        verdicts = robot.in_collision(q, world)
        free += (~verdicts).sum()
        in_part = np.einsum("nji,nj->ni", robot.forward_kinematics(q, link="part")[:, :3, :3], np.tile(center, (50, 1))) - (
            1,
            0,
            0,
        )
        at = in_part @ ulna.pose((0, 0, 0), (0, 0, np.pi / 2))[:3, :3]
        for high in ((3, 1, 1), (1, 3, 1)):
            touching = np.linalg.norm(at - np.clip(at, 0, high), axis=1) <= 0.4
            assert not (touching & ~verdicts).any()
    assert free > 2000


def test_balls_are_kept_by_content_scale_and_within_and_pickled(make, cache, monkeypatch):
    first = make().with_spheres(within=0.3)
    [kept] = cache.iterdir()
    again = pickle.loads(pickle.dumps(first))  # noqa: S301
    with monkeypatch.context() as patch:
        patch.setattr("ulna.description.meshes.cover.cover", None)  # not called
        loaded = make().with_spheres(within=0.3)
    kept.write_bytes(b"damaged")
    anew = make().with_spheres(within=0.3)
    for other in (again, loaded, anew):
        for one, two in zip(first.description.links[1].collisions, other.description.links[1].collisions, strict=True):
            assert (one.name, one.shape, one.excess) == (two.name, two.shape, two.excess)
            assert np.array_equal(one.pose, two.pose)
    make().with_spheres(within=0.4)
    make("1 1 2").with_spheres(within=0.3)
    assert len(list(cache.iterdir())) == 3


def test_a_budget_names_what_can_be_had(make):
    robot = make()
    with pytest.raises(
        ulna.GeometryError, match=r"balls are needed to cover ell\.obj within 300 mm, and most=20; within="
    ) as caught:
        robot.with_spheres(within=0.3, most=20)
    within = float(str(caught.value).split("within=")[1].split(" ")[0])
    assert 0 < len(robot.with_spheres(within=within * 1.001, most=20).description.links[1].collisions) - 1 <= 20


@pytest.mark.parametrize("within", [0, -0.1, np.nan, np.inf, "wide", None, [0.1]])
def test_a_within_that_is_no_distance_is_refused(make, within):
    with pytest.raises(ulna.InputError, match="within"):
        make().with_spheres(within=within)


@pytest.mark.parametrize("most", [0, -1, 2.5, True, "few"])
def test_a_budget_that_is_no_count_is_refused(make, most):
    with pytest.raises(ulna.InputError, match="most"):
        make().with_spheres(within=0.5, most=most)


def test_a_within_too_small_for_the_mesh_is_refused(make):
    with pytest.raises(ulna.GeometryError, match=r"within=0\.0001 is too small for ell\.obj"):
        make().with_spheres(within=1e-4)


def test_a_robot_without_meshes_is_unchanged_and_without_shapes_still_refused():
    panda = ulna.load("panda").with_spheres(within=0.01)
    assert panda.collision_names == ulna.load("panda").collision_names
    bare = ulna.load('<robot name="r"><link name="l"/></robot>').with_spheres()
    with pytest.raises(ulna.GeometryError, match="no collision shapes"):
        bare.in_collision([])


def test_a_mesh_that_is_not_there_is_named(make, tmp_path):
    robot = make()
    (tmp_path / "ell.obj").unlink()
    with pytest.raises(ulna.FileError, match=r"ell\.obj"):
        robot.with_spheres()


def test_what_is_checked_in_place_of_meshes_is_said(make):

    robot = make().with_spheres(within=0.3)
    n = len(robot.collision_names) - 1
    expected = f"collision by {n} balls that cover meshes, and stand out by 300.0 mm at most"
    assert in_place_of_meshes(robot.description) == expected
    assert spheres.balls_of_file(robot.description.folder / "ell.obj", (1.0, 1.0, 1.0), 0.3).shape == (n, 4)


@pytest.mark.slow
def test_sampled_points_of_the_meshes_of_a_ur5_are_in_the_balls_of_their_links(cache):
    robot = ulna.load("ur5")
    covered = robot.with_spheres(within=0.04)
    files, reader = MeshFiles(robot.description), mesh_reader()
    for before, after in zip(robot.description.links, covered.description.links, strict=True):
        for body in before.collisions:
            if isinstance(body.shape, ulna.Mesh):
                path = files.find(body.shape.uri)
                mesh = trimesh.Trimesh(*reader.merged(reader.read_scene(path, reader.mesh_bytes(path))), process=False)
                balls = np.array([(*one.pose[:3, 3], one.shape.radius) for one in after.collisions])
                points = trimesh.sample.sample_surface(mesh, 3000, seed=1)[0] * body.shape.scale
                assert outside(balls, points @ body.pose[:3, :3].T + body.pose[:3, 3]).max() <= 1e-9


def mixed(faces, rng):
    """The faces, about half of them turned round."""
    return np.where(rng.random(len(faces))[:, None] < 0.5, faces[:, ::-1], faces)


@pytest.mark.parametrize("name", list(SOLIDS))
def test_a_mesh_of_mixed_winding_encloses_what_the_mesh_wound_well_does(name, rng):
    solid, _ = SOLIDS[name]
    faces = mixed(solid.faces, rng)
    mended = wound_alike(faces)
    assert trimesh.Trimesh(solid.vertices, mended, process=False).is_winding_consistent
    well, mended = FilledSolid(solid.vertices, solid.faces), FilledSolid(solid.vertices, faces)
    points = rng.uniform(*solid.bounds, (100, 3))
    for point in points:
        assert mended.depth(point) == pytest.approx(well.depth(point), abs=1e-12)
    assert sum(well.depth(point) > 0 for point in points) > 10


def test_a_mesh_of_mixed_winding_is_covered_by_few_balls(rng):
    well = cover(CAPPED.vertices, CAPPED.faces, 0.3)
    balls = cover(CAPPED.vertices, mixed(CAPPED.faces, rng), 0.3)
    assert len(balls) <= 1.2 * len(well)
    points = rng.uniform(*CAPPED.bounds, (2000, 3))
    points = points[np.hypot(points[:, 0], points[:, 1]) < 0.5 * np.cos(np.pi / 16)]
    assert outside(balls, points).max() <= 0.0


def test_faces_that_are_wound_alike_or_have_one_side_only_stay_as_they_are(rng):
    assert wound_alike(TORUS.faces) is TORUS.faces
    strip = np.array([[2 * k, 2 * k + 1, 2 * k + 2] for k in range(9)] + [[2 * k + 1, 2 * k + 3, 2 * k + 2] for k in range(9)])
    band = np.where(strip == 18, 1, np.where(strip == 19, 0, strip))  # a Moebius band
    assert np.array_equal(wound_alike(band), band)
    two = np.concatenate([CAPPED.faces, CAPPED.faces[:, ::-1] + len(CAPPED.vertices)])  # each part alike, one inside out
    assert np.array_equal(wound_alike(two), two)
