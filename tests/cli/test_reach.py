"""``ulna reach``."""

import signal
import subprocess
import sys

import pytest

import ulna
from map_files import verdicts_of
from processes import running, wait_for

SMALL = ("--voxel", "0.4", "--orientations", "4")


@pytest.fixture
def path(run, tmp_path):
    path = tmp_path / "m.zarr"
    assert run("reach", "panda", path, *SMALL).exit_code == 0
    return path


def test_it_computes_a_map_and_says_how_many_poses_are_reached(run, ask, tmp_path):
    found = ask("reach", "panda", tmp_path / "m.zarr", *SMALL)
    opened = ulna.ReachabilityMap.open(tmp_path / "m.zarr")
    assert (found.poses, found.computed, found.reached) == opened.summary[:3]
    assert found.statuses == opened.summary.statuses
    assert found.share == pytest.approx(found.reached / found.poses)
    assert found.poses_a_second == pytest.approx(found.poses / found.seconds)
    assert (found.robot, found.link) == ("panda", "panda_ee")
    shown = run("reach", "panda", tmp_path / "m.zarr", *SMALL, "--resume").stdout
    assert f"{found.poses:,} of {found.poses:,} poses computed" in shown
    assert f"{found.reached:,}" in shown


def test_map_may_be_said(ask, tmp_path):
    assert ask("reach", "map", "panda", tmp_path / "m.zarr", *SMALL).computed > 0


def test_its_options_are_those_of_the_function(ask, panda, tmp_path):
    scene = tmp_path / "cell.json"
    world = ulna.World()
    world.add("box", ulna.Box((0.3, 0.3, 0.3)), ulna.pose((0.5, 0, 0.3)))
    ulna.save_world(world, scene)
    words = (
        "--bounds",
        "0,-0.4,0, 0.8,0.4,0.8",
        "--scene",
        scene,
        "--task",
        "pointing",
        "--seed",
        "3",
        "--keep-clearance",
        "--keep-payload",
    )
    ask("reach", "panda", tmp_path / "m.zarr", *SMALL, *words, "--solutions", "--max-iterations", "200", "--threads", "1")
    bounds = [(0, -0.4, 0), (0.8, 0.4, 0.8)]
    same = {"voxel": 0.4, "orientations": 4, "bounds": bounds, "world": world, "task": "pointing", "seed": 3}
    same |= {"keep_clearance": True, "keep_solutions": True, "keep_payload": True, "max_iterations": 200}
    found = ulna.reachability_map(panda, tmp_path / "m.zarr", resume=True, **same)
    assert set(found.data) == {"reached", "manipulability", "clearance", "payload", "q"}


def test_the_number_of_orientations_has_a_default(ask, tmp_path):
    found = ask("reach", "panda", tmp_path / "m.zarr", "--voxel", "0.9")
    assert found.poses == 8 * ask("reach", "panda", tmp_path / "n.zarr", "--voxel", "0.9", "--orientations", "4").poses


def test_with_nothing_to_do_there_is_no_rate(ask, path):
    found = ask("reach", "panda", path, *SMALL, "--resume")
    assert (found.seconds, found.poses_a_second) == (None, None)


def test_what_cannot_be_taken_names_the_option(refusal, path, tmp_path):
    assert refusal("reach", "panda", path, *SMALL).endswith("already; --resume continues a map")
    wrong = "reach", "panda", tmp_path / "n.zarr", "--orientations", "4", "--voxel"
    assert refusal(*wrong, "0").startswith("--voxel: ")
    assert refusal(*wrong, "0.1", "--bounds", "1,2").startswith("--bounds: ")
    assert refusal(*wrong, "0.1", "--task", "poses").startswith("--task: ")
    assert "orientations: 4 and 5" in refusal("reach", "panda", path, "--voxel", "0.4", "--orientations", "5", "--resume")
    assert "no reachability map" in refusal("reach", "plot", tmp_path / "none.zarr", "a.png")
    assert "no reachability map" in refusal("reach", "show", tmp_path / "none.zarr")


def test_a_figure_is_written_and_its_path_printed(ask, run, path, tmp_path):
    found = ask("reach", "plot", path, tmp_path / "m.png")
    assert found.poses > 0
    assert found.figure == str(tmp_path / "m.png")
    assert run("reach", "plot", path, tmp_path / "m.png").stdout.splitlines()[-1] == str(tmp_path / "m.png")
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="it has no such signal")
def test_the_page_is_served_until_ctrl_c(path):
    command = sys.executable, "-m", "ulna", "reach", "show", str(path), "--port", "0", "--no-open", "--robot", "panda"
    with running(*command, stdout=subprocess.PIPE) as process:
        assert "panda is at http://127.0.0.1:" in process.stdout.readline()
        process.send_signal(signal.SIGINT)
        assert process.wait() == 0


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="it has no such signal")
def test_ctrl_c_leaves_a_map_and_says_how_to_go_on(tmp_path):
    path = tmp_path / "m.zarr"
    words = "--voxel", "0.04", "--orientations", "128", "--threads", "1"
    command = sys.executable, "-m", "ulna", "reach", "panda", str(path), *words
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        wait_for(lambda: len(verdicts_of(path)) > 3, "chunks on the disk", looks=None)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
    assert process.returncode == 130
    kept = ulna.ReachabilityMap.open(path).summary.computed
    assert f"contains {kept} of " in said
    assert "--resume continues" in said
    assert not path.with_name("m.zarr.lock").exists()
