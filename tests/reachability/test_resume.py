"""A map that was interrupted goes on where it was, with the same bits; a map of something else is refused."""

import errno
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import ulna
from map_files import SMALL, files_of, verdicts_of
from processes import running, wait_for
from ulna.reachability import chunk
from ulna.reachability.plot import draw
from ulna.reachability.reachability_map import default_bounds
from ulna.reachability.run import locked

WHOLE = {**SMALL, "keep_solutions": True}
# A program that computes the map of the tests at a path, a chunk each time that it has slept.
SLOW = """
import sys, time, ulna
from ulna.reachability import chunk, grid
grid.POSES_OF_A_CHUNK = 64
compute = chunk.compute
chunk.compute = lambda *a: (time.sleep(0.1), compute(*a))[1]
if __name__ == "__main__":
    ulna.threads(2)
    ulna.reachability_map(ulna.load("panda"), sys.argv[1], voxel=0.3, orientations=8, keep_solutions=True, resume=True)
"""


def without_some(path):
    """Take every third verdict away, as if their chunks had not been written."""
    gone = verdicts_of(path)[::3]
    for file in gone:
        file.unlink()
    return len(gone)


@pytest.fixture
def interrupted(panda, many_chunks, tmp_path):
    """A map with a third of its chunks missing, one of them half written."""
    path = tmp_path / "m.zarr"
    ulna.reachability_map(panda, path, **WHOLE)
    assert without_some(path) > 5
    verdicts_of(path)[0].with_name("0.0123abcd.partial").write_bytes(b"half")
    return path


def test_it_gets_the_same_bits_as_an_undisturbed_one(panda, panda_map, interrupted):
    ulna.reachability_map(panda, interrupted, resume=True, **WHOLE)
    assert files_of(interrupted) == files_of(panda_map.path)
    assert not list(interrupted.rglob("*.partial"))


def test_only_what_is_missing_is_computed(panda, interrupted, monkeypatch):
    computed, compute = [], chunk.compute
    monkeypatch.setattr(chunk, "compute", lambda *arguments: (computed.append(arguments[1]), compute(*arguments))[1])
    found = ulna.ReachabilityMap.open(interrupted)
    missing = found.grid.n_chunks - len(verdicts_of(interrupted))
    assert not found.is_whole
    assert np.isnan(found.share.values).any()
    ulna.reachability_map(panda, interrupted, resume=True, **WHOLE)
    assert len(computed) == len(set(computed)) == missing
    computed.clear()
    assert ulna.reachability_map(panda, interrupted, resume=True, **WHOLE).is_whole
    assert computed == []


def test_poses_that_are_not_computed_count_as_neither_reached_nor_not(panda_map, interrupted):
    part = ulna.ReachabilityMap.open(interrupted)
    difference = panda_map.compare(part)
    assert (difference.only_first, difference.only_second) == (0, 0)
    assert difference.both == part.summary.reached
    assert difference.both + difference.neither == part.summary.computed < part.grid.n_poses


def test_the_share_by_height_is_that_of_what_is_computed(panda_map, interrupted):
    part = ulna.ReachabilityMap.open(interrupted)
    drawn = draw(part).axes[3].lines[0].get_xdata()
    known = ~np.isnan(part.share.values)
    assert not known.all()
    for shares, of_layer, mean in zip(panda_map.share.values, known, drawn, strict=True):
        assert mean == pytest.approx(shares[of_layer].mean(), abs=1e-6)


