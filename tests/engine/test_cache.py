"""The machine code on disk: never stale, put where it should be, and never needed.

Processes of their own, with a cache folder of their own, run the library.
"""

import os
import pickle
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fresh_process import PACKAGE, run_fresh
from ulna.engine import cache, private_folder

pytestmark = pytest.mark.compiler

PLACE = """
import sys, numba, ulna
print(*ulna.load("panda").forward_kinematics([0.0] * 7)[:3, 3].round(9).tolist())
from ulna.kinematics.entries import forward
from ulna.engine.cache import cache_folder
forward_one = forward.forward_one
print(sum(forward_one.stats.cache_hits.values()), sum(forward_one.stats.cache_misses.values()))
print(repr(numba.config.CACHE_DIR))
print(getattr(cache_folder(), "path", None))
"""
AT_ZERO = "0.088 -0.0 0.8226"


def run(source=PLACE, **options):
    return run_fresh(source, **options)


@pytest.fixture
def cache_folder(monkeypatch, tmp_path):
    """The function, without what it found before, and its base below ``tmp_path``."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return cache.cache_folder.__wrapped__


@pytest.fixture
def clone(tmp_path):
    """A copy of the package: the folder that it lies in."""
    shutil.copytree(PACKAGE, tmp_path / "src" / "ulna", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "src"


@pytest.mark.process
def test_a_second_process_compiles_nothing(tmp_path):
    first, second = (run(NUMBA_CACHE_DIR=tmp_path) for _ in range(2))
    assert first[:2] == [AT_ZERO, "0 1"]
    assert second[:2] == [AT_ZERO, "1 0"]


@pytest.mark.process
def test_a_change_in_a_kernel_that_an_entry_calls_is_never_served_from_the_cache(clone, tmp_path):
    """Numba's own cache looks at the entry's file alone, and would. And what another clone put there stays."""
    changed = clone / "ulna" / "kernels" / "spatial" / "se3.py"
    original = changed.read_text()
    assert run(src=clone, NUMBA_CACHE_DIR=tmp_path)[0] == AT_ZERO
    changed.write_text(
        original.replace("a[0] * b[3] + a[1] * b[7] + a[2] * b[11] + a[3],", "a[0] * b[3] + a[1] * b[7] + a[2] * b[11] + 1.0,")
    )
    assert run(src=clone, NUMBA_CACHE_DIR=tmp_path)[:2] == ["1.0 -0.0 0.8226", "0 1"]
    assert run(NUMBA_CACHE_DIR=tmp_path)[:2] == [AT_ZERO, "1 0"]
    changed.write_text(original)
    assert run(src=clone, NUMBA_CACHE_DIR=tmp_path)[:2] == [AT_ZERO, "1 0"]


@pytest.mark.process
def test_a_change_in_the_lamp_of_a_film_leaves_the_machine_code_of_a_pose(clone, tmp_path):
    lamp = clone / "ulna" / "kernels" / "render" / "illumination.py"
    assert run(src=clone, NUMBA_CACHE_DIR=tmp_path)[1] == "0 1"
    lamp.write_text(lamp.read_text().replace("LAMP_REACH, LAMP_SHARE = 0.17, 0.9", "LAMP_REACH, LAMP_SHARE = 0.18, 0.8"))
    assert run(src=clone, NUMBA_CACHE_DIR=tmp_path)[1] == "1 0"


@pytest.mark.process
def test_a_kernel_that_is_edited_while_a_program_runs_does_not_mix_old_code_with_a_new_key(clone, tmp_path):
    """The first process loads a kernel, then the file changes, then another entry compiles that kernel as it was loaded."""
    early = (
        "import ulna.kinematics.entries.forward, pathlib, ulna\n"
        "file = pathlib.Path(ulna.kernels.spatial.se3.__file__); text = file.read_text()\n"
        "file.write_text(text.replace('a[2] * b[11] + a[3],', 'a[2] * b[11] + 1.0,'))\n"
        "print(*ulna.load('panda').jacobian([0.0] * 7)[:2, 0].round(9).tolist())\n"
    )
    late = "import ulna; print(*ulna.load('panda').jacobian([0.0] * 7)[:2, 0].round(9).tolist())"
    assert run(early, src=clone, NUMBA_CACHE_DIR=tmp_path) == ["0.0 0.088"]
    assert run(late, src=clone, NUMBA_CACHE_DIR=tmp_path) == ["0.0 1.0"]


@pytest.mark.process
def test_the_users_folder_is_honoured_and_numbas_setting_left_as_it_was(tmp_path):
    home = tmp_path / "home"
    *_, setting, folder = run(NUMBA_CACHE_DIR=tmp_path / "here", HOME=home)
    assert setting == repr(str(tmp_path / "here"))
    assert Path(folder).parent == tmp_path / "here" / "ulna"
    assert any(Path(folder).glob("*.nbc"))
    assert not home.exists()
    assert run("import numba, ulna, ulna.kernels.chain.poses; print(repr(numba.config.CACHE_DIR))", HOME=home) == ["''"]


@pytest.mark.process
@pytest.mark.skipif(sys.platform != "linux", reason="the places of other systems")
def test_otherwise_it_lies_in_the_users_cache_folder(tmp_path):
    where = "from ulna.engine.cache import cache_folder; print(cache_folder().path.parent)"
    assert run(where, HOME=tmp_path) == [str(tmp_path / ".cache" / "ulna")]
    assert run(where, HOME=tmp_path, XDG_CACHE_HOME=tmp_path / "xdg") == [str(tmp_path / "xdg" / "ulna")]


RELATIVE = ["cache", "./cache", "../cache", "."]


@pytest.mark.skipif(sys.platform != "linux", reason="the places of other systems")
@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
@pytest.mark.parametrize("path", RELATIVE)
def test_a_relative_path_does_not_lead_into_the_folder_of_a_stranger(tmp_path, monkeypatch, variable, path):
    """Files of the cache are unpickled, and those in the current folder may be anyone's."""
    stranger, home = tmp_path / "stranger" / "robot", tmp_path / "home"
    stranger.mkdir(parents=True)
    home.mkdir()
    monkeypatch.chdir(stranger)
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv(variable, path)
    with pytest.warns(RuntimeWarning, match=f"^{variable} is .* a relative path, which is ignored"):
        folder = cache.cache_folder.__wrapped__()
    assert folder is not None
    assert folder.path.parent == home / ".cache" / "ulna"
    assert not [*stranger.parent.rglob("*cache*"), *stranger.iterdir()]


