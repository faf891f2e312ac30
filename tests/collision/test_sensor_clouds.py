"""What a camera sees as a cloud: NaN, depth images, crops, voxels, no points of the robot; what is wrong is refused by name."""

import pickle

import numpy as np
import pytest

import ulna
from assertions import assert_close
from ulna.collision import checker
from ulna.collision.cloud_points import thinning
from ulna.errors import InputError, UnknownNameError

K = np.array([[500.0, 0, 319.5], [0, 510.0, 239.5], [0, 0, 1]])
T = ulna.pose((0.9, 0.1, 0.8), (np.pi - 0.4, 0.1, 0.3))
PLY = "ply\nformat ascii 1.0\nelement vertex 2\n{}end_header\n3 9 2 1\n6.5 9 5 4\n"
PCD = (
    "VERSION .7\nFIELDS {}\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT {}\nPOINTS 2\n"
    "DATA ascii\n3 9 2 1\n6.5 9 5 4\n"
)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_points_without_a_measurement_are_left_out_and_counted(rng, kind):
    image = rng.uniform(-1, 1, (12, 20, 3)).astype(kind)
    image[3, 4], image[5, :, 0], image[7, 7, 2] = np.nan, np.nan, np.nan
    cloud = ulna.PointCloud(image, 0.01)
    assert (cloud.points.dtype, cloud.n_left_out) == (kind, 22)
    assert np.array_equal(cloud.points, image.reshape(-1, 3)[~np.isnan(image).any(axis=2).ravel()])
    image[...] = 0
    assert cloud.points.any(), "the cloud has a copy"
    again = pickle.loads(pickle.dumps(cloud))  # noqa: S301
    assert np.array_equal(again.points, cloud.points)
    assert (again.points.dtype, again.n_left_out, again.points.flags.writeable) == (kind, 22, False)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_exact_zeros_of_a_camera_are_no_measurement(panda, rng, kind):
    """Many drivers write (0, 0, 0) where they see nothing: a ball there would be in the robot's base."""
    image = rng.uniform(0.5, 1.5, (12, 20, 3)).astype(kind)
    image[3, 4], image[5, :7], image[7, 7, 2] = np.nan, 0, 0
    as_list = image.reshape(-1, 3)
    for given in (image, as_list, image.tolist()):
        cloud = ulna.PointCloud(given, 0.01)
        assert cloud.n_left_out == 8
        assert np.array_equal(cloud.points, as_list[as_list.any(axis=1) & ~np.isnan(as_list).any(axis=1)])
        assert repr(cloud) == "PointCloud(232 points, radius 0.01 m, 8 left out)"
        assert repr(pickle.loads(pickle.dumps(cloud))) == repr(cloud)  # noqa: S301
    world = ulna.World()
    world.add("seen", ulna.PointCloud(image, 0.01))
    assert not panda.in_collision(panda.home, world)
    for nothing in (np.zeros((4, 5, 3)), np.zeros((5, 3)), np.full((4, 3), [[0.0], [np.nan], [0.0], [0.0]])):
        with pytest.raises(InputError, match=r"^points: all \d+ are NaN or \(0, 0, 0\): the sensor saw nothing"):
            ulna.PointCloud(nothing, 0.01)


def test_exact_zeros_of_a_sensor_whose_pose_a_file_states_are_no_measurement(rng, tmp_path):
    """Moved by the pose they would be points at the sensor."""
    points = rng.uniform(0.5, 1.5, (200, 3)).astype(np.float32)
    points[:7] = 0
    head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 200\nHEIGHT 1\n"
    head += "VIEWPOINT 0.5 0.1 1 0 1 0 0\nPOINTS 200\n"
    file = tmp_path / "seen.pcd"
    for body in (
        b"DATA binary\n" + points.tobytes(),
        b"DATA ascii\n" + "\n".join(" ".join(map(repr, p)) for p in points.tolist()).encode(),
    ):
        file.write_bytes(head.encode() + body)
        cloud = ulna.PointCloud.from_file(file, radius=0.01, from_sensor=True)
        assert (len(cloud.points), cloud.n_left_out) == (193, 7)
        assert np.allclose(cloud.points, points[7:] * [1, -1, -1] + [0.5, 0.1, 1])  # turned about x by 180 degrees


