"""Small maps of the Panda, cut into many chunks."""

import pytest

import ulna
from command_fixtures import ask, refusal, run
from map_files import SMALL
from ulna.reachability import grid

__all__ = ["ask", "refusal", "run"]


@pytest.fixture
def many_chunks(monkeypatch):
    """A map is cut into chunks of at most 64 poses; what runs in other processes reads that from the map."""
    monkeypatch.setattr(grid, "POSES_OF_A_CHUNK", 64)


@pytest.fixture(scope="session")
def panda_map(tmp_path_factory, panda):
    """A map that nothing disturbed."""
    path = tmp_path_factory.mktemp("maps") / "panda.zarr"
    with pytest.MonkeyPatch.context() as patch, ulna.threads(1):
        patch.setattr(grid, "POSES_OF_A_CHUNK", 64)
        return ulna.reachability_map(panda, path, keep_solutions=True, **SMALL)


@pytest.fixture(scope="session")
def planar():
    """Two links of one meter, in the plane z = 0: what it reaches can be worked out in the head."""
    rows = [(0, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)]
    return ulna.Robot.from_dh(rows, joint_types=["revolute"] * 2 + ["fixed"])
