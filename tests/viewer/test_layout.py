"""The panel does not cover the scene: it is beside it on a wide page, below it on a phone. The page's title names the robot."""

import numpy as np
import pytest

import ulna
from browser import SIZE, camera_of, project, wait_to_see

PHONE = (390, 844)
SHEET = """() => {
    const scene = document.querySelector('canvas').getBoundingClientRect();
    const panel = document.querySelector('[role=tab]').getBoundingClientRect();
    return [scene.width, scene.height, panel.left, panel.top];
}"""


@pytest.mark.slow
@pytest.mark.parametrize("size", [SIZE, PHONE])
def test_the_panel_does_not_cover_the_robot_or_a_new_obstacle(open_page, size):
    robot = ulna.load("ur5")
    with ulna.view(robot) as view:
        page = open_page(view.url, size=size)
        camera = camera_of(page, view.page.server)
        page.get_by_role("tab", name="Obstacles").click()
        page.get_by_role("button", name="Box").click()
        wait_to_see(page, lambda: view.world.names, "an obstacle")
        (name,) = view.world.names
        points = [*robot.link_poses(view.q)[:, :3, 3], view.world.pose(name)[:3, 3]]

        def all_in_sight():
            width, height, left, top = page.evaluate(SHEET)
            clear = width <= left if size == SIZE else height <= top
            seen = np.array([project(camera, point) for point in points])
            return clear and (seen > 10).all() and (seen[:, 0] < width - 10).all() and (seen[:, 1] < height - 10).all()

        wait_to_see(page, all_in_sight, "all of it, beside the panel")
        assert page.title() == "ur5 - Ulna"
