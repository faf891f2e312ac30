"""Records the demo's page as a video, from one click of a button to the next.

The recording stores only the poses of the arm, the box and the camera. The video is rendered afterwards (``viewer.film``), so a
slow browser loses no frames, and the page stays fast.
"""

import threading
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.demo.film import Moment, demo_picture, record_pictures
from ulna.demo.player import Player
from ulna.demo.scenario import BOX_NAME
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.painter import Picture
from ulna.viewer.film.recording import Form
from ulna.viewer.html import small_text

RATE, HEIGHT, LONGEST_S = 30, 720, 120.0
STOP_WITHIN_S = 5.0
_RECORD, _STOP, _MAKING = "Record", "Stop recording", "Making the video"
_FILE = "ulna-demo.mp4"
_WHAT = f"Record films the scene as you see it, for {LONGEST_S:g} s at most. A link then saves {_FILE} to your downloads."


class RecordButton:
    """A button that starts and ends a recording of the view in one tab."""

    def __init__(self, server: viser.ViserServer, player: Player, boxes_shown: Callable[[], bool]) -> None:
        self.server, self.player, self._boxes_shown = server, player, boxes_shown
        server.gui.add_html(small_text(_WHAT))
        self.button = server.gui.add_button(_RECORD)
        self.button.on_click(lambda event: self._pressed(event.client))
        server.on_client_disconnect(self._left)
        self._client: viser.ClientHandle | None = None  # the tab that is recorded
        self._shots: list[tuple[float, Picture]] = []
        self._maker: threading.Thread | None = None
        self._closed = False

    def take(self, now: float) -> None:
        """While recording, store the poses shown at a time [s]. The page's loop calls it with the player's lock held."""
        client = self._client
        if client is None or self.player.report is None:
            return
        if self._shots and now - self._shots[0][0] > LONGEST_S:
            self._finish(client)
            return
        player, camera = self.player, client.camera
        moment = Moment(player.q, player.demo.world.pose(BOX_NAME), self.player.report)
        seen = Camera(_three(camera.position), _three(camera.look_at), float(camera.fov))
        self._shots.append((now, demo_picture(player.demo.robot, moment, seen, boxes=self._boxes_shown())))

    def close(self) -> None:
        """Cancel a video in the making."""
        self._client, self._closed = None, True
        if self._maker is not None:
            self._maker.join(timeout=STOP_WITHIN_S)

    def _pressed(self, client: viser.ClientHandle | None) -> None:
        with self.player.lock:
            if self._client is not None:
                self._finish(client or self._client)
            elif client is not None and self.button.label == _RECORD:
                self._shots, self._client = [], client
                self.button.label = _STOP

    def _left(self, client: viser.ClientHandle) -> None:
        """Drop the recording of a tab that was closed."""
        with self.player.lock:
            if self._client is not None and self._client.client_id == client.client_id:
                self._client, self._shots = None, []
                self.button.label = _RECORD

    def _finish(self, client: viser.ClientHandle) -> None:
        """Stop recording, and make the video in another thread."""
        self._client = None
        shots, self._shots = self._shots, []
        if not shots:
            self.button.label = _RECORD
            return
        self.button.label, self.button.disabled = _MAKING, True
        self._maker = threading.Thread(target=self._make, args=(shots, client), name="ulna-record", daemon=True)
        self._maker.start()

    def _make(self, shots: list[tuple[float, Picture]], client: viser.ClientHandle) -> None:
        try:
            with TemporaryDirectory() as folder:
                path = Path(folder) / _FILE
                pictures = evenly_spaced(shots, RATE)
                form = Form(path, len(pictures) / RATE, _size(client.camera.aspect), RATE)
                record_pictures(form, self.player.demo.robot, pictures, partial(self._tell, of=len(pictures)))
                if client.client_id in self.server.get_clients():
                    client.send_file_download(path.name, path.read_bytes())
        except _GivenUpError:
            pass
        except Exception as error:  # noqa: BLE001 - the tab shows any error
            traceback.print_exc()
            client.add_notification("The video was not made", str(error) or type(error).__name__, color="red")
        finally:
            self.button.label, self.button.disabled = _RECORD, False

    def _tell(self, done: int, of: int) -> None:
        if self._closed:
            raise _GivenUpError
        if done % RATE == 0:
            self.button.label = f"{_MAKING}: {done / RATE:g} s of {of / RATE:.0f} s"


class _GivenUpError(Exception):
    """The page was closed."""


def evenly_spaced(shots: list[tuple[float, Picture]], rate: float) -> list[Picture]:
    """The latest shot at evenly spaced times, ``rate`` per second, from the first shot to the last."""
    times = np.array([time for time, _ in shots]) - shots[0][0]
    at = np.arange(np.floor(times[-1] * rate) + 1) / rate
    return [shots[k][1] for k in np.searchsorted(times, at + 1e-9, side="right") - 1]


def _three(vector: NDArray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z


def _size(aspect: float) -> tuple[int, int]:
    """The size of a video [pixels] with about the aspect of the page."""
    return 2 * round(min(max(aspect, 0.5), 2.4) * HEIGHT / 2), HEIGHT
