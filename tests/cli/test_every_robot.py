"""The data of the robot commands for every robot of the installed packages, in one process."""

import json

import numpy as np
import pytest

import ulna
from robot_files import CHOSEN_XACROS, example_urdfs, of_kinds, rtb_package_dirs, rtb_xacros
from ulna.cli.check import check
from ulna.cli.dh import dh
from ulna.cli.fk import fk
from ulna.cli.ik import ik
from ulna.cli.info import info
from ulna.cli.options import named_or_hand
from ulna.cli.output import json_ready
from ulna.cli.targets import Target

NOT_LOADED = {"alex_psyonic_hands", "ur3", "kr210l150"}  # tests/crosscheck has the reasons
URDFS = [file for file in example_urdfs() if file.stem not in NOT_LOADED]
XACROS = [file for file in rtb_xacros() if file.stem not in NOT_LOADED]


@pytest.mark.parametrize("file", of_kinds(URDFS), ids=lambda file: file.stem)
def test_every_command_on_every_robot_of_example_robot_data(file, capsys):
    check_commands(ulna.load(file), capsys)


@pytest.mark.parametrize("file", of_kinds(XACROS, CHOSEN_XACROS), ids=lambda file: file.stem)
def test_every_command_on_every_robot_of_rtb_data(file, tmp_path, capsys):
    check_commands(ulna.load(file, package_dirs=rtb_package_dirs(tmp_path)), capsys)


def data_of(command, *arguments, **options):
    """The data of a command for a robot that is loaded already."""
    return command.__wrapped__(*arguments, **options).data


def check_commands(robot, capsys):
    link = named_or_hand(robot, link=None, as_json=False)
    said = capsys.readouterr().err
    assert (link in said) == (robot.tip is None)
    shown = [data_of(info, robot), data_of(fk, robot, q=robot.home, link=link, frame=None)]
    assert shown[0]["hand"] == link
    T = robot.forward_kinematics(robot.home, link=link)
    if robot.n_dof:
        found = data_of(ik, robot, link, None, xyz=",".join(map(repr, T[:3, 3].tolist())), target=Target(None, T, None))
        assert found["success"]
        np.testing.assert_allclose(robot.forward_kinematics(found["q"], link=link), T, atol=3e-5)
        shown.append(found)
    shown += [dh_or_reason(robot, link), check_or_reason(robot)]
    json.dumps(json_ready(shown), allow_nan=False)


def dh_or_reason(robot, link):
    try:
        data = data_of(dh, robot, link)
    except ulna.InputError as error:
        assert any(word in str(error) for word in ("planar", "floating")), error  # noqa: PT017 - which it may be is known here
        return {}
    assert data["proof"]["max_position_difference"] < 1e-6
    return data


def check_or_reason(robot):
    try:
        data = data_of(check, robot, None, q=",".join(map(repr, robot.home.tolist())) or None)
    except ulna.GeometryError as error:
        assert "hulls" in str(error) or "no collision shapes" in str(error)  # noqa: PT017
        return {}
    assert data["in_collision"] == (data["signed_distance"] <= 0)
    return data
