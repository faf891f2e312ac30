"""Converts ``file://`` addresses to paths."""

import os
import re
from urllib.parse import unquote

_DRIVE = re.compile(r"/[A-Za-z]:(?=/|\\|$)")


def path_of_address(rest: str, *, windows: bool = os.name == "nt") -> str:
    """The path of an address ``file://`` + ``rest``, whose characters may be percent-encoded.

    The slash before a Windows drive is not part of the path.

    Example:
        >>> path_of_address("/C:/my%20arm.stl", windows=True), path_of_address("/C:/my%20arm.stl", windows=False)
        ('C:/my arm.stl', '/C:/my arm.stl')
    """
    path = unquote(rest)
    return path[1:] if windows and _DRIVE.match(path) else path
