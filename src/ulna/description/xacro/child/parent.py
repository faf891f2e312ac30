"""Requests files from the parent process, the only one that opens any, by lines of JSON."""

import io
import json
import os
from typing import Any, BinaryIO

MAX_LINE = 1_000_000  # bytes of a message of the child; the URDF follows its message
MAX_SENTENCE = 1000  # characters of an error


class RefusedError(Exception):
    """A document asked for something that is not allowed."""


class Parent:
    """The two pipes to the parent process."""

    def __init__(self, source: BinaryIO, sink: BinaryIO) -> None:
        self._source, self._sink = source, sink

    def receive(self) -> dict[str, Any]:
        """The next message of the parent."""
        return json.loads(self._source.readline())

    def send(self, message: dict[str, Any]) -> None:
        """Send a message to the parent.

        Raises:
            RefusedError: It is longer than the parent reads.
        """
        line = json.dumps(message).encode() + b"\n"
        if len(line) > MAX_LINE:
            raise RefusedError(f"a name or a path of {len(line)} bytes; up to {MAX_LINE} are looked up")
        self._sink.write(line)
        self._sink.flush()

    def send_urdf(self, urdf: bytes, asked: list[str]) -> None:
        """Send the last message: the URDF's length, the names of looked-up arguments, and the URDF."""
        self.send({"urdf": len(urdf), "asked": asked})
        self._sink.write(urdf)
        self._sink.flush()

    def open(self, path: str, mode: str = "r") -> io.StringIO:
        """The text of a file, in place of the built-in ``open``."""
        if not isinstance(path, str) or mode != "r":
            raise RefusedError(f"opens {path!r} with {mode!r}; a description can only read text files")
        return io.StringIO(self._request({"read": path})["text"], newline=None)

    def find(self, package: str) -> str:
        """The folder of a package."""
        return self._request({"find": package})["folder"]

    def matching(self, pattern: str) -> list[str]:
        """The files that match a pattern, in place of ``glob.glob``."""
        return self._request({"matching": pattern})["files"]

    def _request(self, question: dict[str, str]) -> dict[str, Any]:
        self.send(question)
        found = self.receive()
        if "refused" in found:
            raise RefusedError(found["refused"])
        if "failed" in found:
            number, words = found["failed"]
            raise OSError(number, words, os.fspath(next(iter(question.values()))))
        return found
