"""Requests files from the parent process, the only one that opens any, by lines of JSON."""

import io
import json
import os
from typing import Any, BinaryIO


class RefusedError(Exception):
    """A document asked for what it may not have."""


class Parent:
    """The two pipes to the parent process."""

    def __init__(self, source: BinaryIO, sink: BinaryIO) -> None:
        self._source, self._sink = source, sink

    def receive(self) -> dict[str, Any]:
        """The next message of the parent."""
        return json.loads(self._source.readline())

    def send(self, message: dict[str, Any]) -> None:
        """Send a message to the parent."""
        self._sink.write(json.dumps(message).encode() + b"\n")
        self._sink.flush()

    def open(self, path: str, mode: str = "r") -> io.StringIO:
        """The text of a file, in place of the built-in ``open``."""
        if not isinstance(path, str) or mode != "r":
            raise RefusedError(f"opens {path!r} with {mode!r}; a description can only read text files")
        return io.StringIO(self._asked({"read": path})["text"], newline=None)

    def find(self, package: str) -> str:
        """The folder of a package."""
        return self._asked({"find": package})["folder"]

    def matching(self, pattern: str) -> list[str]:
        """The files that match a pattern, in place of ``glob.glob``."""
        return self._asked({"matching": pattern})["files"]

    def _asked(self, question: dict[str, str]) -> dict[str, Any]:
        self.send(question)
        found = self.receive()
        if "refused" in found:
            raise RefusedError(found["refused"])
        if "failed" in found:
            number, words = found["failed"]
            raise OSError(number, words, os.fspath(next(iter(question.values()))))
        return found