def test_one_point_of_a_list_may_be_the_origin():
    cloud = ulna.PointCloud([(0, 0, 0), (0.1, 0, 0)], 0.01)
    assert (len(cloud.points), cloud.n_left_out) == (2, 0)


def test_short_numbers_give_what_the_same_numbers_give(panda, rng):
    points, q = rng.uniform(-0.8, 0.8, (700, 3)).astype(np.float32), panda.random(40, seed=3)
    distances = []
    for given in (points, points.astype(np.float64)):
        world = ulna.World()
        world.add("cloud", ulna.PointCloud(given, 0.01), T)
        distances.append(panda.signed_distance(q, world, self_collision=False))
    assert np.array_equal(*distances)


@pytest.mark.parametrize("given", [np.empty((0, 3)), []])
def test_a_cloud_of_no_points_touches_nothing_and_moves(panda, given):
    world = ulna.World()
    world.add("seen", ulna.PointCloud(given, 0.1))
    assert not panda.in_collision(panda.home, world, self_collision=False)
    assert panda.signed_distance(panda.home, world, self_collision=False) == np.inf
    world.move("seen", T)
    world.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((9, 0, 0)))
    assert not panda.check_collision(panda.home, world, self_collision=False)
    world.update("seen", [(0.3, 0, 0.5)])
    world.move("seen", np.eye(4))
    assert panda.in_collision(panda.home, world, self_collision=False)
    world.update("seen", given)
    assert not panda.in_collision(panda.home, world, self_collision=False)
    assert len(ulna.PointCloud(given, 0.1).thinned(0.1).cropped(ulna.Box((1, 1, 1))).without(panda, panda.home).points) == 0


def test_an_update_gives_a_cloud_other_points_and_leaves_the_rest(panda, rng):
    world, points = ulna.World(), rng.uniform(-1, 1, (3, 900, 3))
    world.add("seen", ulna.PointCloud(points[0], 0.02), T, touch_links=["panda_link0"])
    world.add("other", ulna.PointCloud(points[1] + 3, 0.02))
    world.objects()
    before = world.copy()
    for given in (points[1], ulna.PointCloud(points[2], 0.03)):
        world.update("seen", given)
        fresh = ulna.World()
        cloud = given if isinstance(given, ulna.PointCloud) else ulna.PointCloud(given, 0.02)
        fresh.add("seen", cloud, T, touch_links=["panda_link0"])
        fresh.add("other", world.shape("other"))
        q = panda.random(20, seed=1)
        assert np.array_equal(panda.signed_distance(q, world), panda.signed_distance(q, fresh))
    assert np.array_equal(before.shape("seen").points, points[0])
    world.add("box", ulna.Box((1, 1, 1)), ulna.pose((5, 5, 5)))
    with pytest.raises(InputError, match=r"^name: 'box' is a Box"):
        world.update("box", points[0])
    with pytest.raises(UnknownNameError):
        world.update("nobody", points[0])
    with pytest.raises(InputError, match=r"^points: "):
        world.update("seen", points[0][:, :2])


