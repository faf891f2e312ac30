"""An object file that a process was writing when it failed is not there, or is as it was."""

import sys
from pathlib import Path

import pytest

from fresh_process import run_fresh
from ulna.engine.emit import write_whole

pytestmark = pytest.mark.compiler

FULL_DISK = """
import errno, resource, signal
from pathlib import Path

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))  # of a file that is written from now on
folder = Path({folder!r})
try:
    {write}
except OSError as error:
    assert error.errno == errno.EFBIG
    print(sorted(path.name for path in folder.iterdir()))
"""


def test_a_file_is_written_and_replaced(tmp_path):
    path = tmp_path / "a.o"
    for content in (b"first", b"second"):
        write_whole(path, content)
        assert path.read_bytes() == content
    assert [file.name for file in tmp_path.iterdir()] == ["a.o"]


def test_a_file_stays_as_it_was_where_writing_is_interrupted(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    path = tmp_path / "a.o"
    path.write_bytes(b"before")
    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(path, b"after")
    assert path.read_bytes() == b"before"
    assert [file.name for file in tmp_path.iterdir()] == ["a.o"]


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot limit its files there")
def test_a_build_on_a_full_disk_keeps_no_part_of_an_object_file(tmp_path):
    """What is there is kept by the next build, so a part of it would be linked."""
    write = f"""import ulna.engine.emit as emit
    emit._object_code, emit._module_of, emit._own_hash = lambda *_: bytes(5000), lambda _: None, lambda: "hash"
    emit._write_shared(type("Shared", (), dict(symbol="power")), Path({str(tmp_path)!r}))"""
    assert run_fresh(FULL_DISK.format(folder=str(tmp_path), write=write)) == ["[]"]
