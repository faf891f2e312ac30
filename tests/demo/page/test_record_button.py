"""The Record button without a browser: one tab, which presses it and is closed."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from processes import wait_for
from ulna.demo import record_button
from ulna.demo.player import Player
from ulna.demo.record_button import LONGEST_S, RecordButton, evenly_spaced
from ulna.demo.scenario import Demo

SCREEN = SimpleNamespace(draw_arm=len, draw_report=str)


class FakeServer:
    """The part of viser's server that the button uses; ``press`` clicks the button."""

    def __init__(self):
        camera = SimpleNamespace(position=np.array([1.5, 1.3, 1.0]), look_at=np.zeros(3), fov=0.7, aspect=1.5)
        self.client = SimpleNamespace(client_id=7, camera=camera, send_file_download=self._download)
        self.clients, self.files, self.gui, self.words = {7: self.client}, {}, self, ""

    def _download(self, name, content):
        self.files[name] = content

    def add_html(self, content):
        self.words += content

    def add_button(self, label, **_):
        def on_click(action):
            self.press = lambda: action(SimpleNamespace(client=self.client))

        self.button = SimpleNamespace(label=label, disabled=False, on_click=on_click)
        return self.button

    def on_client_disconnect(self, action):
        self.leave = lambda: (self.clients.clear(), action(self.client))

    def get_clients(self):
        return self.clients


@pytest.fixture(scope="module")
def demo():
    return Demo()


@pytest.fixture
def server():
    return FakeServer()


@pytest.fixture
def button(server, demo):
    player = Player(demo, SCREEN)
    player.check()
    button = RecordButton(server, player, lambda: True)
    yield button
    button.close()


def test_what_is_recorded_and_where_it_goes_is_said_before(server, button):
    assert button.button.label == "Record"
    assert all(words in server.words for words in ("the scene as you see it", f"{LONGEST_S:g} s", "ulna-demo.mp4", "downloads"))


@pytest.mark.slow
def test_two_clicks_make_a_video_of_the_time_between(server, button):
    button.take(0.0)
    server.press()
    assert server.button.label == "Stop recording"
    for k in range(4):
        button.take(5.0 + k / 30)
    server.press()
    wait_for(lambda: server.button.label == "Record", "the video")
    assert not server.button.disabled
    assert server.files["ulna-demo.mp4"][4:8] == b"ftyp"


def test_the_button_shows_the_progress_while_the_video_is_made(server, button, monkeypatch):
    said = []

    def record(form, _robot, pictures, tell):
        assert len(pictures) == 91
        for done in (30, 60):
            tell(done)
            said.append(server.button.label)
        form.path.touch()

    monkeypatch.setattr(record_button, "record_pictures", record)
    server.press()
    button.take(0.0)
    button.take(3.0)
    server.press()
    wait_for(lambda: server.button.label == "Record", "the end")
    assert said == ["Making the video: 1 s of 3 s", "Making the video: 2 s of 3 s"]


def test_a_failed_video_is_reported_in_its_tab(server, button, monkeypatch, capsys):
    def fail(*_):
        raise ulna.FileError("ulna-demo.mp4", "cannot be written: no space")

    monkeypatch.setattr(record_button, "record_pictures", fail)
    notifications = []
    server.client.add_notification = lambda *words, **_: notifications.append(words)
    server.press()
    button.take(0.0)
    server.press()
    wait_for(lambda: notifications and server.button.label == "Record", "the words, and the button")
    assert notifications == [("The video was not made", "ulna-demo.mp4: cannot be written: no space")]
    assert "no space" in capsys.readouterr().err


def test_two_clicks_without_a_frame_between_make_no_video(server, button):
    server.press()
    server.press()
    assert (server.button.label, server.files) == ("Record", {})


def test_a_recording_ends_when_its_tab_is_closed(server, button):
    server.press()
    button.take(0.0)
    server.leave()
    assert server.button.label == "Record"
    button.take(0.1)
    assert button._shots == []


@pytest.mark.slow
def test_a_recording_ends_at_the_longest_duration(server, button):
    server.press()
    button.take(0.0)
    button.take(LONGEST_S - 1)
    assert server.button.label == "Stop recording"
    button.take(LONGEST_S + 1)
    assert server.button.label.startswith("Making the video")


@pytest.mark.slow
def test_closing_the_page_cancels_the_video(server, button):
    server.press()
    button.take(0.0)
    button.take(60.0)
    server.press()
    button.close()
    wait_for(lambda: not any(thread.name == "ulna-record" for thread in threading.enumerate()), "the end of its making")
    assert server.files == {}


def test_pictures_are_evenly_spaced_for_uneven_times_of_frames():
    shots = [(10.0, "a"), (10.02, "b"), (10.13, "c"), (10.5, "d")]
    assert evenly_spaced(shots, 10) == list("abcccd")
    assert evenly_spaced(shots[:1], 30) == ["a"]
