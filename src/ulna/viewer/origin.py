"""Serves viser's page with a title and ``head.html``, and refuses requests of foreign pages.

A browser lets any site open a websocket to 127.0.0.1, and sends the site's address in the header ``Origin``. viser does not check
it. Source: RFC 6455, section 10.2. A foreign host name can resolve to this machine (DNS rebinding): CWE-350.
"""

import contextlib
import html
import http
import logging
import threading
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import websockets.asyncio.server
from websockets.datastructures import Headers

from ulna.errors import UlnaError
from ulna.viewer.messages import Incoming

_LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}  # noqa: S104 - the loopback address for each address of all interfaces
_TITLE = b"<title>Viser</title>"
_HEAD = Path(__file__).with_name("head.html").read_bytes()  # scripts and styles, each with its reason
_CLOSE_SECONDS = 0.5  # the maximum time to wait for a browser to confirm that its connection ends
_starting = threading.Lock()
_log = logging.getLogger(__name__)


def is_own_page(headers: Headers, host: str, others: Collection[str] = ()) -> bool:
    """Whether a request comes from this server's own page, from one of ``others``, or from a program.

    The page's address must equal that of the request, and its host must be the server's ``host`` or a loopback name. A server
    that listens on all interfaces cannot know its own names, so it accepts any host name.
    """
    origins, asked = headers.get_all("Origin"), headers.get_all("Host")
    if not origins:  # a program, since browsers always send the header
        return True
    if len(origins) > 1 or len(asked) > 1:
        return False
    if origins[0] in others:
        return True
    try:
        place = urlsplit(origins[0])
    except ValueError:  # not an address, such as http://[::1
        return False
    known = host in EVERYWHERE or place.hostname in {*_LOOPBACK, host.lower()}
    return known and asked == [place.netloc]


@contextlib.contextmanager
def refusing_foreign_pages(
    host: str,
    others: Collection[str] = (),
    title: str = "Ulna",
    on_refusal: Callable[[str], object] = str,
) -> Iterator[None]:
    """A context to start a server of viser that refuses foreign pages (status 403) and whose page has a title.

    ``on_refusal`` is called with the reason when an upload is refused. The server waits at most half a second for a browser to
    confirm the end of its connection.

    viser has no argument for this, so the context replaces the function of websockets that viser calls.
    """
    guarded = []
    with _starting:
        serve = websockets.asyncio.server.serve  # read under the lock, since another thread may have replaced it

        def guarding(handler: Callable, *arguments: Any, process_request: Callable, **options: Any) -> Any:
            guarded.append(_asking(process_request, host, others, title))
            options["close_timeout"] = _CLOSE_SECONDS
            return serve(_closing_if_it_fails(handler, on_refusal), *arguments, process_request=guarded[-1], **options)

        websockets.asyncio.server.serve = guarding  # type: ignore[assignment,misc]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve  # type: ignore[misc]
    if not guarded:
        raise UlnaError("this version of viser starts its server in a way that lets foreign pages in; viser 1.1.1 works")


def _closing_if_it_fails(handler: Callable, on_refusal: Callable[[str], object]) -> Callable:
    """A handler of connections that checks their messages (``messages``).

    It closes a connection that fails, for example by a message that viser cannot decode, and logs one line.
    """

    async def handle(connection: Any) -> None:
        receive, incoming = connection.recv, Incoming(on_refusal)

        async def checked() -> Any:
            while not incoming.is_taken(message := await receive()):
                pass
            return message

        connection.recv = checked
        try:
            await handler(connection)
        except Exception as error:  # noqa: BLE001 - viser decodes with several packages, which raise their own errors
            words = " ".join(f"{type(error).__name__} {error}".split())[:200]
            _log.warning("a connection of the page was closed: %s", ascii(words))
            _log.debug("it failed here", exc_info=error)
            await connection.close(1007, "a message could not be understood")

    return handle


def _asking(process_request: Callable, host: str, others: Collection[str], title: str) -> Callable:
    """A handler of requests that refuses foreign pages, and passes the others to viser."""

    def ask(connection: Any, request: Any) -> Any:
        if not is_own_page(request.headers, host, others):
            return connection.respond(http.HTTPStatus.FORBIDDEN, "The request comes from a page of another server.\n")
        document = _asks_for_page(request)
        response = process_request(connection, request)
        return _completed(response, title) if document else response

    return ask


def _completed(response: Any, title: str) -> Any:
    """A successful response with the title, the scripts and the styles inserted; any other response unchanged."""
    if response is None or response.status_code != http.HTTPStatus.OK:
        return response
    head, found, rest = response.body.partition(b"</head>")
    head = head.replace(_TITLE, f"<title>{html.escape(title)}</title>".encode())
    response.body = head + _HEAD + found + rest
    del response.headers["Content-Length"]
    response.headers["Content-Length"] = str(len(response.body))
    return response


def _asks_for_page(request: Any) -> bool:
    """Whether a request is for the page itself. Removes its Accept-Encoding, so that the page is not compressed."""
    if request.path.partition("?")[0] not in ("/", "/index.html"):
        return False
    while "Accept-Encoding" in request.headers:
        del request.headers["Accept-Encoding"]
    return True
