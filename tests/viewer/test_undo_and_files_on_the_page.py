"""The page undoes and redoes what a person does to the obstacles, and adds meshes and clouds from files, in headless Chromium."""

import numpy as np
import pytest
import trimesh

import ulna
from browser import arrow, camera_of, drag, wait_to_see
from ulna.viewer.uploads import RADIUS


@pytest.fixture
def page(view, open_page):
    page = open_page(view.url)
    page.get_by_role("tab", name="Obstacles").click()
    return page


def press(page, keys):
    """Press keys over the scene, where no field takes them."""
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(keys)


def test_a_drag_is_one_step_and_keys_and_buttons_undo_and_redo(view, page):
    camera, world = camera_of(page, view.page.server), view.world
    page.get_by_role("button", name="Box").click()
    wait_to_see(page, lambda: world.names == ("new box 1",), "a box")
    world.move("new box 1", ulna.pose((0.31, -0.33, 0.47)))  # by the program, where no label is over its arrow
    wait_to_see(page, lambda: np.allclose(view.obstacles.handles.pose, world.pose("new box 1")), "its handles")
    T, size = world.pose("new box 1"), view.obstacles.handles.control.scale
    drag(page, view.obstacles.handles, arrow(camera, T, 1, size), (-60, 20), "green")
    page.mouse.up()
    wait_to_see(page, lambda: not view.obstacles.handles.dragged and not view.obstacles._scene_before_drag, "the end of the drag")
    moved = world.pose("new box 1")
    assert not np.allclose(moved, T, atol=0.02)
    press(page, "Control+z")
    wait_to_see(page, lambda: np.array_equal(world.pose("new box 1"), T), "the box where it was")
    press(page, "Control+Shift+z")
    wait_to_see(page, lambda: np.array_equal(world.pose("new box 1"), moved), "the box where it was dragged")
    for _ in range(2):
        page.get_by_role("button", name="Undo").click()
    wait_to_see(page, lambda: world.names == (), "no box")
    wait_to_see(page, lambda: page.get_by_role("button", name="Undo").is_disabled(), "nothing to undo")
    page.get_by_role("button", name="Redo").click()
    wait_to_see(page, lambda: world.names == ("new box 1",) and view.obstacles.chosen == "new box 1", "the box, chosen")


def test_a_capsule_is_added_sized_drawn_and_measured_as_a_row_of_balls_is(view, page, panda):
    world = view.world
    page.get_by_role("button", name="Capsule").click()
    wait_to_see(page, lambda: world.names == ("capsule 1",), "a capsule")
    for label, value, holds in (
        ("Radius [m]", "0.03", lambda: world.shape("capsule 1").radius == 0.03),
        ("Length [m]", "0.4", lambda: world.shape("capsule 1").length == 0.4),
    ):
        field = page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Enter")
        wait_to_see(page, holds, f"{label} {value}")
    T = ulna.pose((0.5, 0.3, 0.3), (0.7, 0.4, 0.0))
    world.move("capsule 1", T)
    node = view.obstacles.nodes.get  # what is drawn anew is absent for a moment
    wait_to_see(
        page, lambda: node("capsule 1") and np.allclose(node("capsule 1").position, T[:3, 3]), "the capsule where it was moved"
    )
    corners = view.obstacles.nodes["capsule 1"].vertices
    assert np.allclose(np.ptp(corners, axis=0), [0.06, 0.06, 0.46], atol=2e-3)
    row = ulna.World()
    for k, z in enumerate(np.linspace(-0.2, 0.2, 401)):
        row.add(f"ball {k}", ulna.Sphere(0.03), T @ ulna.pose((0.0, 0.0, z)))
    expected = panda.signed_distance(view.q, row, self_collision=False)
    found = wait_to_see(page, lambda: view.session.clearance.nearest, "its distance").signed_distance
    wait_to_see(page, lambda: abs(view.session.clearance.nearest.signed_distance - expected) < 1e-4, f"{expected}, not {found}")


