"""``ulna fk``, ``ulna jacobian`` and ``ulna ik``."""

import re

import numpy as np
import pytest

import ulna

PI = np.pi
HOME = (0, -PI / 4, 0, -3 * PI / 4, 0, PI / 2, PI / 4)
# The assignment's table, typed in again: a, d, alpha of joints 1 to 7, flange and end-effector.
DH = [
    (0, 0.333, 0),
    (0, 0, -PI / 2),
    (0, 0.316, PI / 2),
    (0.0825, 0, PI / 2),
    (-0.0825, 0.384, -PI / 2),
    (0, 0, PI / 2),
    (0.088, 0, PI / 2),
    (0, 0.107, 0),
    (0, 0.1034, 0),
]

OTHER = (0.3, -0.5, 0.2, -1.8, 0.4, 1.9, -0.6)
OTHER_TEXT = "0.3, -0.5 0.2,-1.8, 0.4 1.9,-.6"


def dh_pose(q):
    """The Panda's end-effector by the textbook's product of the rows: Rx(alpha) Tx(a) Tz(d) Rz(theta)."""
    T = np.eye(4)
    for (a, d, alpha), theta in zip(DH, [*q, 0, 0], strict=True):
        (sa, ca), (st, ct) = ((np.sin(t), np.cos(t)) for t in (alpha, theta))
        T = T @ [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]]
    return T


def numbers_of(line):
    return [float(word) for word in re.findall(r"-?\d+\.\d+", line)]


# ---- fk ---------------------------------------------------------------------------------------------------------------


def test_fk_uses_the_home_configuration_by_default(ask):
    answer = ask("fk")
    assert answer.exit_code == 0
    assert answer.q == pytest.approx(HOME, abs=0)
    assert answer.position == pytest.approx([0.306891, 0, 0.486882], abs=5e-7)
    assert answer.rpy == pytest.approx([PI, 0, -PI / 4], abs=1e-12)
    assert answer.wxyz == pytest.approx([0, np.cos(PI / 8), -np.sin(PI / 8), 0], abs=1e-12)


def test_fk_agrees_with_the_textbook_product(ask):
    assert np.array(ask("fk", "--q", OTHER_TEXT).matrix) == pytest.approx(dh_pose(OTHER), abs=1e-12)


def test_the_table_of_fk_has_the_same_numbers(run):
    lines = run("fk").stdout.splitlines()
    assert lines[0] == "panda: panda_ee in panda_link0"
    shown = {line[1:22].strip(): numbers_of(line) for line in lines}
    assert shown["position x, y, z"] == [0.306891, 0, 0.486882]
    assert shown["roll, pitch, yaw"] == [3.141593, 0, -0.785398]
    assert shown["quaternion w, x, y, z"] == [0, 0.92388, -0.382683, 0]
    first = next(k for k, line in enumerate(lines) if "matrix" in line)
    shown_matrix = np.array([numbers_of(line) for line in lines[first : first + 4]])
    assert shown_matrix == pytest.approx(dh_pose(HOME), abs=5e-7)
    assert "-0.000000" not in "".join(lines)


def test_fk_of_another_link(ask):
    assert ask("fk", "--link", "panda_link1").position == [0, 0, 0.333]


def test_degrees_convert_angles_and_not_lengths(ask, odd):
    answer = ask("fk", odd, "--link", "mast", "--q", "1 2 90 0.5 0.01 0", "--degrees")
    assert answer.q == pytest.approx([1, 2, PI / 2, 0.5, 0.01, 0], abs=0)
    assert answer.position == pytest.approx([1, 2, 0.5], abs=1e-15)
    assert answer.rpy[2] == pytest.approx(PI / 2)


def test_fk_beyond_the_limits_warns(ask, run):
    assert ask("fk", "--q", "0 0 0 0 0 0 3").outside_limits == ["panda_joint4", "panda_joint7"]
    assert "q is beyond the limits of panda_joint4, panda_joint7" in run("fk", "--q", "0 0 0 0 0 0 3").stdout
    assert ask("fk").outside_limits == []


