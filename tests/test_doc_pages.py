"""Runs every Python block and every shell command of the documentation, and compares the printed output."""

import doctest
import os
import re
import shlex
import shutil
import subprocess
import sys
from itertools import pairwise

import pytest
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner

import ulna
from doc_pages import PAGES, ROOT, blocks, commands
from ulna.cli.app import app

WITH_PYTHON = [page for page in PAGES if any(block.language == "python" for block in blocks(page))]
# These have tests of their own; here their words are only parsed.
LONG = ("demo", "view", "servo", "record", "bench", "warmup", "ros1", "ros2")
DELETED = {"demo", "ros1", "ros2"} - set(get_command(app).list_commands(None))  # where the demo is, none
COMMANDS = sorted({(page, command) for page in PAGES for command in commands(page) if command.split()[1] not in DELETED})
PARSED = sorted({command for _, command in COMMANDS if command.split()[1] in LONG})
RUN = [(page, command) for page, command in COMMANDS if command not in PARSED]
EXITS_WITH_1 = (
    "ulna check panda --box",
    "ulna check panda --motion",
    "ulna compare panda fr3",
    "ulna inspect my_panda",
)  # the box stands in the Panda, a coarse motion exceeds a limit, the arms differ, some links have no boxes

ARM = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default=""/>
  <link name="base_link"/><link name="$(arg prefix)forearm"/><link name="tool0"/>
  <joint name="$(arg prefix)elbow" type="revolute">
    <parent link="base_link"/><child link="$(arg prefix)forearm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="flange" type="fixed"><parent link="$(arg prefix)forearm"/><child link="tool0"/><origin xyz="0.4 0 0"/></joint>
</robot>"""
SRDF = """<robot name="arm"><group name="manipulator"><chain base_link="base_link" tip_link="tool0"/></group>
  <group_state name="home" group="manipulator"><joint name="elbow" value="0.5"/></group_state></robot>"""

MOTION = """time,panda_joint1,panda_joint2,panda_joint3,panda_joint4,panda_joint5,panda_joint6,panda_joint7
0,0,-0.785,0,-2.356,0,1.571,0.785
1,0.1,-0.785,0,-2.356,0,1.571,0.785
"""


@pytest.fixture
def a_users_folder(tmp_path, monkeypatch):
    """The files that the pages speak of: a robot, its semantic description, a scene, a motion, and those of the repository."""
    (tmp_path / "arm.urdf.xacro").write_text(ARM)
    (tmp_path / "arm.urdf").write_text(ARM.replace("$(arg prefix)", ""))
    (tmp_path / "arm.srdf").write_text(SRDF)
    ulna.save_world(ulna.World(), tmp_path / "scene.json")
    (tmp_path / "motion.csv").write_text(MOTION)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    shutil.copytree(ROOT / "examples" / "desk_arm", tmp_path / "desk_arm")
    monkeypatch.chdir(tmp_path)


def name_of(page):
    return str(page.relative_to(ROOT))


def about_the_compiler(page):
    return pytest.param(page, marks=pytest.mark.compiler) if page.name == "lanes.md" else page


@pytest.mark.parametrize("page", [about_the_compiler(page) for page in WITH_PYTHON], ids=name_of)
def test_the_python_of_a_page_runs_from_top_to_bottom_and_prints_what_it_says(page, a_users_folder, capsys):
    names = {"__name__": "__main__"}
    for block in blocks(page):
        if block.language == "python":
            exec(compile(block.text, name_of(page), "exec"), names)  # noqa: S102 - our own pages
            printed = capsys.readouterr().out
            assert same_words(block.printed or "", printed) or block.printed is None, f"{printed}\nis printed by\n{block.text}"


def same_words(want, got):
    """Whether two texts agree but for spaces and the signs of zeros; ``...`` stands for anything."""
    want, got = (re.sub(r"-(0\.0*)(?!\d)", r"\1", text).replace("[ ", "[").strip() for text in (want, got))
    options = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
    return doctest.OutputChecker().check_output(want, got, options)


def test_other_numbers_are_other_words():
    assert same_words("[ 0.1 -0. ]", "[0.1  0. ]")
    assert not same_words("0.10", "0.11")
    assert not same_words("-0.05", "0.05")


@pytest.mark.slow
@pytest.mark.parametrize(("page", "command"), RUN, ids=lambda value: value if isinstance(value, str) else name_of(value))
def test_a_command_of_a_page_does_its_work(page, command, a_users_folder):
    result = CliRunner().invoke(app, shlex.split(command)[1:], catch_exceptions=False)
    assert result.exit_code == (1 if command.startswith(EXITS_WITH_1) else 0), result.output
    assert result.stdout


def test_the_files_that_commands_of_the_readme_read_are_in_the_repository():
    """A reader pastes these lines. What follows one of these options is written."""
    read = [
        word
        for command in commands(ROOT / "README.md")
        for option, word in pairwise(shlex.split(command))
        if re.search(r"\.(urdf|xacro|srdf|csv|npy|json|dae|stl)$", word) and option != "--csv"
    ]
    assert len(read) >= 2
    assert [word for word in read if not (ROOT / word).is_file()] == []


def test_the_robots_that_commands_of_the_readme_name_come_with_ulna():
    words = [shlex.split(command) for command in commands(ROOT / "README.md")]
    named = {line[2] for line in words if len(line) > 2 and re.fullmatch(r"\w+", line[2])}
    assert named <= {"panda", "fr3"}


@pytest.mark.parametrize("command", PARSED)
def test_a_long_command_of_a_page_has_the_options_that_the_page_gives_it(command, a_users_folder):
    parse(shlex.split(command)[1:])


def test_an_option_that_is_not_there_is_refused_without_running_the_command():
    parse(["record", "out.mp4", "--seconds", "60"])
    with pytest.raises(Exception, match="No such option: --second"):
        parse(["record", "out.mp4", "--second", "60"])


def parse(words):
    """Take a command's words as its program does, without running it."""
    command = get_command(app)
    while isinstance(command, TyperGroup):
        name, *words = words
        command = command.get_command(None, name)
    command.make_context("ulna", words)


def test_pages_have_code_that_is_run():
    assert len(WITH_PYTHON) >= 10
    assert len(COMMANDS) >= 10


LANES = ROOT / "docs" / "lanes.md"


@pytest.mark.process
@pytest.mark.compiler
def test_the_page_about_lanes_runs_without_the_compiler_too(tmp_path):
    """All but the last block, which looks at machine code."""
    code = [block.text for block in blocks(LANES) if block.language == "python"]
    assert "inspect_llvm" in code[-1]
    assert "inspect_llvm" not in "".join(code[:-1])
    (tmp_path / "page.py").write_text("".join(code[:-1]))
    run_without_compiler(["page.py"], tmp_path)


@pytest.mark.process
@pytest.mark.compiler
def test_the_debugger_stops_in_a_kernel_as_the_page_about_lanes_says(tmp_path):
    (command,) = [block.text for block in blocks(LANES) if block.language == "console"]
    _, _, script, _ = [block.text for block in blocks(LANES) if block.language == "python"]
    (tmp_path / "reach.py").write_text(script)
    words = shlex.split(command.replace("$ NUMBA_DISABLE_JIT=1 python ", "").replace("\\\n", " "))
    further = [argument for say in ("next", "p pose[11]", "quit") for argument in ("-c", say)]
    said = run_without_compiler([*words[:-1], *further, words[-1]], tmp_path)
    assert "poses.py" in said
    assert "0.333" in said


def run_without_compiler(arguments, folder):
    """What Python prints, with kernels as plain functions."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