@pytest.mark.slow
def test_typed_values_a_deletion_and_the_floor_are_undone(view, page):
    world = view.world
    page.get_by_role("button", name="Cylinder").click()
    wait_to_see(page, lambda: world.names, "a cylinder")
    for label, value, holds in (
        ("Radius [m]", "0.05", lambda: world.shape("cylinder 1").radius == 0.05),
        ("Position [m]", "0.7", lambda: world.pose("cylinder 1")[0, 3] == pytest.approx(0.7)),
        ("Name", "post", lambda: world.names == ("post",)),
    ):
        field = page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Enter")
        wait_to_see(page, holds, f"{label} {value}")
    page.get_by_role("button", name="Delete").click()
    wait_to_see(page, lambda: world.names == (), "nothing")
    page.get_by_role("checkbox", name="Floor").check()
    wait_to_see(page, lambda: world.names == ("floor",), "a floor")
    for names, radius, x in (
        ((), None, None),
        (("post",), 0.05, 0.7),
        (("cylinder 1",), 0.05, 0.7),
        (("cylinder 1",), 0.05, None),
        (("cylinder 1",), None, None),
    ):
        page.get_by_role("button", name="Undo").click()
        wait_to_see(page, lambda names=names: world.names == names, f"{names}")
        for name in names:
            wait_to_see(page, lambda n=name, r=radius: (world.shape(n).radius == 0.05) == (r is not None), "its radius")
            wait_to_see(page, lambda n=name, x=x: (abs(world.pose(n)[0, 3] - 0.7) < 1e-9) == (x is not None), "its place")


@pytest.mark.slow
def test_a_mesh_and_a_cloud_are_added_edited_saved_loaded_and_undone(view, page, tmp_path):
    world = view.world
    page.get_by_text("Add a mesh or point cloud").click()
    page.get_by_text("Choose a file").wait_for()
    mesh, cloud, bad = (tmp_path / name for name in ("cone.stl", "seen.csv", "bad.pcd"))
    mesh.write_bytes(trimesh.creation.cone(0.1, 0.2, sections=16).apply_translation((0.5, 0.3, 0.2)).export(file_type="stl"))
    grid = np.stack(np.meshgrid(np.linspace(0.5, 0.7, 9), np.linspace(-0.4, -0.2, 9)), axis=-1).reshape(-1, 2)
    cloud.write_text("x,y,z\n" + "".join(f"{x},{y},0.3\n" for x, y in grid))
    bad.write_text("FIELDS x y z\n")
    files = page.get_by_label("Choose a file")
    files.set_input_files(mesh)
    wait_to_see(page, lambda: world.names == ("cone",), "the mesh")
    assert isinstance(world.shape("cone"), ulna.ConvexMesh)
    files.set_input_files(cloud)
    wait_to_see(page, lambda: world.names == ("cone", "seen"), "the cloud")
    assert np.allclose(world.shape("seen").points[:, :2], grid)
    field = page.get_by_label("Radius [m]", exact=True)
    wait_to_see(page, lambda: field.input_value() == f"{RADIUS:g}", "the radius of its points")
    field.fill("0.02")
    field.press("Enter")
    wait_to_see(page, lambda: world.shape("seen").radius == 0.02, "larger points")
    files.set_input_files(bad)
    page.get_by_text("bad.pcd: cannot be read: it has no line DATA").wait_for()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save scene").click()
    scene = tmp_path / "scene.json"
    download.value.save_as(scene)
    page.get_by_role("button", name="Delete").click()
    wait_to_see(page, lambda: world.names == ("cone",), "no cloud")
    page.get_by_role("button", name="Delete").wait_for(state="hidden")  # until then the buttons below it move up, under a click
    page.get_by_role("button", name="Undo").click()
    wait_to_see(page, lambda: world.names == ("cone", "seen") and world.shape("seen").radius == 0.02, "the cloud")
    page.get_by_label("Load scene").set_input_files(scene)
    wait_to_see(page, lambda: np.allclose(view.world.shape("seen").points[:, :2], grid), "the saved cloud")
    assert len(world.shape("cone").vertices) == len(ulna.load_world(scene).shape("cone").vertices)