@pytest.mark.parametrize("command", [["fk"], ["dh"], ["jacobian"], ["ik", "--xyz", "0.4, 0.1, 0.4"]], ids=" ".join)
def test_with_several_leaf_links_the_hand_is_used_and_named(run, command):
    result = run(command[0], "ur5", *command[1:])
    assert result.exit_code == 0
    assert result.stderr == "ulna: ur5 has 2 tips; using tool0, --link selects another\n"
    assert "tool0" in result.stdout


def test_base_and_tip_select_a_part_of_the_robot(ask, refusal):
    part = ask("fk", "ur5", "--base", "base_link", "--tip", "forearm_link")
    assert (part.base, part.link, len(part.q)) == ("base_link", "forearm_link", 3)
    assert ask("dh", "ur5", "--tip", "forearm_link").tip == "forearm_link"
    assert ask("compare", "ur5", "ur5", "--tip", "forearm_link").same
    assert "did you mean 'forearm_link'" in refusal("fk", "ur5", "--tip", "forarm_link")


def test_an_srdf_beside_the_urdf_is_used_and_named_and_can_be_refused(run, ask, refusal, slider):
    path = slider.with_suffix(".srdf")
    path.write_text('<robot name="slider"><group name="g"><joint name="slide"/></group></robot>')
    answer = ask("info", slider)
    assert (answer.srdf, answer.groups) == (str(path), {"g": ["slide"]})
    assert "found next to the URDF" in " ".join(run("info", slider).stdout.split())
    answer = ask("info", slider, "--no-srdf")
    assert (answer.srdf, answer.groups) == ("", {})
    assert "give only one of them" in refusal("info", slider, "--srdf", path, "--no-srdf")


def test_an_srdf_adds_groups_and_unknown_names_are_warnings(run, ask, slider, tmp_path):
    path = tmp_path / "slider.srdf"
    path.write_text('<robot name="slider"><group name="g"><joint name="slide"/></group>'
                    '<group_state name="far" group="g"><joint name="slide" value="3"/></group_state></robot>')  # fmt: skip
    answer = ask("info", slider, "--srdf", path)
    assert (answer.groups, answer.named_configurations) == ({"g": ["slide"]}, {"g/far": [3.0]})
    assert ask("fk", slider, "--srdf", path, "--q", "g/far").position == [3, 0, 0]
    assert ask("ik", slider, "--srdf", path, "--from", "far", "--xyz", "2,0,0").q == pytest.approx([2.0])
    path.write_text('<robot name="slider"><group name="g"><joint name="slid"/></group></robot>')
    assert "joint 'slid' is not defined; did you mean 'slide'?" in run("check", slider, "--srdf", path).stderr


def test_home_is_a_configuration_wherever_one_is_expected(ask):
    assert ask("fk", "--q", "home").q == ask("fk").q
    assert ask("ik", "--xyz", "0.4,0,0.5", "--from", "home").success


def test_an_unknown_link_is_refused_with_a_suggestion(refusal):
    assert "did you mean 'panda_link8'" in refusal("fk", "--link", "panda_lnk8")


# ---- jacobian ---------------------------------------------------------------------------------------------------------


def test_the_jacobian_is_the_rate_of_the_pose(ask):
    answer = ask("jacobian", "--q", OTHER_TEXT)
    step, J = 1e-6, np.empty((3, 7))
    for j in range(7):
        ahead, behind = (dh_pose(np.array(OTHER) + sign * step * np.eye(7)[j]) for sign in (1, -1))
        J[:, j] = (ahead - behind)[:3, 3] / (2 * step)
    assert np.array(answer.jacobian)[:3] == pytest.approx(J, abs=1e-8)
    assert answer.rows == ["v_x", "v_y", "v_z", "w_x", "w_y", "w_z"]
    assert answer.columns == [f"panda_joint{k}" for k in range(1, 8)]
    assert (answer.kind, answer.expressed_in) == ("geometric", "base")


