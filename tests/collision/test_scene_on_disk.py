"""Scene files on disk: what is saved can be loaded, and what cannot be saved leaves the old file as it was."""

import os
import stat
import sys
import time

import numpy as np
import pytest

import ulna
from ulna.collision import scene_file
from ulna.description import file_bytes


def crates():
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.2, 0.3)))
    return world


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "scene.json"
    ulna.save_world(crates(), path)
    return path


def test_a_scene_that_would_be_too_long_to_load_is_refused_and_the_old_file_stays(saved, monkeypatch):
    before, world = saved.read_bytes(), crates()
    world.add("scan", ulna.PointCloud(np.ones((900, 3)), 0.01))
    monkeypatch.setattr(scene_file, "LONGEST", 5000)
    with pytest.raises(ulna.InputError, match="world: its scene has"):
        ulna.save_world(world, saved)
    assert saved.read_bytes() == before
    monkeypatch.setattr(scene_file, "LONGEST", len(scene_file.world_to_json(crates())))
    ulna.save_world(crates(), saved)
    assert ulna.load_world(saved).names == ("crate",)


def test_a_disk_that_fills_up_leaves_the_old_file_and_no_other(saved, monkeypatch):
    before = saved.read_bytes()

    def full(path, content):
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(file_bytes.Path, "write_bytes", full)
    with pytest.raises(ulna.FileError, match="No space left on device"):
        ulna.save_world(crates(), saved)
    monkeypatch.undo()
    assert saved.read_bytes() == before
    assert os.listdir(saved.parent) == [saved.name]  # noqa: PTH208 - hidden ones too


@pytest.mark.skipif(sys.platform == "win32", reason="links and modes of POSIX")
def test_a_link_stays_a_link_and_a_mode_stays_a_mode(saved, tmp_path):
    link = tmp_path / "link.json"
    link.symlink_to(saved)
    saved.chmod(0o640)
    ulna.save_world(ulna.World(), link)
    assert link.is_symlink()
    assert stat.S_IMODE(saved.stat().st_mode) == 0o640
    assert ulna.load_world(saved).names == ()


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_a_pipe_that_nothing_writes_to_is_not_waited_for_for_ever(tmp_path, monkeypatch):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    monkeypatch.setattr(file_bytes, "PIPE_PATIENCE_S", 0.1)
    holder = os.open(pipe, os.O_RDWR)
    start = time.monotonic()
    with pytest.raises(ulna.FileError, match="nothing came through it"):
        ulna.load_world(pipe)
    assert time.monotonic() - start < 60
    os.close(holder)


def test_a_shape_of_a_users_own_class_is_saved_as_what_it_is_checked_as(tmp_path):
    class Crate(ulna.Box):
        """A box of one's own."""

    world, path = ulna.World(), tmp_path / "scene.json"
    world.add("crate", Crate((0.1, 0.2, 0.3)))
    ulna.save_world(world, path)
    assert ulna.load_world(path).shape("crate") == ulna.Box((0.1, 0.2, 0.3))


@pytest.mark.parametrize("path", [None, 3, b"scene"])
def test_what_is_no_path_is_refused(path):
    with pytest.raises(ulna.InputError, match="path: "):
        ulna.load_world(path)
    with pytest.raises(ulna.InputError, match="path: "):
        ulna.save_world(ulna.World(), path)


def test_what_is_no_world_is_refused(tmp_path):
    with pytest.raises(ulna.InputError, match="world: "):
        ulna.save_world(None, tmp_path / "scene.json")


@pytest.mark.parametrize("path", ["no/such/folder/scene.json", "a\0b"])
def test_a_path_that_cannot_be_written_is_a_file_error(tmp_path, path):
    with pytest.raises(ulna.FileError):
        ulna.save_world(ulna.World(), tmp_path / path)
    with pytest.raises(ulna.FileError):
        ulna.load_world(tmp_path / path)