def test_resume_begins_a_map_where_there_is_none(panda, panda_map, many_chunks, tmp_path):
    ulna.reachability_map(panda, tmp_path / "m.zarr", resume=True, **WHOLE)
    assert files_of(tmp_path / "m.zarr") == files_of(panda_map.path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["m.zarr"]


def test_progress_counts_the_poses_that_were_there(panda, interrupted):
    seen = []
    ulna.reachability_map(panda, interrupted, resume=True, progress=lambda *counts: seen.append(counts), **WHOLE)
    total = ulna.ReachabilityMap.open(interrupted).grid.n_poses
    assert 0 < seen[0][0] < total
    assert seen[-1] == (total, total)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_an_interrupt_leaves_a_map_that_goes_on(panda, panda_map, many_chunks, tmp_path):
    path = tmp_path / "m.zarr"

    def interrupt(done, total):
        if done > 500:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ulna.reachability_map(panda, path, progress=interrupt, **WHOLE)
    assert 0 < len(verdicts_of(path)) < ulna.ReachabilityMap.open(path).grid.n_chunks
    ulna.reachability_map(panda, path, resume=True, **WHOLE)
    assert files_of(path) == files_of(panda_map.path)


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="it has no such signals")
@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
def test_a_process_that_is_ended_leaves_a_map_that_goes_on(panda, panda_map, many_chunks, tmp_path, name):
    path, program = tmp_path / "m.zarr", tmp_path / "slow.py"
    program.write_text(SLOW)
    with subprocess.Popen([sys.executable, program, path], stderr=subprocess.DEVNULL) as process:
        wait_for(lambda: len(verdicts_of(path)) > 5, "chunks on the disk", looks=None)
        process.send_signal(getattr(signal, name))
    assert 5 < len(verdicts_of(path)) < ulna.ReachabilityMap.open(path).grid.n_chunks
    ulna.reachability_map(panda, path, resume=True, **WHOLE)
    assert files_of(path) == files_of(panda_map.path)


# ---- what is refused ---------------------------------------------------------------------------------------------------------


def test_a_map_that_is_there_is_not_written_over(panda, interrupted):
    before = files_of(interrupted)
    with pytest.raises(ulna.FileError, match="resume=True"):
        ulna.reachability_map(panda, interrupted, **WHOLE)
    assert files_of(interrupted) == before


def other_worlds():
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((1, 0, 0)))
    return world


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"robot": lambda panda: panda.with_tool(ulna.pose((0, 0, 0.1)))}, "robot: its description; link: panda_ee and tool"),
        ({"robot": lambda panda: ulna.Robot(panda.description, home=panda.home + 0.1)}, "robot: its description"),
        ({"voxel": 0.4}, "voxel: 0.3 and 0.4"),
        ({"orientations": 9}, "orientations: 8 and 9"),
        ({"bounds": [(0, 0, 0), (1, 1, 1)]}, "bounds: "),
        ({"world": other_worlds()}, "world"),
        ({"seed": 1}, "seed: 0 and 1"),
        ({"task": "position"}, "task: "),
        ({"link": "panda_link7"}, "link: panda_ee and panda_link7"),
        ({"rotation_tolerance": 1e-3}, "rotation_tolerance: 1e-05 and 0.001"),
        ({"max_iterations": 16_000}, "max_iterations: 400 and 16000"),
        ({"keep_solutions": False}, "solutions: True and False"),
    ],
)
def test_a_map_of_something_else_is_refused_and_what_differs_is_said(panda, interrupted, changed, said):
    given = {**WHOLE, **changed}
    robot = given.pop("robot", lambda panda: panda)(panda)
    if "robot" in changed:
        given["bounds"] = default_bounds(panda, panda.tip)
    before = files_of(interrupted)
    with pytest.raises(ulna.InputError) as refused:
        ulna.reachability_map(robot, interrupted, resume=True, **given)
    assert refused.value.argument == "resume"
    assert said in str(refused.value)
    assert files_of(interrupted) == before


def test_what_is_no_map_is_refused(panda, tmp_path):
    (tmp_path / "text").write_text("hello")
    (tmp_path / "folder").mkdir()
    (tmp_path / "other.zarr").mkdir()
    (tmp_path / "other.zarr" / "zarr.json").write_text('{"attributes": {"ulna_reachability_map": 99}}')
    for name in ("text", "folder", "other.zarr"):
        with pytest.raises(ulna.UlnaError, match=name):
            ulna.reachability_map(panda, tmp_path / name, resume=True, **SMALL)
        with pytest.raises(ulna.UlnaError, match=name):
            ulna.ReachabilityMap.open(tmp_path / name)


def test_a_map_whose_robot_was_changed_is_refused(interrupted):
    file = interrupted / "zarr.json"
    text = file.read_text()
    assert "0.333" in text
    file.write_text(text.replace("0.333", "0.334"))
    with pytest.raises(ulna.DescriptionError, match="the attributes were changed"):
        ulna.ReachabilityMap.open(interrupted)


