"""What a tab may send: values of controls and files of a limited size, and nothing that stays after its connection."""

import contextlib

import msgspec
import pytest
import viser
import websockets
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from processes import wait_for
from ulna.viewer import messages
from ulna.viewer.messages import MAX_UPLOAD, Incoming
from ulna.viewer.page import Page


@pytest.fixture
def page():
    page = Page(port=0)
    yield page
    page.stop()


def tab_of(page: Page) -> ClientConnection:
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    return connect(page.url.replace("http", "ws"), origin=page.url, subprotocols=protocol, max_size=None)  # pyright: ignore[reportArgumentType]


def encoded(kind: str, **fields: object) -> bytes:
    return msgspec.msgpack.encode({"type": kind, **fields})


def begun(size: int, parts: int, name: str = "t", uuid: str = "u") -> bytes:
    more = {"filename": "a.csv", "mime_type": "text/csv", "source_component_uuid": uuid}
    return encoded("FileTransferStartUpload", transfer_uuid=name, part_count=parts, size_bytes=size, **more)


def part(content: bytes, k: int = 0, name: str = "t", uuid: str = "u") -> bytes:
    return encoded("FileTransferPart", transfer_uuid=name, part_index=k, content=content, source_component_uuid=uuid)


def until_closed(tab: ClientConnection) -> None:
    with contextlib.suppress(websockets.exceptions.ConnectionClosed):
        while True:
            tab.recv(timeout=60)


@pytest.mark.parametrize("updates", [{"props": {}}, {"update_cb": []}, {"value": 2, "removed": True}, {"is_button": 1}, [], None])
def test_a_message_that_changes_more_than_a_value_changes_nothing_and_closes_its_connection(page, updates):
    number = page.server.gui.add_number("n", 1)
    with tab_of(page) as tab:
        tab.send(encoded("GuiUpdateMessage", uuid=number._impl.uuid, updates=updates))
        until_closed(tab)
    assert number.value == 1
    number.label = "it can still be changed"
    assert number.label == "it can still be changed"


def test_a_value_is_taken(page):
    number = page.server.gui.add_number("n", 1)
    with tab_of(page) as tab:
        tab.send(encoded("GuiUpdateMessage", uuid=number._impl.uuid, updates={"value": 5}))
        wait_for(lambda: number.value == 5, "the value of the tab")


def test_an_upload_within_the_limit_arrives_and_one_beyond_it_is_refused_before_it_does(page, monkeypatch):
    monkeypatch.setattr(messages, "MAX_UPLOAD", 100)
    said = []
    monkeypatch.setattr(page.server, "get_clients", lambda: said.append("asked") or {})
    button = page.server.gui.add_upload_button("f")
    with tab_of(page) as tab:
        uuid = button._impl.uuid
        tab.send(begun(101, 1, "big", uuid))
        tab.send(part(b"x" * 101, name="big", uuid=uuid))
        tab.send(begun(100, 2, "small", uuid))
        tab.send(part(b"x" * 50, 0, "small", uuid))
        tab.send(part(b"y" * 50, 1, "small", uuid))
        wait_for(lambda: button.value.content, "the small file")
    assert button.value.content == b"x" * 50 + b"y" * 50
    assert said == ["asked"]


REFUSED = {
    "longer than announced": [begun(10, 2), part(b"x" * 11)],
    "longer in sum": [begun(10, 3), part(b"x" * 9), part(b"x" * 9, 1)],
    "no size": [encoded("FileTransferStartUpload", transfer_uuid="t")],
    "a size below 0": [begun(-1, 1)],
    "no content": [begun(10, 1), encoded("FileTransferPart", transfer_uuid="t", content=None)],
    "text": ["text"],
    "a list": [msgspec.msgpack.encode([])],
}


@pytest.mark.parametrize("name", REFUSED)
def test_an_upload_that_contradicts_itself_ends_its_connection(name):
    incoming, sent = Incoming(str), REFUSED[name]
    assert all(incoming.is_taken(message) for message in sent[:-1])
    with pytest.raises(ValueError, match=r"upload|message"):
        incoming.is_taken(sent[-1])


@pytest.mark.parametrize("message", [begun(MAX_UPLOAD + 1, 1), begun(1, 10**6), begun(1 << 62, 1)])
def test_what_is_too_long_is_neither_begun_nor_kept(message):
    words = []
    incoming = Incoming(words.append)
    assert not incoming.is_taken(message)
    assert not incoming.is_taken(part(b"x"))
    assert len(words) == 1


def test_a_tab_has_few_uploads_at_once():
    incoming = Incoming(str)
    assert [incoming.is_taken(begun(10, 2, str(k))) for k in range(6)] == [True] * 4 + [False] * 2
    assert incoming.is_taken(part(b"x", 0, "0"))
    assert incoming.is_taken(part(b"x", 1, "0"))
    assert incoming.is_taken(begun(10, 2, "7"))


def test_a_tab_that_does_not_confirm_its_end_does_not_hold_up_the_page(monkeypatch):
    """It reads nothing: the event of the closing handshake never comes. Without a limit a connection is waited for 10 s."""
    asked = []
    serve = websockets.asyncio.server.serve
    monkeypatch.setattr("websockets.asyncio.server.serve", lambda *a, **o: asked.append(o["close_timeout"]) or serve(*a, **o))
    page = Page(port=0)
    tab = tab_of(page)
    threads = page.server._websock_server._server_thread
    page.stop()
    wait_for(lambda: not threads.is_alive(), "the server's thread to end", looks=50)
    assert asked == [0.5]
    with contextlib.suppress(Exception):
        tab.close()
