"""``ulna info`` and ``ulna urdf``."""

import re

import pytest

# The assignment's table: lower, upper, velocity.
LIMITS = [
    (-2.8973, 2.8973, 2.1750),
    (-1.7628, 1.7628, 2.1750),
    (-2.8973, 2.8973, 2.1750),
    (-3.0718, -0.0698, 2.1750),
    (-2.8973, 2.8973, 2.6100),
    (-0.0175, 3.7525, 2.6100),
    (-2.8973, 2.8973, 2.6100),
]


def test_info_of_the_panda_has_the_limits_of_the_assignment(ask):
    answer = ask("info")
    assert answer.exit_code == 0
    assert (answer.name, answer.base, answer.tip, answer.n_dof) == ("panda", "panda_link0", "panda_ee", 7)
    assert [joint["name"] for joint in answer.joints] == [f"panda_joint{k}" for k in range(1, 8)]
    assert [(joint["lower"], joint["upper"], joint["velocity_limit"]) for joint in answer.joints] == LIMITS
    assert {(joint["type"], joint["unit"]) for joint in answer.joints} == {("revolute", "rad")}
    assert answer.fixed_joints == ["panda_joint8", "panda_ee_joint"]


def test_info_of_the_panda_has_the_boxes_of_the_assignment(ask):
    shapes = ask("info").collision_shapes
    assert [shape["name"] for shape in shapes] == [f"box {k}" for k in range(1, 13)]
    assert shapes[0] == {"name": "box 1", "link": "panda_link1", "kind": "box", "extents": [0.23, 0.2, 0.1]}
    assert shapes[11]["extents"] == [0.08, 0.22, 0.17]


def test_a_program_that_reads_info_finds_whole_names_in_one_line(run):
    (line,) = (line for line in run("info", COLUMNS=None).stdout.splitlines() if line.startswith("links (10)"))
    assert line.endswith("panda_link8, panda_ee")


def test_info_prints_one_line_for_each_joint(run):
    shown = run("info").stdout
    assert "panda: 7 dof, panda_link0 to panda_ee" in shown
    for k, limits in enumerate(LIMITS, start=1):
        line = next(line for line in shown.splitlines() if f"panda_joint{k} " in line)
        assert [float(word) for word in re.findall(r"-?\d+\.\d{4}", line)][:2] == list(limits[:2])
    assert re.search(r"box 12 +panda_link7 +box +0\.08 x 0\.22 x 0\.17", shown)


def test_every_joint_type_has_its_entries_and_units(ask, odd):
    answer = ask("info", odd)
    assert [(joint["name"], joint["unit"]) for joint in answer.joints] == [
        ("base.x", "m"),
        ("base.y", "m"),
        ("base.theta", "rad"),
        ("lift", "m"),
        ("grip", "m"),
        ("turn", "rad"),
    ]
    assert answer.mimic_joints == [{"name": "grip_too", "joint": "grip", "multiplier": 2.0, "offset": 0.01}]


def test_a_missing_limit_is_null_in_json_and_none_in_the_table(ask, run, odd):
    turn = ask("info", odd).joints[-1]
    assert (turn["lower"], turn["upper"], turn["velocity_limit"]) == (None, None, None)
    assert re.search(r"turn +continuous +none +none", run("info", odd).stdout)


def test_soft_limits_are_shown_where_they_are_narrower(ask, run, tmp_path):
    path = tmp_path / "soft.urdf"
    soft = '<safety_controller k_velocity="1" soft_lower_limit="-0.5"/>'
    limit = '<limit lower="-1" upper="2" velocity="1" effort="1"/>'
    joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>{0}{1}</joint>'
    path.write_text(f'<robot name="r"><link name="a"/><link name="b"/>{joint.format(limit, soft)}</robot>')
    (joint,) = ask("info", path).joints
    assert (joint["lower"], joint["soft_lower"], joint["upper"], joint["soft_upper"]) == (-1, -0.5, 2, 2)
    assert "j: soft limits -0.5000 to 2.0000 rad" in run("info", path).stdout
    assert "soft" not in run("info").stdout


def test_several_leaf_links_are_listed(ask, run, odd):
    answer = ask("info", odd)
    assert answer.tip is None
    assert answer.leaves == ["finger", "thumb", "bäll"]
    assert "world to 3 tips" in run("info", odd).stdout