@pytest.mark.parametrize("home", RELATIVE)
def test_a_relative_home_is_none(tmp_path, monkeypatch, home):
    monkeypatch.chdir(tmp_path)
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", home)
    assert cache.cache_folder.__wrapped__() is None
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("path", RELATIVE)
def test_a_relative_path_of_windows_is_ignored_too(monkeypatch, path):
    monkeypatch.setattr(private_folder.sys, "platform", "win32")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("LOCALAPPDATA", path)
    with pytest.warns(RuntimeWarning, match="^LOCALAPPDATA is .* a relative path"):
        assert private_folder.cache_base() == Path.home() / "AppData" / "Local" / "ulna" / "cache"


@pytest.mark.process
def test_a_folder_that_cannot_be_written_costs_a_compilation_and_nothing_else(tmp_path):
    file = tmp_path / "file"
    file.touch()
    answer, stats, _, folder = run(NUMBA_CACHE_DIR=file / "below")
    assert (answer, stats, folder) == (AT_ZERO, "0 1", "None")


@pytest.mark.process
def test_a_folder_that_goes_away_costs_a_compilation_and_nothing_else(tmp_path):
    remove = (
        "import shutil, ulna.kernels.chain.poses; from ulna.engine.cache import cache_folder\n"
        "shutil.rmtree(cache_folder().path)\n"
    )
    assert run(remove + PLACE, NUMBA_CACHE_DIR=tmp_path)[0] == AT_ZERO


@pytest.mark.process
@pytest.mark.parametrize("damage", [b"", b"\x80\x04junk"])
def test_a_damaged_file_costs_a_compilation_and_nothing_else(tmp_path, damage):
    """As a full disk or a lost current leaves them."""
    *_, folder = run(NUMBA_CACHE_DIR=tmp_path)
    for file in Path(folder).glob("*.nbc"):
        file.write_bytes(damage)
    assert run(NUMBA_CACHE_DIR=tmp_path)[:2] == [AT_ZERO, "0 1"]
    assert run(NUMBA_CACHE_DIR=tmp_path)[:2] == [AT_ZERO, "1 0"]


