"""Adds to viser's page: its title, names for screen readers, scripts for drags and typing, a style. Used by ``origin``."""

import html
import http
from typing import Any

from ulna.viewer import accessible_names, drags, layout, typed
from ulna.viewer.configuration import COPY_SCRIPT

_TITLE = b"<title>Viser</title>"


def completed(response: Any, title: str) -> Any:
    """A successful response with the title, the scripts and the style inserted; any other response unchanged."""
    if response is None or response.status_code != http.HTTPStatus.OK:
        return response
    head, found, rest = response.body.partition(b"</head>")
    head = head.replace(_TITLE, f"<title>{html.escape(title)}</title>".encode())
    response.body = head + accessible_names.SCRIPT + drags.SCRIPT + typed.SCRIPT + COPY_SCRIPT + layout.STYLE + found + rest
    del response.headers["Content-Length"]
    response.headers["Content-Length"] = str(len(response.body))
    return response


def asks_for_page(request: Any) -> bool:
    """Whether a request is for the page itself. If so, its Accept-Encoding is removed, so that the text is not compressed."""
    if request.path.partition("?")[0] not in ("/", "/index.html"):
        return False
    while "Accept-Encoding" in request.headers:
        del request.headers["Accept-Encoding"]
    return True
