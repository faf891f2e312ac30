"""Compares the console blocks of a page with the output of the commands."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ulna.cli.app import app

PAGE = (Path(__file__).parents[1] / "docs" / "descriptions.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```console\n\$ ulna (.*)\n([\s\S]*?)\n```", PAGE)
ROUNDING = r"\d(\.\d+)?e-1[4-9]|\b0(?= (m|rad)\b)"  # differs from one machine to another


@pytest.fixture
def files(tmp_path, monkeypatch, panda):
    changes = (('xyz="0 0 0.1034"', 'xyz="0 0 0.1038"'), ('upper="2.8973"', 'upper="2.7437"'))
    text = panda.to_urdf()
    for written, instead in changes:
        assert written in text
        text = text.replace(written, instead)
    (tmp_path / "my_panda.urdf").write_text(text)
    (tmp_path / "lamp.urdf").write_text(re.search(r"```xml\n([\s\S]*?)```", PAGE)[1])
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("command", "expected"), BLOCKS, ids=[command for command, _ in BLOCKS])
def test_a_block_is_what_the_command_prints(files, command, expected):
    shown = CliRunner(env={"COLUMNS": "80"}).invoke(app, shlex.split(command), catch_exceptions=False).stdout.rstrip()
    shown = re.sub(r"(?m)(^tried.*\n)(  /.*\n)+", r"\1  ...\n", shown)  # the paths are this machine's
    assert re.sub(ROUNDING, "tiny", shown) == re.sub(ROUNDING, "tiny", expected)


def test_there_are_blocks():
    assert {command.split()[0] for command, _ in BLOCKS} == {"dh", "compare", "inspect"}
