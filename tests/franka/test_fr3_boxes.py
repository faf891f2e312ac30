"""The boxes of the FR3 by name hold the collision meshes that its maker publishes, which franky-sim brings."""

import numpy as np
import pytest
import trimesh

from simulators import assets

BASE = 0.001  # [m]: the box of the base begins so far above the floor


@pytest.mark.parametrize("name", [*(f"link{k}" for k in range(8)), "hand"])
def test_the_boxes_of_a_link_hold_its_collision_mesh(fr3, name):
    mesh = trimesh.load(assets() / "meshes" / f"{name}_coll.stl", force="mesh")
    np.random.seed(1)  # noqa: NPY002 - trimesh samples with it
    points = np.concatenate([mesh.vertices, mesh.sample(20_000)])
    points = points[points[:, 2] > BASE] if name == "link0" else points
    link = next(link for link in fr3.description.links if link.name == f"fr3_{name}")
    held = np.zeros(len(points), dtype=bool)
    for each in link.collisions:
        local = (points - each.pose[:3, 3]) @ each.pose[:3, :3]
        held |= (np.abs(local) <= np.array(each.shape.extents) / 2 + 1e-9).all(axis=1)
    assert held.all(), f"{(~held).sum()} of {len(points)} points are outside"