def test_a_user_without_a_home_has_no_cache_and_no_error(monkeypatch):
    """As in a container that is started under some number: no HOME, and no entry in the table of users."""

    def nobody(_):
        raise KeyError

    monkeypatch.setattr(pytest.importorskip("pwd"), "getpwuid", nobody)
    for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    assert cache.cache_folder.__wrapped__() is None


def test_folders_and_files_that_nobody_used_for_a_month_are_removed(tmp_path, cache_folder):
    now, own = time.time(), f"kernels-{cache.compiler_hash()}"
    for name, days in (("kernels-old", 31), ("kernels-young", 29), ("other", 400), (own, 31)):
        (tmp_path / "ulna" / name).mkdir(parents=True, mode=0o700)
        for file in ("a.nbc", "a.nbc.tmp.1"):
            (tmp_path / "ulna" / name / file).touch()
            os.utime(tmp_path / "ulna" / name / file, (now - days * 86400,) * 2)
        os.utime(tmp_path / "ulna" / name, (now - days * 86400,) * 2)
    (tmp_path / "ulna" / own / "used.nbc").touch()
    folder = cache_folder().path
    assert {path.name for path in (tmp_path / "ulna").iterdir()} == {own, "kernels-young", "other"}
    assert [path.name for path in folder.iterdir()] == ["used.nbc"]
    assert now - folder.stat().st_mtime < 3600


@pytest.mark.process
def test_machine_code_that_is_loaded_counts_as_used(tmp_path):
    *_, folder = run(NUMBA_CACHE_DIR=tmp_path)
    for file in Path(folder).glob("*.nbc"):
        os.utime(file, (0, 0))
    loaded = (
        "import ulna; from ulna.engine.private_folder import PrivateFolder; PrivateFolder.remove_unused = lambda *_: None\n"
        + PLACE
    )
    assert run(loaded, NUMBA_CACHE_DIR=tmp_path)[1] == "1 0"
    assert run(NUMBA_CACHE_DIR=tmp_path)[1] == "1 0"


def test_a_folder_that_cannot_be_removed_costs_no_other_its_cache(tmp_path, cache_folder):
    for name in ("kernels-a", "kernels-b"):
        (tmp_path / "ulna" / name / "in_the_way").mkdir(parents=True)  # rmdir refuses, as it does a folder of another user's
        os.utime(tmp_path / "ulna" / name, (0, 0))
    assert cache_folder().path.parent == tmp_path / "ulna"


def test_the_folder_and_the_one_above_it_are_for_the_user_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    (tmp_path / "ulna").mkdir(mode=0o755)  # as earlier versions made it
    folder = cache.cache_folder.__wrapped__().path
    assert [path.stat().st_mode & 0o777 for path in (folder, folder.parent)] == [0o700, 0o700]


def shared_by_an_open_folder(base, name):
    (base / "ulna" / name).mkdir(parents=True)
    (base / "ulna" / name).chmod(0o777)


def shared_by_a_link(base, name):
    (base / "elsewhere").mkdir(mode=0o700)
    (base / "ulna").mkdir()
    (base / "ulna" / name).symlink_to(base / "elsewhere")


def shared_by_a_folder_above(base, name):
    base.chmod(0o777)


def shared_by_an_owner(base, name):
    (base / "ulna" / name).mkdir(parents=True, mode=0o700)
    os.chown(base / "ulna", 65534, -1)


def shared_by_the_owner_of_the_folder_itself(base, name):
    (base / "ulna" / name).mkdir(parents=True, mode=0o700)
    os.chown(base / "ulna" / name, 65534, -1)


SHARED = {
    shared_by_an_open_folder: r"is open to other users \(mode 0777; 0700 is needed\)",
    shared_by_a_link: "is not a folder",
    shared_by_a_folder_above: r"lets other users replace its files \(mode 0777\)",
    shared_by_an_owner: r"belongs to another user \(number 65534\)",
    shared_by_the_owner_of_the_folder_itself: r"belongs to another user \(number 65534\)",
}


@pytest.mark.parametrize("shared", SHARED)
def test_a_folder_in_which_another_user_could_have_put_code_is_not_used_and_that_is_said(tmp_path, monkeypatch, shared):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    if "owner" in shared.__name__ and os.geteuid():
        pytest.skip("only root can give a folder away")
    shared(tmp_path, f"kernels-{cache.compiler_hash()}")
    with pytest.warns(RuntimeWarning, match=rf"^ulna: the cache of compiled code is not used: .* {SHARED[shared]}"):
        assert cache.cache_folder.__wrapped__() is None


