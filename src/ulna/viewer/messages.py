"""Checks the messages of a browser before viser acts on them.

A browser may change the values of controls, and upload files of a limited size. viser itself sets any attribute that a message
names on a control, and keeps the parts of uploads in memory until they are complete.
"""

from collections.abc import Callable
from typing import Any

import msgspec

MAX_UPLOAD = 100_000_000  # [bytes] of a file; the same limit as for meshes and point clouds on disk
_MAX_PARTS = 10_000
_MAX_UPLOADS = 4  # of one browser at a time
_CHANGED = {"value"}  # the attributes of a control that a person may change


class Incoming:
    """The messages of one browser.

    Args:
        on_refusal: Called with the reason when an upload is refused.
    """

    def __init__(self, on_refusal: Callable[[str], object]) -> None:
        self._on_refusal = on_refusal
        self._left: dict[str, tuple[int, int]] = {}  # the bytes and parts that each upload may still send

    def is_taken(self, raw: bytes | str) -> bool:
        """Whether a message is passed on.

        Raises:
            ValueError: The page does not send such a message. Its connection is to be closed.
        """
        if not isinstance(raw, bytes):
            raise ValueError("a message is text")  # noqa: TRY004 - as the others
        message = msgspec.msgpack.decode(raw)
        if not isinstance(message, dict):
            raise ValueError("a message is not an object")  # noqa: TRY004 - as the others
        match message.get("type"):
            case "GuiUpdateMessage":
                updates = message.get("updates")
                if not isinstance(updates, dict) or not updates.keys() <= _CHANGED:
                    raise ValueError("a message changes more than the value of a control")
            case "FileTransferStartUpload":
                return self._accepts_start(message)
            case "FileTransferPart":
                return self._accepts_part(message)
        return True

    def _accepts_start(self, message: dict[str, Any]) -> bool:
        size, parts, name = (message.get(key) for key in ("size_bytes", "part_count", "transfer_uuid"))
        if not isinstance(size, int) or not isinstance(parts, int) or not isinstance(name, str) or min(size, parts) < 0:
            raise ValueError("an upload has no size")
        if size > MAX_UPLOAD or parts > _MAX_PARTS:
            self._on_refusal(f"the file has {size / 1e6:.0f} MB; the maximum is {MAX_UPLOAD // 1_000_000} MB")
            return False
        if len(self._left) >= _MAX_UPLOADS or name in self._left:
            self._on_refusal(f"at most {_MAX_UPLOADS} files can be uploaded at once")
            return False
        if parts:
            self._left[name] = size, parts
        return True

    def _accepts_part(self, message: dict[str, Any]) -> bool:
        name, content = message.get("transfer_uuid"), message.get("content")
        if not isinstance(name, str) or not isinstance(content, bytes):
            raise ValueError("a part of an upload has no content")  # noqa: TRY004 - as the others
        if name not in self._left:  # a part of a refused upload
            return False
        size, parts = self._left.pop(name)
        if len(content) > size or parts < 1:
            raise ValueError("an upload is longer than announced")
        if parts > 1:
            self._left[name] = size - len(content), parts - 1
        return True
