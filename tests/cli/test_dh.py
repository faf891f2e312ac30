"""``ulna dh``."""

import re

import ulna
from assertions import assert_close
from ulna.description.names.panda import DH_ROWS

LADDER = """<robot name="ladder">
  <link name="floor"/><link name="rung"/><link name="top"/>
  <joint name="lift" type="prismatic"><parent link="floor"/><child link="rung"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
  <joint name="lift_too" type="prismatic"><parent link="rung"/><child link="top"/><origin xyz="0 0 0.3" rpy="0 0 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="3" velocity="1" effort="1"/><mimic joint="lift" multiplier="2" offset="0.1"/>
  </joint>
</robot>"""
KEYS = ("a", "d", "alpha", "theta_offset")


def test_the_table_of_the_panda_is_that_of_the_assignment(ask):
    answer = ask("dh")
    assert answer.exit_code == 0
    assert_close([[row[key] for key in KEYS] for row in answer.rows], DH_ROWS[:7])
    assert answer.proof["max_position_difference"] < 1e-14
    assert (answer.base, answer.tip, answer.convention) == ("panda_link0", "panda_ee", "modified")


def test_a_robot_built_from_the_json_has_the_same_forward_kinematics(ask, panda):
    answer = ask("dh", "--convention", "standard", "--link", "panda_link6")
    rebuilt = ulna.Robot.from_dh(
        [[row[key] for key in KEYS] for row in answer.rows],
        convention=answer.convention,
        T_base_0=answer.T_base_0,
        T_n_tip=answer.T_n_tip,
    )
    assert_close(rebuilt.forward_kinematics(panda.home[:6]), panda.forward_kinematics(panda.home, link="panda_link6"), atol=1e-14)


def test_the_table_shows_fractions_of_pi_and_the_comparison(run):
    shown = run("dh").stdout
    assert "a row is Rx(alpha) Tx(a) Tz(d) Rz(theta)" in shown
    assert re.search(r"5 +panda_joint5 +-0\.0825 +0\.384 +-pi/2 +q5", shown)
    assert "panda_ee in frame 7: xyz = (0, 0, 0.2104) m, rpy = (0, 0, 0) rad" in shown
    assert re.search(r"at 1000 random configurations: \S+e-1[5-7] m, \S+e-1[5-7] rad", shown)


def test_a_prismatic_joint_and_its_mimic_are_written_as_equations(run, tmp_path):
    path = tmp_path / "ladder.urdf"
    path.write_text(LADDER)
    shown = run("dh", path).stdout
    assert re.search(r"1 +lift +0 +q1 \+ 0\.5 ", shown)
    assert re.search(r"2 +lift_too +0 +q2 ", shown)
    assert "q2 = 2 * q1 + 0.1\n" in shown


def test_a_planar_joint_is_refused(refusal, odd):
    assert "has the planar joint 'base', which no row of a DH table can describe" in refusal("dh", odd, "--link", "thumb")


def test_an_unknown_convention_is_refused(refusal):
    assert refusal("dh", "--convention", "modifed") == "--convention: 'modifed' is not known; did you mean 'modified'?"


def test_the_tolerance_decides_what_is_parallel(ask, tmp_path):
    path = tmp_path / "ladder.urdf"
    path.write_text(LADDER.replace("continuous", "revolute").replace("prismatic", "revolute").replace('rpy="0 0', 'rpy="0 3e-6'))
    exact, rounded = ask("dh", path), ask("dh", path, "--tolerance", "1e-5")
    assert exact.proof["max_rotation_difference"] < 1e-9
    assert 1e-6 < rounded.proof["max_rotation_difference"] < 1e-5
    assert "treated as parallel (tolerance 1e-05)" in rounded.notes[0]
