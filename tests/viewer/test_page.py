"""Starting and stopping pages at the same time as others, without a browser: global state is restored."""

import contextlib
import sys
import threading
from types import SimpleNamespace

import pytest
import rich
import viser
import websockets.asyncio.server

import ulna
from processes import wait_for
from ulna.viewer import origin, page
from ulna.viewer.page import Page


class ObservedLock:
    """A lock that counts the attempts to acquire it."""

    def __init__(self):
        self.lock, self.asked = threading.Lock(), threading.Semaphore(0)

    def __enter__(self):
        self.asked.release()
        self.lock.acquire()

    def __exit__(self, *_):
        self.lock.release()


def overlapping(lock, context):
    """Enter a context; enter a second one in another thread, which must wait for the lock; leave the first, then the second."""

    def enter_and_leave():
        with contextlib.suppress(ulna.UlnaError), context():
            pass

    other = threading.Thread(target=enter_and_leave)
    with contextlib.suppress(ulna.UlnaError), context():
        assert lock.asked.acquire(timeout=240)
        other.start()
        assert lock.asked.acquire(timeout=240)
    other.join()


def test_two_pages_started_at_once_restore_the_websocket_server(monkeypatch):
    before, lock = websockets.asyncio.server.serve, ObservedLock()
    monkeypatch.setattr(origin, "_starting", lock)
    overlapping(lock, lambda: origin.refusing_foreign_pages("127.0.0.1"))
    assert websockets.asyncio.server.serve is before


def test_two_pages_started_at_once_restore_standard_output(monkeypatch):
    before, lock = sys.stdout, ObservedLock()
    monkeypatch.setattr(page, "_silence", lock)
    overlapping(lock, page._quiet)
    assert sys.stdout is before
    assert not rich.get_console().quiet


def test_only_visers_own_output_is_suppressed(monkeypatch, capsys):
    real = viser.ViserServer

    def server(**options):
        sys.stdout.write("the program's own\n")
        return real(**options)

    monkeypatch.setattr(viser, "ViserServer", server)
    Page(port=0).stop()
    assert capsys.readouterr().out == "the program's own\n"


def test_a_server_that_accepts_foreign_pages_is_stopped(monkeypatch):
    unguarded = SimpleNamespace(asyncio=SimpleNamespace(server=SimpleNamespace(serve=websockets.asyncio.server.serve)))
    monkeypatch.setattr("viser.infra._infra.websockets", unguarded)
    before = threading.active_count()
    with pytest.raises(ulna.UlnaError, match="lets foreign pages in"):
        Page(port=0)
    wait_for(lambda: threading.active_count() <= before, "no thread left")


@pytest.mark.parametrize(("host", "name"), [("0.0.0.0", "127.0.0.1"), ("::", "[::1]"), ("::1", "[::1]"), ("", "127.0.0.1")])  # noqa: S104
def test_the_url_uses_a_reachable_address_for_a_wildcard_host(monkeypatch, host, name):
    monkeypatch.setattr(page, "_refuse_busy", lambda *_: None)  # not every machine has addresses of version 6
    monkeypatch.setattr(page, "refusing_foreign_pages", lambda *_: contextlib.nullcontext())
    server = SimpleNamespace(
        gui=SimpleNamespace(configure_theme=lambda **_: None, main_panel=SimpleNamespace(dock_right=lambda: None)),
        get_port=lambda: 8080,
    )
    monkeypatch.setattr(viser, "ViserServer", lambda **_: server)
    assert Page(host).url == f"http://{name}:8080"