def test_hundreds_of_updates_beside_other_clouds_leave_these_as_they_are(panda, rng):
    """The arena is full again and again; then what is in use is copied to a new one."""
    world, q = ulna.World(), panda.random(20, seed=4)
    still = rng.uniform(-1, 1, (5000, 3))
    world.add("still", ulna.PointCloud(still, 0.01))
    world.add("terrain", ulna.HeightMap(rng.uniform(-1.0, -0.5, (30, 30)), 0.05, bottom=-1.1))
    world.add("seen", ulna.PointCloud(still[:10], 0.01))
    arenas = [world.objects().layout.nodes.base]
    for _ in range(80):
        world.update("seen", rng.uniform(-1, 1, (4000, 3)))
        arenas += [] if world.objects().layout.nodes.base is arenas[-1] else [world.objects().layout.nodes.base]
    fresh = ulna.World()
    for name, shape, pose in world.items():
        fresh.add(name, shape, pose)
    assert len(arenas) > 3
    assert np.array_equal(panda.signed_distance(q, world), panda.signed_distance(q, fresh))
    assert {world.objects().layout.names[int(number)] for number in world.objects().solids[:, 12]} == {"still", "terrain", "seen"}


@pytest.mark.parametrize(("unit", "scale"), [(np.uint16, None), (np.uint16, 0.0005), (np.float32, None), (np.float64, 2.0)])
def test_a_depth_image_gives_the_points_whose_projections_are_its_pixels(rng, unit, scale):
    depth = rng.integers(300, 4000, (48, 64)).astype(unit)
    if unit != np.uint16:
        depth /= 1000
        depth[5, 6], depth[7, 8] = np.nan, np.inf
    depth[10:20, 30] = 0
    intrinsics = (50.0, 51.0, 31.5, 23.0)
    cloud = ulna.PointCloud.from_depth(depth, intrinsics, T, radius=0.004, depth_scale=scale)
    meters = depth * (scale or (0.001 if unit == np.uint16 else 1.0))
    seen = np.isfinite(meters) & (meters > 0)
    assert cloud.n_left_out == (~seen).sum() >= 10
    in_camera = (cloud.points - T[:3, 3]) @ T[:3, :3]
    v, u = np.nonzero(seen)
    assert_close(in_camera[:, 2], meters[seen], atol=1e-12)
    assert_close(50.0 * in_camera[:, 0] / in_camera[:, 2] + 31.5, u.astype(float), atol=1e-9)
    assert_close(51.0 * in_camera[:, 1] / in_camera[:, 2] + 23.0, v.astype(float), atol=1e-9)


def test_short_floats_of_millimeters_lose_nothing_by_their_unit(rng):
    depth = rng.integers(300, 2048, (48, 64)).astype(np.float16)  # exact in float16
    short, long = (
        ulna.PointCloud.from_depth(z, (50, 50, 31.5, 23), T, radius=0.004, depth_scale=0.001)
        for z in (depth, depth.astype(float))
    )
    assert np.array_equal(short.points, long.points)


@pytest.mark.parametrize(
    ("unit", "kind"), [(1, np.uint16), (1, np.int32), (1, np.uint32), (0.001, np.float32), (0.001, np.float64)], ids=str
)
def test_65535_is_no_measurement_also_where_it_became_a_float(unit, kind):
    """A hole is as one of 0: no point of the cloud, and nothing behind it is seen to be empty."""
    images = {}
    for hole in (0, 65535):
        depth = np.full((480, 640), 800, dtype=np.uint16)
        depth[200:280, 280:360] = hole
        images[hole] = depth * unit if unit == 0.001 and kind is np.float64 else depth.astype(kind) * kind(unit)
    clouds = [ulna.PointCloud.from_depth(image, K, T, radius=0.01) for image in images.values()]
    assert [cloud.n_left_out for cloud in clouds] == [6400, 6400]
    assert np.array_equal(clouds[0].points, clouds[1].points)
    box, pose = ulna.Box((0.4, 0.4, 0.4)), ulna.pose((0, 0, 0.7))
    grids = [ulna.VoxelGrid.unseen(image, K, np.eye(4), box, 0.05, pose=pose) for image in images.values()]
    assert np.array_equal(grids[0].occupied, grids[1].occupied)


def test_the_largest_number_of_any_unsigned_image_is_no_measurement():
    depth = np.full((48, 64), 100, dtype=np.uint8)
    depth[:3] = 255
    assert ulna.PointCloud.from_depth(depth, (60, 60, 31.5, 23.5), T, radius=0.01).n_left_out == 192


