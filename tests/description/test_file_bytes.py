"""Reading files, devices and pipes: at most so many bytes, and with a time limit."""

import os
import threading

import pytest

import ulna
from ulna.description import file_bytes
from ulna.description.file_bytes import regular_file_bytes

ROBOT = b'<robot name="r"><link name="a"/></robot>'


@pytest.fixture
def pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe.urdf")
    return tmp_path / "pipe.urdf"


@pytest.mark.parametrize("loads", [ulna.load, ulna.inspect, lambda pipe: ulna.load("panda", srdf=pipe)])
def test_a_pipe_without_a_writer_is_refused_after_a_time_limit(pipe, monkeypatch, loads):
    monkeypatch.setattr(file_bytes, "PIPE_PATIENCE_S", 0.1)
    with pytest.raises(ulna.FileError, match=r"pipe\.urdf: a pipe, and nothing came through it for 0\.1 s$"):
        loads(pipe)


def test_a_robot_is_read_from_a_pipe_in_parts(pipe):
    def write():
        with pipe.open("wb", buffering=0) as sink:
            for letter in ROBOT:
                sink.write(bytes([letter]))

    writer = threading.Thread(target=write)
    writer.start()
    try:
        assert ulna.load(pipe).link_names == ("a",)
    finally:
        writer.join()


def test_reading_a_pipe_or_device_stops_one_byte_after_the_limit(pipe):
    end = os.open(pipe, os.O_RDWR)
    os.write(end, b"0123456789")
    assert file_bytes.file_bytes(pipe, 4) == b"01234"
    os.close(end)
    assert file_bytes.file_bytes("/dev/zero", 4) == bytes(5)
    with pytest.raises(OSError, match="not a regular file"):
        regular_file_bytes("/dev/zero", 4)
    with pytest.raises(OSError, match="not a regular file"):
        regular_file_bytes(pipe, 4)