def test_the_jacobian_is_expressed_in_the_requested_frame(ask):
    base, link, spatial = (np.array(ask("jacobian", "--expressed-in", f).jacobian) for f in ("base", "link", "spatial"))
    p, R = dh_pose(HOME)[:3, 3], dh_pose(HOME)[:3, :3]
    assert link[:3] == pytest.approx(R.T @ base[:3], abs=1e-12)
    assert link[:, 6] == pytest.approx([0, 0, 0, 0, 0, 1], abs=1e-12)  # the last joint turns the link about its own z
    assert spatial[:3] == pytest.approx(base[:3] + np.cross(p, base[3:], axis=0), abs=1e-12)
    assert spatial[:, 0] == pytest.approx([0, 0, 0, 0, 0, 1], abs=1e-12)  # the first about the base's z


def test_the_analytical_jacobian_has_rates_of_roll_pitch_and_yaw(ask):
    answer = ask("jacobian", "--analytical")
    assert answer.rows == ["x", "y", "z", "roll", "pitch", "yaw"]
    assert (answer.kind, answer.expressed_in) == ("analytical", None)
    assert np.array(answer.jacobian)[3:, 6] == pytest.approx([0, 0, -1], abs=1e-12)  # hanging down, the last joint turns yaw back


def test_the_jacobian_is_printed_with_labels(run):
    lines = run("jacobian").stdout.splitlines()
    assert lines[0] == "panda: geometric Jacobian of panda_ee, expressed in base"
    assert [f"joint{k}" for k in range(1, 8)] == lines[4].split()
    rows = {line.split()[0]: numbers_of(line) for line in lines if re.match(r" [vw]_[xyz] ", line)}
    lever = (0.306891 + 0.153882) * np.sqrt(0.5)  # of the third joint's axis, which leans back by pi/4
    assert rows["v_y"] == pytest.approx([0.306891, 0, lever, 0, 0.2104, 0, 0], abs=6e-6)
    assert rows["w_z"] == pytest.approx([1, 0, np.sqrt(0.5), 0, 0, 0, -1], abs=5e-6)


@pytest.mark.filterwarnings("ignore::ulna.UnitWarning")  # a chain of 2000 m
def test_a_wide_jacobian_is_printed_in_blocks_without_truncation(run, tmp_path):
    links = "".join(f'<link name="link{k}"/>' for k in range(21))
    joints = "".join(
        f'<joint name="a_joint_{k}" type="continuous"><parent link="link{k}"/><child link="link{k + 1}"/>'
        f'<origin xyz="100 0 0"/><axis xyz="0 0 1"/></joint>'
        for k in range(20)
    )
    path = tmp_path / "snake.urdf"
    path.write_text(f'<robot name="snake">{links}{joints}</robot>')
    lines = run("jacobian", path).stdout.splitlines()
    assert max(map(len, lines)) > 80
    assert "…" not in "".join(lines)
    shown = [value for line in lines if " v_y " in line for value in numbers_of(line)]
    assert shown == [100.0 * (19 - k) for k in range(20)]


def test_expressed_in_with_analytical_is_refused(refusal):
    assert refusal("jacobian", "--analytical", "--expressed-in", "base").startswith("--expressed-in: applies to")


def test_an_unknown_frame_is_refused_with_a_suggestion(refusal):
    assert "did you mean 'spatial'" in refusal("jacobian", "--expressed-in", "spacial")


def test_the_analytical_jacobian_at_gimbal_lock_is_an_error(refusal):
    assert "cos(pitch)" in refusal("jacobian", "--analytical", "--q", "0,0,0,-pi/2,0,pi/2,0", "--link", "panda_link5")


# ---- ik ---------------------------------------------------------------------------------------------------------------


def test_the_solution_of_ik_reaches_the_target_and_is_within_limits(ask):
    answer = ask("ik", "--xyz", "0.4, 0.1, 0.5", "--rpy", "pi, 0, 0.3")
    assert (answer.exit_code, answer.success, answer.status) == (0, True, "solved")
    T = dh_pose(answer.q)
    assert T[:3, 3] == pytest.approx([0.4, 0.1, 0.5], abs=1.01e-5)
    assert T[:3, :3] == pytest.approx(
        np.array([[np.cos(0.3), np.sin(0.3), 0], [np.sin(0.3), -np.cos(0.3), 0], [0, 0, -1]]), abs=2e-5
    )
    assert (np.array(answer.lower) <= answer.q).all()
    assert (np.array(answer.q) <= answer.upper).all()
    assert max(answer.position_error, answer.rotation_error) <= 1e-5
    assert answer.target["orientation"] == "given"


