"""``ulna inspect``."""

import os
import subprocess
import sys

import pytest

from inspection_cases import SOUND

BALL = "solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid b\n"
PICTURE = """
base
└ upper  shoulder: revolute
  ├ left  grip: prismatic
  └ right  fixed
"""


@pytest.fixture
def inspected(run, ask, tmp_path):
    """Runs the command on a text, with and without --json, and checks that both have the same exit status."""

    def inspected(text):
        path = tmp_path / "arm.urdf"
        path.write_text(text)
        shown, answer = run("inspect", path), ask("inspect", path)
        assert shown.exit_code == answer.exit_code
        return shown, answer

    return inspected


def test_a_sound_description_is_exit_status_0(inspected):
    shown, answer = inspected(SOUND)
    assert (answer.exit_code, answer.loads, answer.n_dof) == (0, True, 2)
    assert answer.counts == {"error": 0, "warning": 0, "note": 0}
    assert "2 dof, 4 links, 3 joints (1 revolute, 2 prismatic), reach 1.2 m" in shown.stdout
    assert shown.stdout.endswith("no errors, no warnings, no notes\n")


@pytest.mark.parametrize(
    ("written", "instead", "status"),
    [('<axis xyz="-1 0 0"/>', "", 0), ('lower="-1"', 'lower="-170"', 1), ('lower="-1"', 'lower="2"', 2), ("</robot>", "", 2)],
    ids=["a note", "a warning", "an error", "no XML"],
)
def test_the_worst_finding_is_the_exit_status(inspected, written, instead, status):
    shown, answer = inspected(SOUND.replace(written, instead))
    assert answer.exit_code == status
    assert answer.loads == (status < 2)
    assert ("cannot be loaded" in shown.stdout) == (status == 2)


def test_the_tree_is_printed(inspected):
    fixed = SOUND.replace('"grip too" type="prismatic"', '"grip too" type="fixed"')
    assert PICTURE in inspected(fixed)[0].stdout


@pytest.mark.process
def test_the_tree_is_printed_in_ascii_for_an_ascii_terminal(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(SOUND.replace('"grip too" type="prismatic"', '"grip too" type="fixed"'))
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "ulna", "inspect", str(path)]
    shown = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120, check=True).stdout
    assert PICTURE.translate(str.maketrans("├└", "+`")) in shown


def test_findings_of_one_kind_share_a_row_of_at_most_80_columns(inspected):
    shown, answer = inspected(SOUND.replace('velocity="2"', 'velocity="0"'))
    assert answer.counts["warning"] == 3
    assert shown.stdout.count("velocity limit is 0") == 1
    assert max(map(len, shown.stdout.splitlines())) <= 80


def test_paths_that_were_tried_are_not_truncated(inspected, tmp_path):
    shown, answer = inspected(SOUND.replace('<sphere radius="0.1"/>', '<mesh filename="package://parts/ball.stl"/>'))
    [finding] = answer.findings
    assert answer.exit_code == 1
    assert all(f"\n  {path}\n" in shown.stdout for path in finding["tried"])
    assert str(tmp_path / "parts" / "ball.stl") in finding["tried"]


def test_package_dir_and_xacro_arg_are_accepted(ask, run, xacro, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "ball.stl").write_text(BALL)
    path = tmp_path / "deep" / "er" / "arm.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(SOUND.replace('<sphere radius="0.1"/>', '<mesh filename="package://parts/ball.stl"/>'))
    assert ask("inspect", path, "--package-dir", tmp_path).exit_code == 0
    assert ask("inspect", xacro, "--xacro-arg", "length:=0.5").loads
    assert not ask("inspect", xacro).loads


def test_a_missing_file_is_a_one_line_error(refusal):
    assert refusal("inspect", "nowhere.urdf") == "nowhere.urdf: no such file"


def test_a_long_tree_is_shortened_but_complete_in_json(inspected):
    links = "".join(f'<link name="l{k}"/>' for k in range(100))
    joints = "".join(f'<joint name="j{k}" type="fixed"><parent link="l0"/><child link="l{k}"/></joint>' for k in range(1, 100))
    shown, answer = inspected(f'<robot name="comb">{links}{joints}</robot>')
    assert "... and 40 more\n" in shown.stdout
    assert "└" not in shown.stdout
    assert len(answer.tree) == 100
