"""xacro: the course's file, which only defines a macro; and documents that fail, never end, or read other files."""

from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna import DescriptionError, DescriptionWarning, InputError
from ulna.description.xacro import expansion as xacro

COURSE = Path(__file__).parent / "data" / "franka_robot.urdf"
MACRO = '<xacro:macro name="{0}" params="{1}"><link name="${{n}}"/></xacro:macro>'


def document(*lines: str) -> str:
    return "\n".join(['<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">', *lines, "</robot>"])


def written(tmp_path: Path, *lines: str, name: str = "r.urdf.xacro") -> Path:
    file = tmp_path / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(document(*lines))
    return file


def assert_same_as_bundled(robot, prefix: str) -> None:
    panda = ulna.load("panda")
    q = np.vstack([panda.home, np.random.default_rng(0).uniform(panda.lower, panda.upper, (200, 7))])
    for k in range(9):
        T = robot.forward_kinematics(q, link=f"{prefix}_link{k}")
        np.testing.assert_allclose(T, panda.forward_kinematics(q, link=f"panda_link{k}"), rtol=0, atol=1e-12)
    for name in ("lower", "upper", "velocity_limits"):
        np.testing.assert_array_equal(getattr(robot, name), getattr(panda, name))


def test_the_course_file_is_the_bundled_panda_without_its_end_effector():
    robot = ulna.load(COURSE)
    assert (robot.n_dof, robot.base, robot.tip) == (7, "panda_link0", "panda_link8")
    assert robot.joint_names == tuple(f"panda_joint{k}" for k in range(1, 8))
    assert_same_as_bundled(robot, "panda")


def test_the_course_file_accepts_the_parameters_of_its_macro():
    robot = ulna.load(COURSE, xacro_args={"arm_id": "left", "description_pkg": "elsewhere"})
    assert robot.joint_names == tuple(f"left_joint{k}" for k in range(1, 8))
    meshes = {body.shape.uri for link in robot.description.links for body in link.visuals}
    assert meshes == {f"package://elsewhere/meshes/visual/link{k}.dae" for k in range(8)}
    assert_same_as_bundled(robot, "left")


def test_the_course_file_can_be_included_by_another_file(tmp_path):
    include, world = f'<xacro:include filename="{COURSE}"/>', '<link name="world"/>'
    call = '<xacro:panda_arm connected_to="world" xyz="0 0.5 0" rpy="0 0 ${pi/2}"/>'
    file = written(tmp_path, include, world, call)
    with pytest.raises(DescriptionError, match=r"xacro: reads .*franka_robot\.urdf, which lies outside the document's folder"):
        ulna.load(file)
    robot = ulna.load(file, package_dirs=[COURSE.parent])
    assert robot.base == "world"
    T_world_link0 = ulna.pose((0, 0.5, 0), (0, 0, np.pi / 2))
    q = ulna.load("panda").home
    expected = T_world_link0 @ ulna.load(COURSE).forward_kinematics(q)
    np.testing.assert_allclose(robot.forward_kinematics(q), expected, atol=1e-12)


def test_an_unknown_parameter_is_refused_with_the_known_names():
    with pytest.raises(DescriptionError, match=r"macro 'panda_arm' has no parameter 'arm'; did you mean 'arm_id'\?"):
        ulna.load(COURSE, xacro_args={"arm": "left"})
    with pytest.raises(
        DescriptionError, match=r"no parameter 'zz'; there are 'arm_id', 'description_pkg', 'connected_to', 'xyz', 'rpy'$"
    ):
        ulna.load(COURSE, xacro_args={"zz": 1})


def test_a_missing_parameter_is_named(tmp_path):
    file = written(tmp_path, MACRO.format("arm", "n side:='left arm' *mount"))
    with pytest.raises(
        DescriptionError, match=r"^r\.urdf\.xacro:2: xacro: only defines the macro 'arm'; to call it, give n in xacro_args$"
    ):
        ulna.load(file)


def test_a_required_parameter_can_be_given(tmp_path):
    file = written(tmp_path, MACRO.format("arm", "n side:='left arm'"))
    assert ulna.load(file, xacro_args={"n": "base"}).link_names == ("base",)
    assert ulna.load(file.read_text(), xacro_args={"n": 5}).link_names == ("5",)


def test_none_is_no_value_of_a_parameter(tmp_path):
    file = written(tmp_path, MACRO.format("arm", "n side:='left arm'"))
    with pytest.raises(InputError, match=r"^xacro_args: n: None; a value is expected"):
        ulna.load(file, xacro_args={"n": None})


def test_two_macros_without_a_call_are_refused(tmp_path):
    file = written(tmp_path, MACRO.format("left", "n:=a"), MACRO.format("right", "n:=b"))
    with pytest.raises(
        DescriptionError, match=r"^r\.urdf\.xacro:2: xacro: defines the macros left, right and calls none; add a call such as"
    ):
        ulna.load(file)


def test_two_macros_of_which_one_is_called_are_expanded(tmp_path):
    file = written(tmp_path, MACRO.format("left", "n:=a"), MACRO.format("right", "n:=b"), "<xacro:right/>")
    assert ulna.load(file).link_names == ("b",)


def test_an_argument_overrides_its_default(tmp_path):
    file = written(tmp_path, '<xacro:arg name="n" default="a"/>', '<link name="$(arg n)"/>')
    assert ulna.load(file).link_names == ("a",)
    assert ulna.load(file, xacro_args={"n": "b"}).link_names == ("b",)