LOCKING = """
import sys, time
from pathlib import Path
from ulna.reachability.run import locked
with locked(Path(sys.argv[1])):
    print("locked", flush=True)
    time.sleep(600)
"""


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="it has no SIGKILL")
def test_a_map_that_another_process_writes_is_refused_until_that_is_killed(panda, interrupted):
    with running(sys.executable, "-c", LOCKING, str(interrupted), stdout=subprocess.PIPE, end_with=signal.SIGKILL) as process:
        assert process.stdout.readline() == "locked\n"
        with pytest.raises(ulna.FileError, match="another process is writing"):
            ulna.reachability_map(panda, interrupted, resume=True, **WHOLE)
    assert ulna.reachability_map(panda, interrupted, resume=True, **WHOLE).is_whole


def test_a_lock_leaves_no_file(tmp_path):
    with locked(tmp_path / "m.zarr"):
        assert [entry.name for entry in tmp_path.iterdir()] == ["m.zarr.lock"]
        with pytest.raises(ulna.FileError), locked(tmp_path / "m.zarr"):
            pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc is Linux's")
def test_a_folder_that_cannot_be_written_to_is_an_error(panda):
    with pytest.raises(ulna.FileError, match="cannot be written"):
        ulna.reachability_map(panda, "/proc/self/m.zarr", **SMALL)
    with pytest.raises(ulna.FileError, match="no folder"):
        ulna.reachability_map(panda, "/proc/nowhere/m.zarr", **SMALL)


def test_a_chunk_that_cannot_be_written_is_an_error_and_nothing_is_lost(panda, panda_map, many_chunks, tmp_path, monkeypatch):
    path, put = tmp_path / "m.zarr", chunk.write
    written = []

    class Full:
        def __setitem__(self, region, values):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def write(opened, number, values):
        if len(written) > 10:
            opened = chunk.OpenMap(opened.path, opened.specification, opened.robot, opened.world, dict.fromkeys(values, Full()))
        written.append(number)
        put(opened, number, values)

    with monkeypatch.context() as patch:
        patch.setattr(chunk, "write", write)
        with pytest.raises(ulna.FileError, match="No space left on device"):
            ulna.reachability_map(panda, path, **WHOLE)
    assert len(verdicts_of(path)) == 11
    ulna.reachability_map(panda, path, resume=True, **WHOLE)
    assert files_of(path) == files_of(panda_map.path)


FULL = """
import sys, ulna
from pathlib import Path
from ulna.reachability import grid
grid.POSES_OF_A_CHUNK = 64
path = Path(sys.argv[1]) / "m.zarr"
given = dict(voxel=0.3, orientations=8, keep_solutions=True)
try:
    ulna.reachability_map(ulna.load("panda"), path, **given)
except ulna.FileError as error:
    print(error)
(Path(sys.argv[1]) / "ballast").unlink()
print(ulna.reachability_map(ulna.load("panda"), path, resume=True, **given).is_whole)
import shutil
shutil.copytree(path, sys.argv[2])
"""


def can_mount():
    tried = subprocess.run([*ALONE, "mount -t tmpfs -o size=1m tmpfs /mnt"], capture_output=True, check=False)
    return tried.returncode == 0


# A shell with mounts of its own: as who may mount, or as who may in a name space of users.
ALONE = ["unshare", *([] if getattr(os, "geteuid", lambda: 1)() == 0 else ["-r"]), "-m", "sh", "-ec"]


@pytest.mark.process
@pytest.mark.skipif(not sys.platform.startswith("linux") or not can_mount(), reason="a small disk cannot be mounted here")
def test_a_full_disk_is_an_error_and_with_room_the_map_goes_on(panda_map, tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "full.py").write_text(FULL)
    script = (
        f"mount -t tmpfs -o size=4m tmpfs {tmp_path}/disk; head -c 3900k /dev/zero > {tmp_path}/disk/ballast; "
        f"{sys.executable} {tmp_path}/full.py {tmp_path}/disk {tmp_path}/copy"
    )
    done = subprocess.run([*ALONE, script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    error, whole = done.stdout.splitlines()
    assert "No space left on device" in error
    assert whole == "True"
    assert files_of(tmp_path / "copy") == files_of(panda_map.path)