def test_what_is_beyond_the_greatest_depth_is_no_measurement(rng):
    depth = rng.uniform(0.3, 9.0, (48, 64))
    given, k = np.where(depth <= 4.0, depth, np.nan), (60, 60, 31.5, 23.5)
    cloud, judge = (ulna.PointCloud.from_depth(z, k, T, radius=0.01, max_depth=most) for z, most in ((depth, 4.0), (given, None)))
    assert np.array_equal(cloud.points, judge.points)
    assert cloud.n_left_out == judge.n_left_out == (depth > 4.0).sum() > 0
    smooth, box = np.full((48, 64), 9.0), ulna.Box((1, 1, 1))
    for most, free in ((None, True), (10, True), (9.0, True), (4.0, False)):
        grid = ulna.VoxelGrid.unseen(smooth, k, np.eye(4), box, 0.1, pose=ulna.pose((0, 0, 3)), max_depth=most)
        assert (~grid.occupied).any() == free
    for most in (0, -1, np.nan, np.inf, "far", True):
        with pytest.raises(InputError, match=r"^max_depth: .*a depth \[m\] above 0"):
            ulna.PointCloud.from_depth(depth, k, T, radius=0.01, max_depth=most)


def test_pixels_that_are_masked_see_nothing():
    depth = np.ma.masked_less(np.linspace(0.3, 2.0, 64 * 48).reshape(48, 64), 0.5)
    filled, (box, K_small) = depth.filled(np.nan), (ulna.Box((0.2, 0.2, 0.2)), (50, 50, 31.5, 23))
    cloud, expected = (ulna.PointCloud.from_depth(z, K_small, np.eye(4), radius=0.01) for z in (depth, filled))
    assert np.array_equal(cloud.points, expected.points)
    assert cloud.n_left_out == depth.mask.sum() > 0
    pose = ulna.pose((0, -0.1, 0.3))
    hidden, expected = (ulna.VoxelGrid.unseen(z, K_small, np.eye(4), box, 0.02, pose=pose) for z in (depth, filled))
    assert np.array_equal(hidden.occupied, expected.occupied)


def test_rows_of_different_length_are_no_image():
    with pytest.raises(ulna.InputError, match="depth: not an array"):
        ulna.PointCloud.from_depth([[1.0, 2.0], [1.0]], K, T, radius=0.01)  # type: ignore[list-item]
    with pytest.raises(ulna.InputError, match="occupied: not an array"):
        ulna.VoxelGrid([[[1, 0]], [[1]]], 0.1)


def test_the_intrinsics_may_be_a_matrix_its_nine_numbers_or_four(rng):
    depth = rng.uniform(0.5, 2, (480, 640))
    forms = K, K.ravel(), (K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    clouds = [ulna.PointCloud.from_depth(depth, form, T, radius=0.01).points for form in forms]
    assert np.array_equal(clouds[0], clouds[1])
    assert np.array_equal(clouds[0], clouds[2])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"depth": np.ones((4, 4, 1))}, "depth: shape"),
        ({"depth": np.full((480, 640), "a")}, "depth: shape"),
        ({"depth": np.full((480, 640), -1.0)}, "depth: -1 m"),
        ({"depth": np.zeros((480, 640))}, "depth: none of 307200 pixels"),
        ({"depth": np.full((480, 640), np.nan)}, "depth: none of 307200 pixels"),
        ({"depth_scale": 0.0}, "depth_scale: "),
        ({"depth_scale": np.nan}, "depth_scale: "),
        ({"intrinsics": np.eye(4)}, "intrinsics: shape"),
        ({"intrinsics": K * (1, np.nan, 1)}, "intrinsics: shape"),
        ({"intrinsics": K * -1}, "intrinsics: not of the form"),
        ({"intrinsics": K.T}, "intrinsics: not of the form"),
        ({"intrinsics": K * ((-1, 1, 1), (1, 1, 1), (1, 1, 1))}, "intrinsics: fx = -500"),
        ({"intrinsics": (500, 500, 639.5, 239.5 * 3)}, "intrinsics: cy = 718.5 is outside of the image of 640 x 480"),
        ({"T_base_camera": np.diag([1, 1, -1, 1.0])}, "T_base_camera: is a reflection"),
        ({"radius": -1}, "radius: "),
    ],
)
def test_a_wrong_depth_image_is_refused_by_name(changed, message):
    given = {"depth": np.ones((480, 640)), "intrinsics": K, "T_base_camera": T, "radius": 0.01} | changed
    with pytest.raises(InputError, match=rf"^{message}"):
        ulna.PointCloud.from_depth(**given)