def test_a_shared_folder_with_a_sticky_bit_holds_a_folder_of_each_user(tmp_path, monkeypatch):
    tmp_path.chmod(0o1777)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert cache.cache_folder.__wrapped__().path.parent == tmp_path / "ulna"


class Planted:
    """What runs when it is unpickled: it makes a file."""

    def __init__(self, mark):
        self.mark = mark

    def __reduce__(self):
        return Path.touch, (self.mark,)


@pytest.mark.process
@pytest.mark.parametrize("mode", [0o777, 0o700], ids=["open to others", "the user's alone"])
def test_what_another_user_planted_is_not_run(tmp_path, mode):
    mark, base = tmp_path / "it ran", tmp_path / "cache"
    folder = Path(run(NUMBA_CACHE_DIR=base)[-1])
    for kept in folder.glob("*.nbc"):
        kept.write_bytes(pickle.dumps(Planted(mark)))
    folder.chmod(mode)
    said = run('import warnings; warnings.simplefilter("ignore")\n' + PLACE, NUMBA_CACHE_DIR=base)
    assert said[0] == AT_ZERO
    assert mark.exists() == (mode == 0o700)  # in the user's own folder it is read: so the plant is where the library looks


@pytest.mark.process
@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="an open folder of Windows cannot be renamed")
def test_a_folder_that_is_exchanged_after_it_was_checked_is_not_read(tmp_path):
    """As another user can who may write in a folder above: that of a group, or his own."""
    mark, base = tmp_path / "it ran", tmp_path / "cache"
    folder = Path(run(NUMBA_CACHE_DIR=base)[-1])
    planted = tmp_path / "planted" / folder.name
    planted.mkdir(parents=True)
    for kept in folder.glob("*.nbc"):
        (planted / kept.name).write_bytes(pickle.dumps(Planted(mark)))
    exchange = (
        "import os, ulna.kinematics.entries.forward; from ulna.engine.cache import cache_folder; cache_folder()\n"
        f"os.rename({str(base / 'ulna')!r}, {str(base / 'was')!r}); os.rename({str(planted.parent)!r}, {str(base / 'ulna')!r})\n"
    )
    assert run(exchange + PLACE, NUMBA_CACHE_DIR=base)[:2] == [AT_ZERO, "1 0"]
    assert not mark.exists()


def test_the_users_cache_folder_may_be_a_link_to_another_of_his(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    (tmp_path / "disk" / "of ulna").mkdir(parents=True)
    (tmp_path / "ulna").symlink_to(tmp_path / "disk" / "of ulna")
    folder = cache.cache_folder.__wrapped__()
    assert folder.path.parent == tmp_path / "disk" / "of ulna"
    (tmp_path / "disk").chmod(0o777)
    with pytest.warns(RuntimeWarning, match="lets other users replace"):
        assert cache.cache_folder.__wrapped__() is None


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_terminal_shows_a_compilation_and_only_that(tmp_path):
    said = []
    for _ in range(2):
        leader, follower = os.openpty()
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(PACKAGE.parent)}
        subprocess.run([sys.executable, "-c", PLACE], env=environment, stderr=follower, stdout=subprocess.DEVNULL, check=True)
        os.write(follower, b"end")
        text = b""
        while not text.endswith(b"end"):
            text += os.read(leader, 10_000)
        said.append(text.decode())
        os.close(leader)
        os.close(follower)
    assert "compiling forward_one for this machine" in said[0]
    assert said[0].endswith("\nend")
    assert said[1] == "end"


@pytest.mark.process
def test_a_pipe_gets_one_line_about_all_that_is_compiled(tmp_path):
    code = "from ulna.engine import announcements; announcements._NEXT_WITHIN_S = 1e9; "  # however busy the machine is
    code += "import ulna; panda = ulna.load('panda'); panda.jacobian(panda.home); panda.forward_kinematics(panda.home)"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(PACKAGE.parent)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    command = [sys.executable, "-c", code]
    said = [subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stderr for _ in range(2)]
    assert said[0].startswith("ulna: compiling jacobian_one ")
    assert (said[0].count("\n"), said[1]) == (1, "")
