"""What stands behind ``file://``."""

import os
import re
from urllib.parse import unquote

_DRIVE = re.compile(r"/[A-Za-z]:(?=/|\\|$)")


def path_of_address(rest: str, *, windows: bool = os.name == "nt") -> str:
    """The path of an address ``file://`` + ``rest``, whose characters may be percent-encoded.

    Before a drive of Windows stands the slash of the address, which is no part of the path.

    Example:
        >>> path_of_address("/C:/my%20arm.stl", windows=True), path_of_address("/C:/my%20arm.stl", windows=False)
        ('C:/my arm.stl', '/C:/my arm.stl')
    """
    path = unquote(rest)
    return path[1:] if windows and _DRIVE.match(path) else path