def test_a_crop_has_the_points_in_the_box(rng):
    points, box = rng.uniform(-1, 1, (2000, 3)), ulna.Box((0.8, 0.6, 1.0))
    cloud = ulna.PointCloud(points, 0.01)
    local = (points - T[:3, 3]) @ T[:3, :3]
    assert np.array_equal(cloud.cropped(box, T).points, points[(np.abs(local) <= (0.4, 0.3, 0.5)).all(axis=1)])
    assert np.array_equal(cloud.cropped(box).points, points[(np.abs(points) <= (0.4, 0.3, 0.5)).all(axis=1)])
    for wrong, name in ((ulna.Sphere(1), "box"), (None, "box")):
        with pytest.raises(InputError, match=rf"^{name}: "):
            cloud.cropped(wrong)
    with pytest.raises(InputError, match=r"^pose: "):
        cloud.cropped(box, np.zeros((4, 4)))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize(("n", "voxel"), [(1, 0.1), (50, 4.0), (3000, 0.1), (60_000, 0.02)])
def test_a_thinned_cloud_holds_every_ball_within_one_of_its_own(rng, n, voxel, kind):
    spatial = pytest.importorskip("scipy.spatial")
    points = rng.uniform(-1, 1, (n, 3)).astype(kind)
    cloud = ulna.PointCloud(points, 0.01)
    thin = cloud.thinned(voxel)
    grown = thin.radius - cloud.radius
    distances, _ = spatial.cKDTree(thin.points).query(points.astype(float))
    assert distances.max() <= grown
    assert grown <= np.sqrt(3) * voxel * 1.001
    voxels = np.floor((points.astype(float) - points.min(axis=0)) * (1 / voxel)).astype(int)
    assert abs(len(thin.points) - len(np.unique(voxels, axis=0))) <= 0.001 * n
    assert set(map(tuple, thin.points.tolist())) <= set(map(tuple, points.tolist())), "points that were measured are kept"


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_of_each_voxel_the_point_nearest_to_its_middle_is_kept(rng, kind):
    voxel, cells = 0.125, rng.integers(0, 24, (20_000, 3))
    cells[0] = 0
    points = (voxel * (cells + rng.uniform(0.1, 0.9, cells.shape))).astype(kind)
    points[0] = 0.0  # where the grid begins
    beside = np.linalg.norm(points - voxel * (cells + 0.5), axis=1)
    order = np.lexsort((beside, *cells.T))
    expected = order[np.unique(cells[order], axis=0, return_index=True)[1]]
    thin = ulna.PointCloud(points, 0.01).thinned(voxel)
    assert len(thin.points) == len(expected) < len(points)
    assert set(map(tuple, thin.points.tolist())) == set(map(tuple, points[expected].tolist()))


@pytest.mark.parametrize("kind", ["fill_slots", "measure_thinning"])
def test_thinning_ends_at_ctrl_c_between_two_slices(rng, monkeypatch, kind):
    slices, run, cloud = [], getattr(thinning, kind), ulna.PointCloud(rng.uniform(-1, 1, (40_000, 3)), 0.01)

    def interrupted(*arguments):
        slices.append(arguments)
        if len(slices) == 2:
            raise KeyboardInterrupt
        return run(*arguments)

    monkeypatch.setattr(thinning, kind, interrupted)
    with pytest.raises(KeyboardInterrupt):
        cloud.thinned(0.5)
    assert len(slices) == 2


