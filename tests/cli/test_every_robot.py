"""The data of the robot commands for every robot of the installed packages, in one process."""

import json

import numpy as np
import pytest

import ulna
from robot_files import example_urdfs, rtb_package_dirs, rtb_xacros
from ulna.cli.check import check_data
from ulna.cli.dh import dh_data
from ulna.cli.fk import fk_data
from ulna.cli.ik import ik_data
from ulna.cli.info import info_data
from ulna.cli.options import link_or_hand
from ulna.cli.output import json_ready

NOT_LOADED = {"alex_psyonic_hands", "ur3", "kr210l150"}  # tests/crosscheck has the reasons
URDFS = [file for file in example_urdfs() if file.stem not in NOT_LOADED]
XACROS = [file for file in rtb_xacros() if file.stem not in NOT_LOADED]


@pytest.mark.parametrize("file", URDFS, ids=lambda file: file.stem)
def test_every_command_on_every_robot_of_example_robot_data(file, capsys):
    check_commands(ulna.load(file), capsys)


@pytest.mark.parametrize("file", XACROS, ids=lambda file: file.stem)
def test_every_command_on_every_robot_of_rtb_data(file, tmp_path, capsys):
    check_commands(ulna.load(file, package_dirs=rtb_package_dirs(tmp_path)), capsys)


def check_commands(robot, capsys):
    link = link_or_hand(robot)
    said = capsys.readouterr().err
    assert (link in said) == (robot.tip is None)
    assert info_data(robot)["hand"] == link
    T = robot.forward_kinematics(robot.home, link=link)
    shown = [info_data(robot), fk_data(robot, robot.home, link, T)]
    if robot.n_dof:
        found = robot.inverse_kinematics(T, link=link)
        assert found.success
        np.testing.assert_allclose(robot.forward_kinematics(found.q, link=link), T, atol=3e-5)
        shown.append(ik_data(robot, link, T, "given", {"method": "levenberg_marquardt", "task": "pose"}, found))
    shown += [dh_or_reason(robot, link), check_or_reason(robot)]
    json.dumps(json_ready(shown), allow_nan=False)


def dh_or_reason(robot, link):
    try:
        table = robot.dh(link=link)
    except ulna.InputError as error:
        assert any(word in str(error) for word in ("planar", "floating")), error  # noqa: PT017 - which it may be is known here
        return {}
    assert table.max_position_difference < 1e-6
    return dh_data(table)


def check_or_reason(robot):
    try:
        report = robot.check_collision(robot.home)
    except ulna.GeometryError as error:
        assert "hulls" in str(error) or "no collision shapes" in str(error)  # noqa: PT017
        return {}
    distance = robot.signed_distance(robot.home)
    assert report.in_collision == (distance <= 0)
    return check_data(robot, robot.home, report, distance)
