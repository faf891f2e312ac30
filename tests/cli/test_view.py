"""``ulna view`` as a program, and scene files at the command line."""

import importlib
import json
import socket
import sys

import numpy as np
import pytest

import ulna
from processes import free_port, running, wait_for
from ulna.cli.cell import warn_of_missing


@pytest.mark.process
@pytest.mark.parametrize(("name", "options"), [("view", ()), ("servo", ("--jerk", "1000"))])
def test_it_serves_the_page_until_ctrl_c(tmp_path, name, options):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.6, 0, 0.3)))
    ulna.save_world(world, tmp_path / "scene.json")
    port = free_port()
    command = [
        sys.executable,
        "-m",
        "ulna",
        name,
        "panda",
        "--scene",
        str(tmp_path / "scene.json"),
        "--port",
        str(port),
        "--no-open",
        *options,
    ]
    with (tmp_path / "said").open("w+") as said, running(*command, stdout=said, stderr=said) as program:
        wait_for(lambda: f"panda is at http://127.0.0.1:{port}" in (tmp_path / "said").read_text(), "the address")
        assert program.poll() is None
    assert program.returncode == 0


@pytest.mark.parametrize("jerk", ["-1", "0", "nan"])
def test_a_jerk_that_cannot_be_taken_is_named(refusal, jerk):
    assert "--jerk" in refusal("servo", "panda", "--no-open", "--port", free_port(), "--jerk", jerk)


@pytest.mark.process
def test_meshes_are_checked_as_their_hulls_and_a_line_says_so(wedge, tmp_path):
    command = [sys.executable, "-m", "ulna", "view", str(wedge), "--port", str(free_port()), "--no-open"]
    for options, lines in (((), 1), (("--meshes", "hulls"), 1), (("--meshes", "none"), 0)):
        with (tmp_path / "output").open("w+") as output, running(*command, *options, stdout=output, stderr=output):
            wait_for(lambda: " is at http://" in (tmp_path / "output").read_text(), "the address")
        lines_written = (tmp_path / "output").read_text().splitlines()
        assert lines_written.count("collision by convex hulls of 1 mesh") == lines, options


def test_check_accepts_a_scene_file(run, tmp_path):
    world = ulna.World()
    world.add("crate", ulna.Sphere(0.1), ulna.pose((0.3, 0, 0.5)))
    ulna.save_world(world, tmp_path / "scene.json")
    result = run("check", "--scene", str(tmp_path / "scene.json"), "--json")
    assert result.exit_code == 1
    assert "crate" in {pair["name_b"] for pair in json.loads(result.stdout)["pairs"]}


def test_a_bad_scene_file_is_refused_in_one_line(run, tmp_path):
    (tmp_path / "scene.json").write_text('{"ulna_scene": 1, "objects": [{"name": "a", "shape": "bix"}]}')
    for command in ("check", "view"):
        result = run(command, "--scene", str(tmp_path / "scene.json"))
        assert result.exit_code == 2
        assert result.stderr == "ulna: scene.json: object 1 'a': 'bix' is not a known shape; did you mean 'box'?\n"


def test_bad_options_are_refused_by_name(refusal):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert refusal("view", "--no-open", "--port", port).startswith(f"--port: {port} is in use on 127.0.0.1")
    assert refusal("view", "--no-open", "--port", "0", "--q", "2e8,0,0,0,0,0,0", "--degrees").startswith("--q[0]: ")


def test_a_port_above_65535_is_refused(run):
    assert run("view", "--port", "99999").exit_code == 2


@pytest.mark.process
def test_meshes_that_are_not_shown_are_one_sentence(tmp_path, capsys):
    visual = '<visual><geometry><mesh filename="{}.stl"/></geometry></visual>'
    links = "".join(f'<link name="{name}">{visual.format(name)}</link>' for name in ("base", "hand"))
    joint = '<joint name="j" type="fixed"><parent link="base"/><child link="hand"/></joint>'
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joint}</robot>')
    command = [sys.executable, "-m", "ulna", "view", str(tmp_path / "arm.urdf"), "--port", str(free_port()), "--no-open"]
    with (tmp_path / "output").open("w+") as output, running(*command, stdout=output, stderr=output):
        wait_for(lambda: "ulna: " in (tmp_path / "output").read_text(), "the sentence")
    said = [line for line in (tmp_path / "output").read_text().splitlines() if line.startswith("ulna: ")]
    reason = "base.stl: no such file; `ulna inspect` lists where they were looked for"
    assert said == [f"ulna: collision shapes are drawn in place of 2 missing meshes: {reason}"]
    warn_of_missing(["package://example-robot-data/link0.dae: no such file; tried /a/link0.dae; /b/link0.dae"] * 9)
    advice = "pip install --no-deps --ignore-requires-python dm-robotics-panda==0.4.8 installs them"
    assert capsys.readouterr().err == f"ulna: collision shapes are drawn in place of 9 missing meshes: {advice}\n"


@pytest.mark.slow
@pytest.mark.parametrize("command", ["view", "servo"])
def test_a_stretched_arm_begins_bent_and_free_by_the_command_too(run, monkeypatch, command):
    """The commands, not the class: without --q the page chooses, with it the person."""
    begun = []

    def served(shown):
        with shown:
            wait_for(lambda: np.any(shown.q) or "given" in begun, "a bent arm")
            begun.append((shown.session.robot, shown.q, shown.world))

    monkeypatch.setattr(importlib.import_module(f"ulna.cli.{command}"), "serve", served)
    box = ("--box", "0.5,0.1,0.2,0,0,0,0.1,0.3,0.4")
    result = run(command, "ur5", *box, "--no-open", "--port", free_port())
    assert result.exit_code == 0, result.output
    robot, q, world = begun.pop()
    assert np.linalg.svd(robot.jacobian(q, link="tool0"), compute_uv=False).min() > 0.05
    assert not robot.in_collision(q, world)
    begun.append("given")
    assert run(command, "ur5", *box, "--no-open", "--port", free_port(), "--q", "home").exit_code == 0
    assert np.array_equal(begun.pop()[1], np.zeros(6))


@pytest.mark.parametrize("command", ["view", "servo"])
def test_gravity_on_the_page_is_that_of_the_mounting(run, monkeypatch, command):
    shown = []
    monkeypatch.setattr(importlib.import_module(f"ulna.cli.{command}"), "serve", lambda view: shown.append(view) or view.stop())
    for options, gravity in (((), (0, 0, -9.81)), (("--mount", "ceiling"), (0, 0, 9.81)), (("--gravity", "1 2 3"), (1, 2, 3))):
        assert run(command, "panda", *options, "--no-open", "--port", free_port(), "--q", "home").exit_code == 0
        assert np.array_equal(shown.pop().session.robot.gravity, gravity)