def test_the_robots_points_are_found_a_part_of_the_cloud_at_a_time(panda, rng, monkeypatch):
    cloud = ulna.PointCloud(rng.uniform(-0.5, 0.5, (3000, 3)), 0.01)
    expected, scenes = panda.links_near(cloud, panda.home, within=0.05), []
    find = checker.find_near_pairs

    def counted(q, scene, *arguments):
        scenes.append(scene)
        return find(q, scene, *arguments)

    monkeypatch.setattr(checker, "find_near_pairs", counted)
    monkeypatch.setattr(checker, "_MAX_POINTS", 1000)
    names, owner = panda.links_near(cloud, panda.home, within=0.05)
    assert len(scenes) == 3, "Ctrl-C is noticed between two calls"
    assert names == expected[0]
    assert np.array_equal(owner, expected[1])
    assert (owner >= 0).any()


def test_where_a_thinned_cloud_is_free_the_cloud_is(panda, rng):
    points, q = rng.uniform(-0.9, 0.9, (4000, 3)), panda.random(300, seed=5)
    worlds = [ulna.World(), ulna.World()]
    cloud = ulna.PointCloud(points, 0.005)
    for world, one in zip(worlds, (cloud, cloud.thinned(0.05)), strict=True):
        world.add("seen", one)
    before, after = (panda.signed_distance(q, world, self_collision=False) for world in worlds)
    assert (after <= before).all()


@pytest.mark.parametrize("voxel", [0, -0.1, np.nan, np.inf, "wide", [0.1, 0.1], 1e-7])
def test_what_is_no_voxel_is_refused_by_name(voxel):
    with pytest.raises(InputError, match=r"^voxel: "):
        ulna.PointCloud([(0, 0, 0), (1, 1, 1)], 0.1).thinned(voxel)


def test_the_points_of_the_robot_and_of_what_it_holds_are_removed_and_counted(panda, rng):
    points, q, padding = rng.uniform(-0.8, 0.8, (30_000, 3)), panda.home + 0.1, 0.02
    arm = panda.with_attached("cup", ulna.Cylinder(0.05, 0.2), ulna.pose((0, 0, 0.1)))
    cloud = ulna.PointCloud(points, 0.01)
    left = cloud.without(arm, q, padding=padding, pose=T)
    names, owner = arm.links_near(cloud, q, within=padding, pose=T)
    assert sum(left.n_removed.values()) == len(points) - len(left.points) == (owner >= 0).sum()
    assert left.n_removed == {name: n for k, name in enumerate(names) if (n := int((owner == k).sum()))}
    assert left.n_removed["cup"] > 20
    own = ulna.World()
    own.add("left", left, T)
    assert arm.signed_distance(q, own, self_collision=False) > padding
    for k in rng.choice(np.flatnonzero(owner >= 0), 40, replace=False):
        one = ulna.World()
        one.add("ball", ulna.Sphere(0.01), T @ ulna.pose(points[k]))
        pairs = arm.check_collision(q, one, self_collision=False, max_distance=1.0).pairs
        assert pairs[0].signed_distance <= padding
        assert pairs[0].link_a == names[owner[k]] or pairs[1].signed_distance - pairs[0].signed_distance < 1e-9
    assert left.without(arm, q, padding=padding, pose=T).n_removed == left.n_removed, "none is left to remove"


def test_wrong_arguments_of_without_are_refused_by_name(panda):
    cloud = ulna.PointCloud([(0, 0, 0)], 0.1)
    for q, given, name in (
        (np.zeros((2, 7)), {}, "q"),
        (panda.home, {"padding": -1}, "padding"),
        (panda.home, {"pose": np.zeros((4, 4))}, "pose"),
        (np.full(7, np.nan), {}, "q"),
    ):
        with pytest.raises(InputError, match=rf"^{name}"):
            cloud.without(panda, q, **given)
    with pytest.raises(InputError, match=r"^cloud: "):
        panda.links_near("points", panda.home)