def test_cylinders_and_meshes_show_their_dimensions(ask, run, odd):
    cylinder, mesh = ask("info", odd).collision_shapes
    assert (cylinder["kind"], cylinder["radius"], cylinder["length"]) == ("cylinder", 0.2, 0.3)
    assert (mesh["kind"], mesh["uri"], mesh["scale"]) == ("mesh", "mast.stl", [1.0, 1.0, 2.0])
    assert "radius 0.2, length 0.3" in run("info", odd).stdout


def test_names_are_not_interpreted_as_markup(run, odd):
    assert run("info", odd).stdout.startswith("odd [bold]robot: 6 dof")


def test_info_says_that_a_robot_has_no_collision_shapes(run, xacro):
    assert "no collision shapes" in run("info", xacro, "--xacro-arg", "length:=0.5").stdout


def test_urdf_prints_the_file_unchanged(run, odd):
    result = run("urdf", odd)
    assert result.exit_code == 0
    assert result.stdout_bytes == odd.read_bytes()


def test_urdf_of_a_xacro_file_is_its_expansion(run, ask, xacro, tmp_path):
    result = run("urdf", xacro, "--xacro-arg", "length:=0.5", "--xacro-arg", "arm_id:=two")
    assert "xacro" not in re.sub(r"<!--.*?-->", "", result.stdout, flags=re.DOTALL)
    expanded = tmp_path / "expanded.urdf"
    expanded.write_bytes(result.stdout_bytes)
    answer = ask("fk", expanded)
    assert (answer.link, answer.position) == ("two_hand", [0.5, 0.0, 0.0])


def test_urdf_prints_the_text_that_line_numbers_of_errors_refer_to(run, refusal, tmp_path):
    path = tmp_path / "r.xacro"
    lines = ['<xacro:property name="n" value="a"/>', '<link name="${n}"/>', '<joint name="j" type="${n}"/>']
    path.write_text(f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{"".join(lines)}</robot>')
    error = refusal("info", path)
    line = int(re.match(r"r\.xacro \(expanded; `ulna urdf` prints it\):(\d+): joint 'j': type 'a' is not known", error)[1])
    assert run("urdf", path).stdout.splitlines()[line - 1].strip() == '<joint name="j" type="a"/>'


def test_urdf_writes_mesh_paths_as_file_uris_on_request(run, refusal, odd):
    (odd.parent / "mast.stl").write_text("")
    assert f'filename="{(odd.parent / "mast.stl").as_uri()}"' in run("urdf", odd, "--mesh-paths", "file").stdout
    (odd.parent / "mast.stl").unlink()
    assert refusal("urdf", odd, "--mesh-paths", "file") == f"mast.stl: no such file; tried {odd.parent / 'mast.stl'}"


def test_packages_are_found_in_package_dir(ask, tmp_path):
    package = tmp_path / "packages" / "parts"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>parts</name></package>")
    (package / "hand.xacro").write_text('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="hand"/></robot>')
    main = tmp_path / "main.xacro"
    main.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="$(find parts)/hand.xacro"/></robot>'
    )
    assert ask("info", main, "--package-dir", tmp_path / "packages").links == ["hand"]


def test_a_missing_xacro_argument_is_named(refusal, xacro):
    assert "give length" in refusal("info", xacro)


def test_a_xacro_argument_without_colon_equals_is_refused(refusal, xacro):
    assert refusal("info", xacro, "--xacro-arg", "length=1") == "--xacro-arg: 'length=1'; key:=value is expected"


@pytest.mark.parametrize("command", ["info", "fk", "jacobian", "urdf"])
def test_an_unknown_robot_is_refused_with_a_suggestion(refusal, command):
    assert "did you mean 'panda'" in refusal(command, "pandaa")


def test_a_missing_file_is_named(refusal):
    assert refusal("info", "nowhere/arm.urdf") == "nowhere/arm.urdf: no such file"


def test_a_broken_file_is_refused_with_its_line(refusal, tmp_path):
    path = tmp_path / "broken.urdf"
    path.write_text('<robot name="r">\n<link name="a"/>\n<joint name="j" type="hinge"/></robot>')
    assert refusal("info", path).startswith("broken.urdf:3: joint 'j': type 'hinge' is not known")
