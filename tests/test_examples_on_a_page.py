"""Runs examples with ``--view`` as a person does: in a process, with the page in Chromium, until Ctrl-C."""

import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import numpy as np
import pytest

import ulna
from browser import wait_to_see
from processes import running
from ulna.description.pose import inverse

EXAMPLES = Path(__file__).parents[1] / "examples"
LOOP = EXAMPLES / "07_control_loop.py"
SHOWN_TO = 5e-3  # m: what the thousandths of a radian that the page shows tell of the hand
WITH_A_PAGE = [path for path in sorted(EXAMPLES.glob("[0-9]*.py")) if "--view" in path.read_text(encoding="utf-8")]


@pytest.mark.slow
@pytest.mark.parametrize("path", WITH_A_PAGE, ids=lambda path: path.stem)
def test_an_example_with_view_serves_a_page_until_ctrl_c(path):
    with running(sys.executable, "-u", str(path), "--view", stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as program:
        address = next(found.group() for line in program.stdout if (found := re.search(r"http://[^\s:]+:\d+", line)))
        with urllib.request.urlopen(address) as answer:  # noqa: S310 - an address of this machine
            assert b"<title>" in answer.read()
        assert program.poll() is None
    assert program.returncode in (0, 130, -signal.SIGINT)


@pytest.mark.slow
def test_the_hand_follows_a_crate_that_is_moved_on_the_page_and_the_loop_says_how_late_it_was(panda, open_page):
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    with running(sys.executable, str(LOOP), "--view", env=environment, stdout=subprocess.PIPE) as program:
        page = open_page(re.match(r"(http://\S+):", program.stdout.readline()).group(1))
        page.get_by_role("tab", name="Obstacles").click()
        page.get_by_label("Obstacle", exact=True).click()
        page.get_by_role("option", name="crate").click()

        def distance():
            return re.search(r"([\d.]+) mm between panda_link7 \(box 12\) and crate", page.inner_text("body"))

        before = wait_to_see(page, distance, "the distance of hand and crate")[0]
        y = page.get_by_label("Position [m], y", exact=True)
        y.fill("0.3")
        y.press("Enter")
        page.get_by_role("tab", name="Move").click()
        hand = ulna.pose(xyz=(0.307, 0.3, 0.3)) @ inverse(ulna.pose(xyz=(0.307, 0.0, 0.3))) @ panda.forward_kinematics(panda.home)

        def off_by():
            shown = [float(page.get_by_role("textbox", name=f"joint{i}").input_value()) for i in range(1, 8)]
            return np.linalg.norm((panda.forward_kinematics(shown) - hand)[:3, 3])

        wait_to_see(page, lambda: off_by() < SHOWN_TO, "the hand above the crate again")
        wait_to_see(page, lambda: distance() and distance()[0] == before, "the distance that it had")
        program.send_signal(signal.SIGINT)
        told = program.stdout.read()
    place, off = re.search(r"the crate is at \[([^]]*)\] m, the hand ([\d.]+) mm", told).groups()
    assert np.allclose([float(v) for v in place.split()], [0.307, 0.3, 0.3], atol=1e-9)
    assert float(off) < 1e3 * SHOWN_TO  # it comes nearer at every tick: what the page shows is older
    assert "a median period of" in told
    assert "late" in told