def test_a_plan_among_the_robots_own_points_says_how_to_remove_them(panda, rng):
    world = ulna.World()
    points = panda.forward_kinematics(panda.home, link="panda_link5")[:3, 3] + rng.normal(0, 0.01, (50, 3))
    cloud = ulna.PointCloud(points, 0.005)
    world.add("seen", cloud)
    plan = panda.plan(panda.home, panda.home + 0.1, world)
    assert plan.status == ulna.PlanStatus.START_IN_COLLISION
    remedy = "if its points are on the robot itself, cloud.without(robot, q) removes them"
    assert f"seen is a point cloud: {remedy}" in str(plan.reason)
    world.update("seen", cloud.without(panda, panda.home, padding=0.02))
    assert panda.plan(panda.home, panda.home + 0.1, world)


def test_a_cloud_is_read_from_a_file(tmp_path):
    points = np.array([(1.5, 0.25, -1), (0, 2, 0.125)])
    np.save(tmp_path / "seen.npy", points)
    cloud = ulna.PointCloud.from_file(tmp_path / "seen.npy", radius=0.01, scale=0.001)
    assert np.array_equal(cloud.points, points * 0.001)
    assert cloud.radius == 0.01


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.npy", None, "no such file"),
        ("a.las", b"x", "ends in none of"),
        ("a.xyz", b"", "shape"),
        ("a.xyz", b"1 2\n", "cannot be read"),
        ("a.npy", b"\x93NUMPY", "cannot be read"),
    ],
)
def test_a_file_without_points_is_refused(tmp_path, name, content, words):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ulna.FileError, match=words):
        ulna.PointCloud.from_file(tmp_path / name, radius=0.01)
    with pytest.raises(ulna.InputError, match="scale"):
        ulna.PointCloud.from_file(tmp_path / name, radius=0.01, scale=-1)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.csv", "intensity,x,y,z\n9,1,2,3\n9,4,5,6.5\n"),
        ("a.csv", "x;y;z\n1,0;2,0;3,0\n4,0;5,0;6,5\n"),
        ("a.csv", "x [mm],y [mm],z [mm]\n1000,2000,3000\n4000,5000,6500\n"),
        ("a.csv", "\ufeffz\ty\tx\n3\t2\t1\n6.5\t5\t4\n"),
        ("a.csv", "nx,ny,nz,x,y,z\n0,0,1,1,2,3\n0,0,1,4,5,6.5\n"),
        ("a.xyz", "//X Y Z R G B\n1 2 3 4 5 6\n4 5 6.5 0 0 0\n"),
        ("a.txt", "//R G B X Y Z\n4 5 6 1 2 3\n0 0 0 4 5 6.5\n"),
        ("a.xyz", "1 2 3 wood\n4 5 6.5 stone\n"),
        ("a.csv", '"Points:2","Points:0","Points:1"\n3,1,2\n6.5,4,5\n'),
        (
            "a.ply",
            PLY.format("".join(f"property {t} {n}\n" for t, n in zip(("double", "uchar", "float", "int"), "ziyx", strict=True))),
        ),
        ("a.pcd", PCD.format("z i y x", "0 0 0 1 0 0 0")),
    ],
)
def test_points_are_read_from_the_columns_that_are_named_so(tmp_path, name, content):
    (tmp_path / name).write_text(content, encoding="utf-8")
    cloud = ulna.PointCloud.from_file(tmp_path / name, radius=0.01)
    assert np.allclose(cloud.points, [(1, 2, 3), (4, 5, 6.5)], rtol=1e-15)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.csv", "a,b,c\n1,2,3\n", "no column is named x, y, z; the names are 'a', 'b', 'c'"),
        ("a.csv", "lat,lon,z\n1,2,3\n", "no column is named x, y"),
        ("a.csv", "x,y,z,x\n1,2,3,4\n", "are both x"),
        ("a.csv", "x [mm],y,z\n1,2,3\n", "have different units"),
        ("a.csv", "x [mile],y,z\n1,2,3\n", "is not known"),
        ("a.csv", "x,y,z\n1,5,2,0,3,0\n", "3 names, but line 2 has 6 columns"),
        ("a.csv", "1,0;2.0;3,0\n", "with a point and numbers with a comma"),
        ("a.csv", "1;2;3\n1;2;3\n1,5;2;3\n", "cannot be read"),
        ("a.xyz", "1,0 2,0 3,0\n", "cannot be read"),
        ("a.ply", PLY.format("property float x\nproperty float y\n"), "one x, one y and one z are expected"),
        ("a.ply", PLY.format("".join(f"property float {n}\n" for n in "xxyz")), "properties x x y z"),
        ("a.pcd", PCD.format("x x y z", "0 0 0 1 0 0 0"), "FIELDS are x x y z"),
        ("a.pcd", PCD.format("i x y z", "1 0 0 1 0 0 0"), "VIEWPOINT is 1 0 0 1 0 0 0, .* from_sensor=True moves"),
    ],
)
def test_columns_that_are_missing_double_or_ambiguous_are_refused(tmp_path, name, content, words):
    (tmp_path / name).write_text(content)
    with pytest.raises(ulna.FileError, match=words):
        ulna.PointCloud.from_file(tmp_path / name, radius=0.01)


