"""Runs the command ``ulna`` inside this process, and makes arms for it."""

import json
import re
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from ulna.cli.app import app

# Every kind of joint, two tips, a name that is markup to rich, one that is not ASCII, and shapes that are not boxes.
ODD = """<robot name="odd [bold]robot">
  <link name="world"/>
  <link name="cart"><collision><geometry><cylinder radius="0.2" length="0.3"/></geometry></collision></link>
  <link name="mast"><collision name="m"><geometry><mesh filename="mast.stl" scale="1 1 2"/></geometry></collision></link>
  <link name="finger"/><link name="thumb"/><link name="bäll"/>
  <joint name="base" type="planar"><parent link="world"/><child link="cart"/><axis xyz="0 0 1"/></joint>
  <joint name="lift" type="prismatic"><parent link="cart"/><child link="mast"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1.2" velocity="0.1" effort="1"/></joint>
  <joint name="grip" type="prismatic"><parent link="mast"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="0.1" effort="1"/></joint>
  <joint name="grip_too" type="prismatic"><parent link="mast"/><child link="thumb"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" velocity="0.1" effort="1"/><mimic joint="grip" multiplier="2" offset="0.01"/></joint>
  <joint name="turn" type="continuous"><parent link="mast"/><child link="bäll"/><axis xyz="0 0 1"/></joint>
</robot>"""

# A cube of one meter that slides along x: every depth can be worked out in the head.
SLIDER = """<robot name="slider">
  <link name="rail"/>
  <link name="cube"><collision name="cube"><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cube"/><axis xyz="1 0 0"/>
    <limit lower="-10" upper="10" velocity="1" effort="1"/></joint>
</robot>"""

# As the course's file: one macro, and no call of it.
XACRO = """<robot name="one" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="arm" params="length arm_id:=one">
    <link name="${arm_id}_base"/><link name="${arm_id}_hand"/>
    <joint name="${arm_id}_joint" type="revolute"><parent link="${arm_id}_base"/><child link="${arm_id}_hand"/>
      <origin xyz="${length} 0 0"/><axis xyz="0 0 1"/><limit lower="-${pi}" upper="${pi}" velocity="1" effort="1"/></joint>
  </xacro:macro>
</robot>"""


def without_announcements(text):
    """Standard error without the line that a machine with a cold cache has there."""
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith("ulna: compiling "))


@pytest.fixture
def run():
    """Runs ``ulna`` with arguments; the result has exit_code, stdout and stderr. A traceback fails the test."""

    def run(*arguments, **environment):
        environment = {"COLUMNS": "80", "FORCE_COLOR": None, "NO_COLOR": None, **environment}
        return CliRunner(env=environment).invoke(app, [str(a) for a in arguments], prog_name="ulna", catch_exceptions=False)

    return run


@pytest.fixture
def ask(run):
    """Runs ``ulna ... --json``: the exit status, and the one object that it wrote."""

    def ask(*arguments):
        result = run(*arguments, "--json")
        assert result.stderr == ""
        assert result.stdout.count("\n") == 1
        return SimpleNamespace(exit_code=result.exit_code, **json.loads(result.stdout))

    return ask


@pytest.fixture
def refusal(run):
    """Runs ``ulna`` on a wrong question: the one line of the answer."""

    def refusal(*arguments):
        result = run(*arguments)
        assert result.exit_code == 2
        assert result.stdout == ""
        if "--json" in arguments:
            return json.loads(result.stderr)["message"]
        assert re.fullmatch(r"ulna: .*\n", result.stderr)
        return result.stderr.removeprefix("ulna: ").rstrip()

    return refusal


@pytest.fixture
def odd(tmp_path):
    path = tmp_path / "odd.urdf"
    path.write_text(ODD, encoding="utf-8")
    return path


@pytest.fixture
def slider(tmp_path):
    path = tmp_path / "slider.urdf"
    path.write_text(SLIDER, encoding="utf-8")
    return path


@pytest.fixture
def xacro(tmp_path):
    path = tmp_path / "one.xacro"
    path.write_text(XACRO, encoding="utf-8")
    return path


@pytest.fixture
def wedge(tmp_path):
    """An arm of one mesh."""
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
    arm = tmp_path / "arm.urdf"
    mesh = '<collision name="wedge"><geometry><mesh filename="wedge.obj"/></geometry></collision>'
    arm.write_text(f'<robot name="r"><link name="base">{mesh}</link></robot>')
    return arm