def test_ik_accepts_a_quaternion(ask):
    by_rpy = ask("ik", "--xyz", "0.4,0,0.5", "--rpy", "pi,0,pi/2")
    by_wxyz = ask("ik", "--xyz", "0.4,0,0.5", "--wxyz", "0,1,1,0")
    assert np.array(by_wxyz.target["matrix"]) == pytest.approx(np.array(by_rpy.target["matrix"]), abs=1e-15)
    assert by_wxyz.success


def test_without_an_orientation_ik_uses_that_of_home_and_says_so(ask, run):
    answer = ask("ik", "--xyz", "0.4,0,0.5")
    assert answer.target["orientation"] == "home"
    assert dh_pose(answer.q)[:3, :3] == pytest.approx(dh_pose(HOME)[:3, :3], abs=2e-5)
    assert "not given: as at home" in run("ik", "--xyz", "0.4,0,0.5").stdout
    assert "none given" not in run("ik", "--xyz", "0.4,0,0.5", "--rpy", "pi,0,0").stdout


def test_ik_accepts_degrees(ask):
    in_degrees = ask("ik", "--xyz", "0.4,0,0.5", "--rpy", "180,0,45", "--from", "0,-45,0,-135,0,90,45", "--degrees")
    in_radians = ask("ik", "--xyz", "0.4,0,0.5", "--rpy", "pi,0,pi/4", "--from", "0,-pi/4,0,-3pi/4,0,pi/2,pi/4")
    assert in_degrees.q == pytest.approx(in_radians.q, abs=1e-9)


def test_an_unreachable_target_prints_the_remaining_error_and_exits_1(ask, run):
    answer = ask("ik", "--xyz", "0,0,3")
    assert (answer.exit_code, answer.success, answer.status) == (1, False, "unreachable")
    assert answer.position_error == pytest.approx(np.linalg.norm(dh_pose(answer.q)[:3, 3] - [0, 0, 3]), abs=1e-9)
    result = run("ik", "--xyz", "0,0,3")
    assert result.exit_code == 1
    assert re.search(r"^unreachable: [\d.]+ m and [\d.]+ rad from the target after \d+ steps", result.stdout, flags=re.MULTILINE)


def test_ik_from_a_seed(ask):
    target = dh_pose(HOME)[:3, 3] + (0, 0.01, 0)
    seed = "0,-pi/4,0,-3pi/4,0,pi/2,pi/4"
    answer = ask("ik", "--xyz", " ".join(map(str, target)), "--from", seed)
    assert answer.success
    assert answer.q == pytest.approx(HOME, abs=0.1)


def test_ik_shows_each_joint_between_its_limits(run):
    result = run("ik", "--xyz", "0.4,0,0.5")
    assert result.exit_code == 0
    line = next(line for line in result.stdout.splitlines() if "panda_joint6" in line)
    q, in_degrees, lower, upper = numbers_of(line)
    assert (lower, upper) == (-0.0175, 3.7525)
    assert in_degrees == pytest.approx(np.degrees(q), abs=0.0051)
    track = line.split()[-1]
    assert track.index("●") == round((q - lower) / (upper - lower) * (len(track) - 1))
    assert re.search(r"^solved: \S", result.stdout, flags=re.MULTILINE)
    free = run("ik", "--xyz", "0.4,0,0.5", "--task", "position")
    assert re.search(r"^solved: within what the task allows, ", free.stdout, flags=re.MULTILINE)


def test_a_target_beyond_a_million_meters_is_refused(run):
    refused = run("ik", "--xyz", "0,0,1e300")
    assert refused.exit_code == 2
    assert "beyond 1e+06 m" in refused.stderr


