"""Several tabs, foreign pages, closed tabs, and the end of a view."""

import contextlib
import logging
import threading

import msgspec
import numpy as np
import pytest
import viser
import websockets
from websockets.datastructures import Headers
from websockets.sync.client import connect
from websockets.typing import Subprotocol

import ulna
from browser import arrow, drag
from processes import wait_for
from ulna.viewer.origin import is_own_page


def headers(origin, host="127.0.0.1:8080"):
    return Headers([("Host", host), *([("Origin", origin)] if origin is not None else [])])


@pytest.mark.parametrize("origin", [None, "http://127.0.0.1:8080"])
def test_the_page_itself_and_programs_may_connect(origin):
    assert is_own_page(headers(origin), "127.0.0.1")


def test_a_page_behind_a_tunnel_may_connect():
    assert is_own_page(headers("http://localhost:9999", "localhost:9999"), "127.0.0.1")


@pytest.mark.parametrize(
    ("origin", "host"),
    [
        ("http://evil.example", "127.0.0.1:8080"),
        ("http://127.0.0.1:9999", "127.0.0.1:8080"),  # another server of this machine
        ("http://127.0.0.1.evil.example:8080", "127.0.0.1:8080"),
        ("http://evil.example:8080", "evil.example:8080"),  # a name made to lead here
        ("null", "127.0.0.1:8080"),
        ("", "127.0.0.1:8080"),
        ("http://[::1", "127.0.0.1:8080"),
        ("http://[::1]evil:8080", "127.0.0.1:8080"),
        ("http://127.0.0.1:99999999", "127.0.0.1:8080"),
        ("http://127.0.0.1:8080@evil.example", "127.0.0.1:8080"),
    ],
)
def test_foreign_pages_may_not_connect(origin, host):
    assert not is_own_page(headers(origin, host), "127.0.0.1")


def test_a_server_on_all_interfaces_accepts_only_pages_of_the_requested_host():
    assert is_own_page(headers("http://lab.local:8080", "lab.local:8080"), "0.0.0.0")  # noqa: S104
    assert not is_own_page(headers("http://evil.example", "lab.local:8080"), "0.0.0.0")  # noqa: S104


def test_pages_of_the_given_origins_may_connect():
    assert is_own_page(headers("https://hub.example"), "127.0.0.1", ("https://hub.example",))


def test_a_foreign_page_cannot_open_the_websocket(view):
    address = view.url.replace("http", "ws")
    with pytest.raises(websockets.exceptions.InvalidStatus) as refused:
        connect(address, origin="http://evil.example")
    assert refused.value.response.status_code == 403
    with connect(address, origin=view.url):
        pass


MESSAGES = {
    "no message": b"\0",
    "junk": b"junk" * 100,
    "an unknown kind": msgspec.msgpack.encode({"type": "Nope"}),
    "a list": msgspec.msgpack.encode([]),
    "a text": "text",
    "nested deeply": b"\x91" * 100_000,
    "a list without its items": b"\xdd\xff\xff\xff\xff",
    "an update of nothing": msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1}}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MESSAGES)
def test_a_malformed_message_closes_its_connection_and_prints_no_traceback(view, name, caplog, capfd):
    address = view.url.replace("http", "ws")
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    with connect(address, origin=view.url, subprotocols=protocol, max_size=None) as tab:
        tab.send(MESSAGES[name])
        with contextlib.suppress(websockets.exceptions.ConnectionClosed, TimeoutError):
            while True:
                tab.recv(timeout=2)
    with connect(address, origin=view.url, subprotocols=protocol, max_size=None) as tab:
        assert tab.recv(timeout=10)
    assert not [record for record in caplog.records if record.exc_info and record.levelno >= logging.WARNING]
    assert "Traceback" not in capfd.readouterr().err


def test_the_view_listens_on_the_loopback_interface_only(view):
    assert view.page.server.get_host() == "127.0.0.1"
    assert view.url.startswith("http://127.0.0.1:")


def type_number(page, name, value):
    field = page.get_by_role("textbox", name=name)
    field.fill(value)
    field.press("Enter")


def number(page, name):
    return page.get_by_role("textbox", name=name).input_value()


@pytest.mark.slow
def test_two_tabs_show_the_same_robot_and_do_not_overwrite_each_other(view, panda, open_page, monkeypatch):
    first, second = open_page(view.url), open_page(view.url, browser=1)
    wait_for(lambda: len(view.page.server.get_clients()) == 2, "two tabs")
    wait_for(lambda: view.ready and not view.notice.text, "a page that is ready", looks=None)
    type_number(first, "joint2", "-0.5")
    wait_for(lambda: number(second, "joint2") == "-0.5" and view.q[1] == pytest.approx(-0.5), "the number in both tabs")
    type_number(second, "joint2", "-0.25")
    wait_for(lambda: number(first, "joint2") == "-0.25" and view.q[1] == pytest.approx(-0.25), "the other number in both")
    sent = []
    buffer = view.page.server._websock_server.get_message_buffer()
    monkeypatch.setattr(buffer, "push", lambda message, push=buffer.push: (sent.append(message), push(message)))
    first.wait_for_timeout(1500)
    assert sent == []  # at rest nothing is sent: no tab answers the other

    view.q = panda.home
    camera = next(iter(view.page.server.get_clients().values())).camera
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    wait_for(lambda: np.allclose(view.hand.handles.pose, T), "the handles at the hand")
    drag(first, view.hand.handles, arrow(camera, T, 2, size), (0, 48), "blue")
    wait_for(lambda: not view.session.moving and view.session.hand_pose[2, 3] < T[2, 3] - 0.02, "the arm after it")
    shown = round(float(view.q[3]), 3)
    wait_for(lambda: number(second, "joint4") == f"{shown:g}", "the drag in the other tab")
    first.close()  # without letting go
    wait_for(lambda: not view.hand.handles.dragged and view.session.target is None, "a released hand")
    wait_for(lambda: len(view.page.server.get_clients()) == 1, "one tab")
    second.close()
    wait_for(lambda: not view.page.server.get_clients(), "no tab")


@pytest.mark.slow
def test_a_closed_tab_leaves_no_thread_and_no_client(view, open_page):
    open_page(view.url).close()  # the threads that serve pages exist from now on
    wait_for(lambda: not view.page.server.get_clients(), "no tab")
    before = threading.active_count()
    for _ in range(3):
        open_page(view.url).close()
    wait_for(lambda: not view.page.server.get_clients(), "no tab")
    assert threading.active_count() <= before + 1
    assert not view.page.server._websock_server._client_state_from_id


@pytest.mark.slow
def test_stopping_leaves_no_thread_and_frees_the_port(panda):
    before = threading.active_count()
    view = ulna.view(panda)
    port = view.page.server.get_port()
    view.stop()
    view.stop()
    wait_for(lambda: threading.active_count() <= before, "no thread left")
    with ulna.view(panda, port=port), pytest.raises(ulna.InputError, match="in use"):
        ulna.view(panda, port=port)


def test_a_notebook_shows_the_page_in_a_titled_iframe(view):
    shown = view._repr_html_()
    assert f'src="{view.url}"' in shown
    assert "<iframe" in shown
    assert "title=" in shown
