"""The demo's loop and widgets: plays the trajectory, answers the handles, and serves the page on this machine."""

import contextlib
import errno
import html
import io
import logging
import os
import socket
import sys
import threading
import time
import webbrowser
from functools import partial

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.collision.report import Report
from ulna.demo import BOX_START, Demo, light_color
from ulna.errors import InputError
from ulna.model.pose import pose
from ulna.show import Show
from ulna.viewer.record_button import RecordButton
from ulna.viewer.scene import DemoScene

FRAMES_PER_SECOND = 30.0
STOP_WITHIN_S = 2.0


def serve(demo: Demo, host: str = "127.0.0.1", port: int = 8080, *, open_browser: bool = True) -> None:
    """Show the demo until Ctrl-C.

    Args:
        demo: What to show.
        host: The address to listen on; ``"0.0.0.0"`` lets other machines in.
        port: The TCP port.
        open_browser: Open a page on this machine, if it has a browser.

    Raises:
        InputError: The address cannot be listened on.
    """
    app = DemoApp(demo, host, port)
    print(f"The Panda is at {app.url}  (Ctrl-C ends it)", flush=True)  # noqa: T201 - the address is the result
    try:
        if open_browser and _has_display():
            webbrowser.open(app.url)
        app.run_until_interrupted()
    finally:
        app.stop()


class DemoApp:
    """A running demo: the server, its scene, its widgets and the thread that moves the arm."""

    def __init__(self, demo: Demo, host: str = "127.0.0.1", port: int = 8080) -> None:
        _refuse_busy(host, port)
        logging.getLogger("websockets").setLevel(logging.ERROR)
        self.demo = demo
        with _quiet():
            self.server = viser.ViserServer(host=host, port=port, label="Ulna", verbose=False)
        self.server.request_share_url = lambda verbose=True: None  # noqa: ARG005 - a page must not open a tunnel to the world
        self.url = f"http://{'127.0.0.1' if host in ('0.0.0.0', '') else host}:{self.server.get_port()}"  # noqa: S104
        self.show = Show(demo, self)
        self._stopping = threading.Event()
        self.scene = DemoScene(self.server, demo)
        self._add_widgets()
        self.scene.handles.on_update(lambda _: self._box_moved())
        self.show.stand(self.show.q)
        self._thread = threading.Thread(target=self._play, name="ulna-demo", daemon=True)
        self._thread.start()

    def run_until_interrupted(self) -> None:
        """Wait for Ctrl-C."""
        try:
            while self._thread.is_alive():
                self._thread.join(timeout=0.5)
        except KeyboardInterrupt:
            pass

    def stop(self) -> None:
        """End the loop and the server."""
        self._stopping.set()
        self._thread.join(timeout=STOP_WITHIN_S)
        self.recording.close()
        with _quiet():
            self.server.stop()

    def set_configuration(self, q: NDArray[np.float64]) -> None:
        """Stand still at q."""
        with self.show.lock, self.server.atomic():
            self.playing.value = False
            self.show.stand(q)
            self._show_joints()

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Put the arm at q."""
        self.scene.draw_arm(q)

    def draw_report(self, report: Report) -> None:
        """Colour the light and the boxes, and say it in words."""
        self.scene.draw_report(report)
        words = _verdict_html(report)
        if self.verdict.content != words:
            self.verdict.content = words

    # ---- widgets ------------------------------------------------------------------------------------------------------

    def _add_widgets(self) -> None:
        gui = self.server.gui
        gui.configure_theme(control_layout="floating", control_width="medium", show_logo=False, show_share_button=False)
        self.verdict = gui.add_html("")
        self.playing = gui.add_checkbox("Play", initial_value=True, hint="The arm repeats its trajectory")
        self.playing.on_update(lambda _: self._show_joints())
        self.speed = gui.add_slider("Speed", min=0.0, max=3.0, step=0.1, initial_value=1.0, hint="1 is real time")
        self.show_boxes = gui.add_checkbox("Boxes", initial_value=True, hint="The twelve boxes that stand for the arm")
        self.show_boxes.on_update(lambda _: self.scene.show_boxes(self.show_boxes.value))
        gui.add_button("Put the box back", hint="Where it stood at first").on_click(lambda _: self._put_box_back())
        self.recording = RecordButton(self.server, self.show, lambda: self.show_boxes.value)
        robot = self.demo.robot
        low = np.where(np.isinf(robot.lower), -np.pi, robot.lower)  # a turn where there is no limit
        high = np.where(np.isinf(robot.upper), np.pi, robot.upper)
        with gui.add_folder("Joints [rad]"):
            self.sliders = [
                gui.add_slider(
                    name.removeprefix(f"{robot.name}_"),
                    min=float(low[j]),
                    max=float(high[j]),
                    step=0.001,
                    initial_value=float(self.show.q[j]),
                    hint=f"{name}: moving it stops the trajectory",
                )
                for j, name in enumerate(robot.joint_names)
            ]
        for j, slider in enumerate(self.sliders):
            slider.on_update(partial(self._slider_moved, j))

    def _slider_moved(self, j: int, event: viser.GuiEvent) -> None:
        if event.client is not None:  # a person's hand, not ``_show_joints``
            with self.show.lock:
                q = self.show.q.copy()
                q[j] = self.sliders[j].value
                self.set_configuration(q)

    def _put_box_back(self) -> None:
        self.scene.put_handles(pose(BOX_START))
        self._box_moved()

    # ---- what moves ---------------------------------------------------------------------------------------------------

    def _box_moved(self) -> None:
        self.show.drag(self.scene.handle_pose())

    def _play(self) -> None:
        last = time.perf_counter()
        while not self._stopping.wait(1.0 / FRAMES_PER_SECOND):
            now = time.perf_counter()
            with self.show.lock, self.server.atomic():
                if self.playing.value and self.speed.value > 0.0:
                    self.show.advance((now - last) * self.speed.value)
                self.recording.take(now)
            last = now

    def _show_joints(self) -> None:
        """Set the sliders to where the arm stands. Not while it moves: that would take a number out of the hands that type it."""
        with self.show.lock:
            if not self.playing.value:
                for slider, value in zip(self.sliders, self.show.q, strict=True):
                    slider.value = round(float(value), 3)


def _verdict_html(report: Report) -> str:
    """A disc of the light's colour and the word."""
    disc = f"display:inline-block;width:0.9em;height:0.9em;border-radius:50%;background:rgb{light_color(report)}"
    words = html.escape(str(report))
    return f'<div role="status" style="padding:0.4em 0.6em;font-weight:600"><span style="{disc}"></span> {words}</div>'


def _quiet() -> contextlib.AbstractContextManager:
    """Hold back what viser prints on its own: the address is told once, by ``serve``."""
    return contextlib.redirect_stdout(io.StringIO())


def _has_display() -> bool:
    """Whether a browser would get a window; without one a text browser would take the terminal."""
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _refuse_busy(host: str, port: int) -> None:
    """Raise in one sentence if the port cannot be had; viser would quietly take the next one."""
    try:
        family = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0][0]
        with socket.create_server((host, port), family=family):
            pass
    except OverflowError:
        raise InputError("port", f"{port} is not a port; 0 to 65535 are") from None
    except OSError as error:
        reason = (error.strerror or str(error)).split(" (while")[0]
        if error.errno == errno.EADDRINUSE:
            raise InputError("port", f"{port} is in use on {host} ({reason}); choose another with --port") from None
        raise InputError("host", f"cannot listen on {host}, port {port} ({reason})") from None