def test_the_same_seed_gives_the_same_solution(ask):
    first, again = (ask("ik", "--xyz", "0.3,0.3,0.3", "--seed", "5").q for _ in range(2))
    assert first == again


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        (["--xyz", "1,2"], "--xyz: 2 numbers, but 3 are expected: x, y, z"),
        (["--xyz", "1,2,3", "--rpy", "1"], "--rpy: 1 number, but 3 are expected: roll, pitch, yaw"),
        (["--xyz", "1,2,3", "--wxyz", "1,0,0"], "--wxyz: 3 numbers, but 4 are expected: w, x, y, z"),
        (["--xyz", "1,2,3", "--seed", "-1"], "--seed: -1; a whole number from 0"),
        (["--xyz", "1,2,3", "--wxyz", "1,0,0,0", "--rpy", "0,0,0"], "--rpy, --wxyz: give one of them"),
        (["--xyz", "1,2,3", "--wxyz", "0,0,0,0"], "--wxyz: a quaternion of length zero"),
        (["--xyz", "1,2,3", "--from", "1"], "--from: 1 number, but 7 are expected: panda_joint1"),
    ],
)
def test_bad_arguments_of_ik_are_refused(refusal, arguments, start):
    assert refusal("ik", *arguments).startswith(start)


def test_ik_with_a_seed_that_is_no_number_is_a_usage_error(run):
    result = run("ik", "--xyz", "1,2,3", "--seed", "one")
    assert result.exit_code == 2
    assert "Usage: ulna ik" in result.stderr


def test_the_pose_of_a_controller_goes_in_and_out(ask, panda):
    shown = ask("fk", "panda", "--controller", "KUKA").controller
    assert (shown["labels"], shown["units"]) == (["X", "Y", "Z", "A", "B", "C"], "mm, deg")
    np.testing.assert_allclose(shown["numbers"], ulna.pose_as(panda.forward_kinematics(panda.home), "KUKA"))
    numbers = ",".join(map(str, shown["numbers"]))
    found = ask("ik", "panda", "--pose", numbers, "--controller", "kuka")
    np.testing.assert_allclose(found.target["matrix"], panda.forward_kinematics(panda.home), rtol=0, atol=1e-12)
    assert found.success


def test_a_rotation_vector_and_a_frame_are_options(ask, panda):
    found = ask("ik", "panda", "--xyz", "0,0,0.5", "--rotvec", "pi,0,0", "--frame", "0.4,0.1,0,0,0,0")
    np.testing.assert_allclose(panda.forward_kinematics(found.q), ulna.pose((0.4, 0.1, 0.5), (np.pi, 0, 0)), rtol=0, atol=1e-4)
    here = ask("fk", "panda", "--frame", "panda_link4")
    expected = panda.forward_kinematics(panda.home, frame="panda_link4")
    np.testing.assert_allclose(here.matrix, expected, rtol=0, atol=1e-12)
    turned = ask("fk", "panda", "--degrees", "--frame", "0.4,0.1,0,0,0,90")
    expected = panda.forward_kinematics(panda.home, frame=ulna.pose((0.4, 0.1, 0), (0, 0, np.pi / 2)))
    np.testing.assert_allclose(turned.matrix, expected, rtol=0, atol=1e-12)


def test_options_of_a_pose_that_contradict_are_refused(refusal):
    assert "--xyz, --pose: one of them is expected" in refusal("ik", "panda")
    assert "--controller: requires --pose" in refusal("ik", "panda", "--xyz", "0,0,0", "--controller", "KUKA")
    assert "is not known" in refusal("ik", "panda", "--pose", "0,0,0,0,0,0", "--controller", "Kukka")
    assert "7 are expected: x, y, z, q1" in refusal("ik", "panda", "--pose", "0,0,0,0,0,0", "--controller", "ABB")
    assert "moves in the base" in refusal("ik", "panda", "--xyz", "0,0,0", "--frame", "panda_link4")


def test_a_base_that_is_not_above_the_link_is_refused_by_both_names(refusal):
    words = refusal("fk", "panda", "--base", "panda_link4", "--link", "panda_link1", "--q", "0,0,0,0,0,0")
    assert "--base, --link: 'panda_link1' is not below 'panda_link4'" in words
