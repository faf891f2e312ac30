"""Starts simulators of a Franka's controller in separate processes on loopback, and ends the ones that it started."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import ulna
from ulna.arms import Franka

ADDRESS, PORT = "127.0.0.1", 1337
LONGEST = 120  # [s], for a simulator to begin
FRANKY = os.environ.get("FRANKY_PYTHON", ".venv-franky/bin/python")


def assets():
    """The folder of the FR3's model and meshes in the package franky-sim."""
    code = "import importlib.util as u; print(u.find_spec('franky_sim').submodule_search_locations[0])"
    found = subprocess.run([FRANKY, "-c", code], capture_output=True, text=True, check=True)
    return Path(found.stdout.strip()) / "assets"


def commands(folder):
    """How each simulator is started. franka-sim would download its model: it gets that of franky-sim, with the meshes' folder."""
    model = (assets() / "fr3.xml").read_text()
    (folder / "fr3.xml").write_text(re.sub(r'meshdir="[^"]*"', f'meshdir="{assets() / "meshes"}"', model, count=1))
    # Its physics keep to the clock, so a busy machine makes the simulated arm jerk, and its check of measured velocities would
    # judge that. Every check of commands stays.
    checks = (
        "from franka_sim.limits.checker import MotionLimitChecker as checker; "
        "checker.check_measured_velocity = lambda *a, **k: None; "
        "from franka_sim.run_server import main; main()"
    )
    script = "from franky_sim.run_server import main; main()"
    return {
        "franka-sim": [sys.executable, "-c", checks, "--no-gripper", "--enforce-motion-limits"],
        "franky-sim": [FRANKY, "-c", script, "--simulator", "mujoco", "--hostname", ADDRESS],
    }


@contextmanager
def simulator(name, folder):
    """A simulator that takes connections; the process."""
    with socket.socket() as probe:
        assert probe.connect_ex((ADDRESS, PORT)), f"another program listens on port {PORT} of {ADDRESS}, the one of a Franka"
    with suppress(PermissionError):  # a simulator's physics keep to the clock, and the commands should
        os.nice(-18)
    log = folder / f"{name}.log"
    with log.open("w") as file:
        process = subprocess.Popen(
            commands(folder)[name],
            stdout=file,
            stderr=file,
            start_new_session=True,
            env={**os.environ, "FR3_MJCF": str(folder / "fr3.xml")},
        )
    try:
        until = time.monotonic() + LONGEST
        while True:
            assert process.poll() is None, f"{name} has ended:\n{log.read_text()[-3000:]}"
            try:
                Franka(ADDRESS).close()
                break
            except ulna.ArmConnectionError:
                assert time.monotonic() < until, f"{name} does not listen:\n{log.read_text()[-3000:]}"
                time.sleep(0.5)
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