def test_a_file_that_only_declares_the_namespace_is_a_plain_urdf(tmp_path):
    file = written(tmp_path, '<link name="a"/>')
    assert ulna.load(file).to_urdf() == file.read_text()
    with pytest.warns(DescriptionWarning, match=r"^r\.urdf\.xacro is not a xacro file, so it takes no arguments: 'n'"):
        ulna.load(file, xacro_args={"n": "b"})


@pytest.mark.slow
@pytest.mark.parametrize("endless", ["${9**9**9}", "${python.sum(range(10**12))}"])
def test_an_endless_expression_is_stopped(monkeypatch, endless):
    monkeypatch.setattr(xacro, "TIME_LIMIT_S", 2)
    with pytest.raises(DescriptionError, match=r"^URDF text: xacro: not finished within 2 s; expansion stopped$"):
        ulna.load(document(f'<link name="{endless}"/>'))


# fmt: off
FAILURES = {
    "a macro that calls itself": (['<xacro:macro name="m" params=""><xacro:m/></xacro:macro>', "<xacro:m/>"],
        "calls itself without end"),
    "a file that includes itself": (['<xacro:include filename="r.urdf.xacro"/>'], "without end"),
    "more memory than there is": (['<link name="${len([0] * 10**10)}"/>'], "memory"),
    "a name that nothing defines": (['<link name="${side}"/>'], "name 'side' is not defined"),
    "a macro that nothing defines": (["<xacro:arm/>"], "unknown macro name: xacro:arm"),
    "a property defined by itself": (['<xacro:property name="a" value="${a}"/>', '<link name="${a}"/>'],
        "circular variable definition"),
    "Python that does not parse": (['<link name="${1 +}"/>'], "invalid syntax"),
    "Python that reaches for files": (["<link name=\"${open('/etc/passwd').read()}\"/>"], "name 'open' is not defined"),
    "Python that imports": (["<link name=\"${__import__('os').getcwd()}\"/>"], "invalid name"),
    "an include that is not there": (['<xacro:include filename="gone.xacro"/>'], "gone.xacro"),
    "a package that is not there": (['<xacro:include filename="$(find gone)/x"/>'],
        r"\$\(find gone\): no such package in package_dirs"),
}
# fmt: on


@pytest.mark.parametrize("name", FAILURES)
def test_a_failed_expansion_is_reported_in_one_line(tmp_path, name):
    lines, sentence = FAILURES[name]
    with pytest.raises(DescriptionError, match=sentence) as caught:
        ulna.load(written(tmp_path, *lines))
    message = str(caught.value)
    assert message.startswith("r.urdf.xacro: xacro: ")
    assert "\n" not in message
    assert "<class" not in message
    assert message.count(sentence.replace("\\", "")) == 1


def test_a_file_in_the_working_folder_does_not_replace_a_module(tmp_path, monkeypatch):
    """The expansion runs in its own process, which must import the same modules as this one."""
    for name in ("xacro", "json", "ulna"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not the module you want')")
    monkeypatch.chdir(tmp_path)
    assert ulna.load(document('<xacro:property name="n" value="a"/>', '<link name="${n}"/>')).link_names == ("a",)


def test_an_include_is_found_relative_to_the_including_file(tmp_path):
    written(tmp_path / "parts", '<xacro:include filename="deeper/b.xacro"/>', name="a.xacro")
    written(tmp_path / "parts" / "deeper", '<link name="b"/>', name="b.xacro")
    assert ulna.load(written(tmp_path, '<xacro:include filename="parts/a.xacro"/>')).link_names == ("b",)


def test_a_package_is_found_in_package_dirs_before_ros(tmp_path, monkeypatch):
    for place in ("mine", "ros"):
        written(tmp_path / place / "gripper", f'<link name="{place}"/>', name="g.xacro")
    file = written(tmp_path / "top", '<xacro:include filename="$(find gripper)/g.xacro"/>')
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path / 'ros'}")
    assert ulna.load(file).link_names == ("ros",)
    assert ulna.load(file, package_dirs=[tmp_path / "mine"]).link_names == ("mine",)
    assert ulna.load(file, package_dirs=[str(tmp_path / "mine" / "gripper")]).link_names == ("mine",)


def test_the_line_of_a_defect_refers_to_the_expanded_text(tmp_path):
    joint = '<joint name="j" type="fixed"><parent link="${n}"/><child link="b"/></joint>'
    file = written(tmp_path, '<xacro:property name="n" value="a"/>', '<link name="${n}"/>', joint)
    message = r"^r\.urdf\.xacro \(expanded; `ulna urdf` prints it\):4: joint 'j': child link 'b' is not defined"
    with pytest.raises(DescriptionError, match=message):
        ulna.load(file)


def test_the_current_folder_is_that_of_the_document_though_its_process_is_elsewhere(tmp_path):
    (tmp_path / "part.yaml").write_text("name: found")
    (tmp_path / "r.xacro").write_text(document("<link name=\"${xacro.load_yaml('$(cwd)/part.yaml').name}\"/>"))
    assert ulna.load(tmp_path / "r.xacro").link_names == ("found",)


def test_a_relative_name_in_a_text_is_beside_the_current_folder(tmp_path, monkeypatch):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "part.xacro").write_text(document("<link name=\"${xacro.load_yaml('a.yaml').name}\"/>"))
    (tmp_path / "sub" / "a.yaml").write_text("name: found")
    monkeypatch.chdir(tmp_path)
    assert ulna.load(document('<xacro:include filename="sub/part.xacro"/>'), package_dirs=["."]).link_names == ("found",)