def test_a_unit_in_the_names_agrees_with_the_scale_or_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("x_mm,y_mm,z_mm\n1000,2000,3000\n")
    for scale in (1.0, 0.001):
        cloud = ulna.PointCloud.from_file(tmp_path / "a.csv", radius=0.01, scale=scale)
        assert cloud.points.tolist() == [[1, 2, 3]]
    with pytest.raises(ulna.FileError, match=r"in units of 0.001 m, but the scale is 0.01"):
        ulna.PointCloud.from_file(tmp_path / "a.csv", radius=0.01, scale=0.01)


def test_the_viewpoint_of_a_pcd_moves_the_points_of_a_sensor_and_no_others(tmp_path):
    (tmp_path / "a.pcd").write_text(PCD.format("x y z i", "10 20 30 0.7071067811865476 0 0 0.7071067811865476"))
    read = ulna.PointCloud.from_file
    moved = read(tmp_path / "a.pcd", radius=0.01, from_sensor=True).points
    still = read(tmp_path / "a.pcd", radius=0.01, from_sensor=False).points
    assert np.allclose(moved, np.column_stack([10 - still[:, 1], 20 + still[:, 0], 30 + still[:, 2]]))  # a quarter turn about z
    assert still[0].tolist() == [3, 9, 2]


def test_records_of_numpy_are_read_by_the_names_of_their_fields(tmp_path):
    records = np.zeros((2, 3), dtype=[("rgb", "u4"), ("y", "f4"), ("x", "f8"), ("z", "f4")])
    records["x"], records["y"], records["z"] = np.arange(6).reshape(2, 3), 7, 8
    np.save(tmp_path / "a.npy", records)
    cloud = ulna.PointCloud.from_file(tmp_path / "a.npy", radius=0.01, scale=0.5)
    assert cloud.points.tolist() == [[k / 2, 3.5, 4] for k in range(6)]
    np.save(tmp_path / "a.npy", records[["rgb", "x"]])
    with pytest.raises(ulna.FileError, match="no column is named y, z; the names are 'rgb', 'x'"):
        ulna.PointCloud.from_file(tmp_path / "a.npy", radius=0.01)
    np.save(tmp_path / "a.npy", np.array([["1", "2", "3"]]))
    with pytest.raises(ulna.FileError, match="numbers are expected"):
        ulna.PointCloud.from_file(tmp_path / "a.npy", radius=0.01)
