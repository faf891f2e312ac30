"""A mesh that is grown, so that it does not flicker: by the normals at its vertices, without SciPy."""

import numpy as np
import pytest
import trimesh

from ulna.viewer.nodes import offset_mesh

MESHES = {
    "box": lambda: trimesh.creation.box((0.1, 0.2, 0.3)), "ball": lambda: trimesh.creation.icosphere(3),
    "cylinder": lambda: trimesh.creation.cylinder(0.1, 0.3),
}  # fmt: skip


@pytest.mark.parametrize("name", MESHES)
def test_vertices_move_along_the_normals_of_another_library(name):
    mesh = MESHES[name]()
    np.testing.assert_allclose(offset_mesh(mesh, 1e-3).vertices, mesh.vertices + 1e-3 * mesh.vertex_normals, rtol=0, atol=1e-12)


def test_the_normals_that_ask_for_scipy_are_not_asked_for(monkeypatch):
    """They print a traceback where SciPy is absent, as after ``make demo``."""
    monkeypatch.setattr(trimesh.Trimesh, "vertex_normals", property(lambda _: pytest.fail("asks for SciPy")))
    assert offset_mesh(MESHES["box"](), 1e-3).extents == pytest.approx(np.array([0.1, 0.2, 0.3]) + 2e-3 / np.sqrt(3), abs=1e-9)
