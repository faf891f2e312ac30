"""SDF against the frames, axes and limits that libsdformat resolves: ``sdf/judged.json``, which ``sdf/judge.cpp`` printed."""

# ruff: noqa: E501

import json
from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna import Box, Capsule, Cylinder, DescriptionError, DescriptionWarning, FileError, Sphere
from ulna.description.robot_description import JointType
from ulna.description.shapes import Mesh
from ulna.inspection.result import NOTE

FOLDER = Path(__file__).parent / "sdf"
JUDGED = json.loads(
    (FOLDER / "judged.json").read_text().replace('"arm_joint"', '"arm"')
)  # a joint called as a link is renamed there
FILES = [name for name in JUDGED if name != "libsdformat"]
LIMIT = 1e-12
pytestmark = pytest.mark.filterwarnings("ignore:.*is static and not the robot")
PRISMATIC, REVOLUTE, CONTINUOUS, FIXED = 5, 6, 2, 3  # of libsdformat's enum JointType


def moved(joint, q):
    """The motion of a joint in its frame, by the exponential of its axis."""
    T, axis = np.eye(4), np.array(joint["axis"])
    if joint["type"] == PRISMATIC:
        T[:3, 3] = q * axis
    else:
        K = np.cross(np.eye(3), axis)
        T[:3, :3] += np.sin(q) * K + (1 - np.cos(q)) * K @ K
    return T


def judged_poses(judged, q):
    """The pose of each link and frame where each joint is at its entry of q."""
    zero = {name: np.array(T) for name, T in judged["links"].items()} | {"world": np.eye(4)}
    carriers = {joint["child"]: (name, joint) for name, joint in judged["joints"].items()}

    def pose(link):
        if link not in carriers:
            return zero[link]
        name, joint = carriers[link]
        J, parent = np.array(joint["pose"]), joint["parent"]
        motion = moved(joint, q[name]) if "axis" in joint else np.eye(4)
        return pose(parent) @ np.linalg.inv(zero[parent]) @ J @ motion @ np.linalg.inv(J) @ zero[link]

    frames = {
        name: pose(one["body"]) @ np.linalg.inv(zero[one["body"]]) @ np.array(one["pose"])
        for name, one in judged["frames"].items()
    }
    return {name: pose(name) for name in judged["links"]} | frames


@pytest.mark.parametrize("file", FILES)
def test_every_link_and_frame_is_where_libsdformat_has_it(file):
    robot, judged = ulna.load(FOLDER / file), JUDGED[file]
    for q in robot.random(20, seed=1):
        poses = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
        for name, T in judged_poses(judged, dict(zip(robot.joint_names, q, strict=True))).items():
            assert np.abs(poses.pop(name) - T).max() < LIMIT, name
        assert all(name == "world" or "_at_" in name for name in poses)


@pytest.mark.parametrize("file", FILES)
def test_every_shape_is_where_libsdformat_has_it(file):
    found = {
        f"{link.name}/{body.name}": body.pose
        for link in ulna.load(FOLDER / file).description.links
        for body in (*link.visuals, *link.collisions)
    }
    assert found.keys() == JUDGED[file]["shapes"].keys()
    assert all(np.abs(found[name] - np.array(T)).max() < LIMIT for name, T in JUDGED[file]["shapes"].items())


@pytest.mark.parametrize("file", FILES)
def test_types_and_limits_are_libsdformats(file):
    joints = {joint.name: joint for joint in ulna.load(FOLDER / file).description.joints}
    for name, judged in JUDGED[file]["joints"].items():
        joint = joints[name]
        if judged["type"] == FIXED:
            assert joint.type == JointType.FIXED
            continue
        judge = {key: judged[key] if abs(judged[key]) < 1e16 else np.copysign(np.inf, judged[key]) for key in ("lower", "upper")}
        is_endless = judged["type"] == CONTINUOUS or (judged["type"] == REVOLUTE and np.isinf([*judge.values()]).all())
        expected = (
            JointType.CONTINUOUS if is_endless else JointType.PRISMATIC if judged["type"] == PRISMATIC else JointType.REVOLUTE
        )
        assert joint.type == expected
        assert (joint.limits.lower, joint.limits.upper) == ((-np.inf, np.inf) if is_endless else (judge["lower"], judge["upper"]))
        for mine, its in ((joint.limits.effort, judged["effort"]), (joint.limits.velocity, judged["velocity"])):
            assert mine == (its if 0 <= its < 1e16 else np.inf)


LINKS = '<link name="a"/><link name="b"/>'
AXIS = "<axis><xyz>0 0 1</xyz></axis>"
JOINT = f'<joint name="j" type="revolute"><parent>a</parent><child>b</child>{AXIS}</joint>'


def text(parts=LINKS + JOINT, version="1.9"):
    return f'<sdf version="{version}"><model name="m">{parts}</model></sdf>'


def joint(inside, kind="revolute", more=""):
    return text(f'{LINKS}<joint name="j" type="{kind}"{more}><parent>a</parent><child>b</child>{inside}</joint>')


REFUSED = {
    "a newer version": (text(version="1.13"), "is SDF 1.13; versions 1.4 to 1.12 are read"),
    "an older version": (text(version="1.3"), "is SDF 1.3; versions 1.4 to 1.12 are read"),
    "no version": ('<sdf><model name="m"/></sdf>', "another version"),
    "the root of before 1.3": ('<gazebo version="1.0"/>', "not a URDF but SDF of before 1.3"),
    "no model": ('<sdf version="1.9"/>', "one <model> or one <world> is expected, and there is none"),
    "two models": ('<sdf version="1.9"><model name="m"/><model name="n"/></sdf>', "there is model 'm', model 'n'; save"),
    "two models of a world": (
        '<sdf version="1.6"><world name="w"><model name="m"/><model name="n"/></world></sdf>',
        "world 'w': one model that is not static is expected, and there is model 'm', model 'n'",
    ),
    "a joint of the world": (
        '<sdf version="1.10"><world name="w"><joint name="tie"/></world></sdf>',
        "joint 'tie': is a joint of the world",
    ),
    "no links": (text(""), "model 'm': has no links"),
    "several roots": (text(LINKS), "2 links have no parent"),
    "a loop": (text(LINKS + JOINT + JOINT.replace('"j"', '"k"')), "link 'b' is the child of two joints"),
    "a joint of a link with itself": (text(LINKS + JOINT.replace("<child>b", "<child>a")), "joint 'j': joins link 'a' to itself"),
    **{
        f"a {kind} joint": (joint(AXIS, kind), f"joint 'j': is a {kind} joint, which is not read")
        for kind in ("screw", "universal", "ball", "revolute2", "gearbox")
    },
    "an unknown joint": (joint(AXIS, "revolut"), "type 'revolut' is not known; did you mean 'revolute'"),
    "a second axis": (joint(AXIS + "<axis2/>"), "is revolute, and has a second axis"),
    "no axis": (joint(""), "is revolute and has no <axis>"),
    "an axis of no direction": (joint("<axis><xyz>0 0 0</xyz></axis>"), "its axis has no direction"),
    "an unknown frame of an axis": (
        joint('<axis><xyz expressed_in="c">0 0 1</xyz></axis>'),
        "joint 'j': frame 'c' is not defined; there are",
    ),
    "an unknown parent": (text(LINKS + JOINT.replace("<parent>a", "<parent>hand")), "joint 'j': frame 'hand' is not defined"),
    "the world as a child": (text(LINKS + JOINT.replace("<child>b", "<child>world")), "joint 'j': frame 'world' is not defined"),
    "no parent": (text(LINKS + JOINT.replace("<parent>a</parent>", "")), "joint 'j': has no <parent>"),
    "limits without a range": (
        joint("<axis><limit><lower>1</lower><upper>-1</upper></limit></axis>"),
        "joint 'j': lower limit 1.0 and upper limit -1.0 leave no range",
    ),
    "a limit that is not a number": (joint("<axis><limit><lower>low</lower></limit></axis>"), "<lower> 'low': not numbers"),
    "a limit that is NaN": (joint("<axis><limit><lower>nan</lower></limit></axis>"), "<lower> 'nan': one number is expected"),
    "a mimic before 1.11": (joint('<axis><mimic joint="k"/></axis>'), "<mimic> is of SDF 1.11, and this document is of 1.9"),
    "a pose of five numbers": (
        text('<link name="a"><pose>0 0 0 0 0</pose></link>'),
        "<pose> '0 0 0 0 0': 6 finite numbers expected",
    ),
    "a pose without end": (text('<link name="a"><pose>inf 0 0 0 0 0</pose></link>'), "6 finite numbers expected"),
    "a pose that is far out": (text('<link name="a"><pose>1e9 0 0 0 0 0</pose></link>'), "link 'a': its pose is beyond 1e"),
    "poses that are far out together": (
        text(
            '<link name="a"><pose>9e5 0 0 0 0 0</pose></link><link name="b"><pose relative_to="a">9e5 0 0 0 0 0</pose></link>'
            + JOINT
        ),
        "link 'b': its position is beyond 1e",
    ),
    "a quaternion of length 0": (
        text('<link name="a"><pose rotation_format="quat_xyzw">0 0 0 0 0 0 0</pose></link>'),
        "or of length 0, which is no orientation",
    ),
    "a quaternion in degrees": (
        text('<link name="a"><pose rotation_format="quat_xyzw" degrees="true">0 0 0 0 0 0 1</pose></link>'),
        "a quaternion with degrees",
    ),
    "an unknown format": (
        text('<link name="a"><pose rotation_format="wxyz">0</pose></link>'),
        "rotation_format 'wxyz' is not known",
    ),
    "degrees that are no truth value": (
        text('<link name="a"><pose degrees="yes">0</pose></link>'),
        "degrees is 'yes'; true or false",
    ),
    "an unknown base": (text('<link name="a"><pose relative_to="b"/></link>'), "link 'a': frame 'b' is not defined"),
    "poses in a circle": (
        text('<link name="a"><pose relative_to="b"/></link><link name="b"><pose relative_to="a"/></link>' + JOINT),
        "frames are relative or attached to each other in a circle: ",
    ),
    "frames in a circle": (
        text(LINKS + JOINT + '<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'),
        "frames are relative or attached to each other in a circle: ",
    ),
    "a placement frame that is not there": (
        '<sdf version="1.9"><model name="m" placement_frame="p"><link name="a"/></model></sdf>',
        "model 'm': frame 'p' is not defined",
    ),
    "two of one name": (text(LINKS + JOINT + '<frame name="a"/>'), "frame 'a': another link, joint, frame or model"),
    "two joints of one name": (text(LINKS + JOINT + JOINT, "1.6"), "joint 'j': is defined twice"),
    "a name of SDF": (text('<link name="__model__"/>'), "the name '__model__' is reserved by SDF"),
    "a link that is called world": (text('<link name="world"/>'), "the name 'world' is reserved by SDF"),
    "relative_to before 1.7": (text('<link name="a"><pose relative_to="b"/></link>', "1.6"), "relative_to is of SDF 1.7"),
    "degrees before 1.9": (text('<link name="a"><pose degrees="true">0</pose></link>', "1.8"), "degrees is of SDF 1.9"),
    "the frame of a pose before 1.7": (
        text('<link name="a"><pose frame="b"/></link>', "1.5"),
        "its pose has a frame, which SDF 1.6",
    ),
    "expressed_in before 1.7": (
        text(LINKS + JOINT.replace("<xyz>", '<xyz expressed_in="a">'), "1.6"),
        "expressed_in is of SDF 1.7",
    ),
    "a model's frame for an axis from 1.7 on": (
        text(LINKS + JOINT.replace("</xyz>", "</xyz><use_parent_model_frame>1</use_parent_model_frame>")),
        "use_parent_model_frame is of SDF 1.5 and 1.6",
    ),
    "a static model in one that moves": (
        text(LINKS + JOINT + '<model name="n"><static>1</static><link name="c"/></model>'),
        "model 'n': is static in a model that is not",
    ),
    "a static that is no truth value": (text("<static>yes</static>" + LINKS), "<static> is 'yes'; true or false is expected"),
    "a collision shape of two kinds": (
        text('<link name="a"><collision name="c"><geometry><box/><sphere/></geometry></collision></link>'),
        "collision 'c': its <geometry> has 2 shapes",
    ),
    "a box without a size": (
        text('<link name="a"><collision name="c"><geometry><box/></geometry></collision></link>'),
        "collision 'c': its <box> has no <size>",
    ),
    "a negative radius": (
        text('<link name="a"><collision name="c"><geometry><sphere><radius>-1</radius></sphere></geometry></collision></link>'),
        "<radius> '-1': 1 finite number of at least 0 expected",
    ),
    "a merged model": (text('<include merge="true"><uri>model://x</uri></include>'), "include 'model://x': merge is not read"),
    "a changed model": (
        '<sdf version="1.9" xmlns:experimental="e"><model name="m"><include><uri>model://x</uri><experimental:params/></include></model></sdf>',
        "include 'model://x': has parameters",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_changes_a_pose_a_shape_or_a_limit_and_is_not_read_is_refused_by_its_name(name):
    document, words = REFUSED[name]
    with pytest.raises(DescriptionError) as error:
        ulna.load(document)
    assert words in str(error.value)
    assert not ulna.inspect(document).loads


LEFT_OUT = {
    "a misspelt pose": (
        text('<link name="a"><poze>0 0 0 0 0 0</poze></link>'),
        "<poze> in <link> is not known, and left out; did you mean 'pose'",
    ),
    "a misspelt attribute": (text('<link name="a"><pose relative="b"/></link>'), "attribute 'relative' of <pose> is not known"),
    "a range of a continuous joint": (
        joint("<axis><limit><lower>-1</lower><upper>1</upper></limit></axis>", "continuous"),
        "lower and upper of a continuous joint are not used",
    ),
    "the frames of 1.6": (
        text(LINKS + JOINT + '<frame name="f"/>', "1.6"),
        "frame 'f': a frame of SDF 1.6 and before is not used",
    ),
    "a faulty visual": (
        text('<link name="a"><visual name="v"><geometry><box/></geometry></visual></link>'),
        "visual 'v': visual 'v': its <box> has no <size>: this visual is left out",
    ),
    "a plane that is seen": (
        text('<link name="a"><visual name="v"><geometry><plane/></geometry></visual></link>'),
        "its geometry is <plane>, which is not known: it is not drawn",
    ),
    "the joints of a static model": (
        text("<static>1</static>" + LINKS + JOINT),
        "model: is static, so its joints do not move: j",
    ),
    **{
        f"a collision shape that is {shape}": (
            text(f'<link name="a"><collision name="c"><geometry>{shape}</geometry></collision></link>'),
            f"its geometry is {kind}, which is not known: poses can be computed, collisions cannot",
        )
        for shape, kind in {
            "<plane/>": "<plane>",
            "<heightmap/>": "<heightmap>",
            "<ellipsoid><radii>1 2 3</radii></ellipsoid>": "<ellipsoid>",
            "<cone/>": "<cone>",
            "<mesh><uri>x.stl</uri><submesh><name>lid</name></submesh></mesh>": "a <submesh>",
        }.items()
    },
}


@pytest.mark.parametrize("name", LEFT_OUT)
def test_what_may_matter_and_is_left_out_is_warned_of_and_a_finding(name):
    document, words = LEFT_OUT[name]
    with pytest.warns(DescriptionWarning) as caught:
        ulna.load(document)
    assert words in str(caught[0].message)
    assert any(words.rpartition(": ")[2] in finding.message for finding in ulna.inspect(document).findings)


def test_what_no_pose_depends_on_is_a_note_of_inspect_only():
    document = text("<plugin/><self_collide>1</self_collide>" + LINKS.replace("/>", "><inertial/><sensor/></link>") + JOINT)
    assert ulna.load(document).n_dof == 1
    notes = [one.message for one in ulna.inspect(document).findings if one.severity == NOTE]
    assert {"1 <plugin> in <model> not used", "2 <sensor> in <link> not used", "1 <self_collide> in <model> not used"} <= set(
        notes
    )


def test_a_joint_that_follows_another_is_multiplied_about_its_reference():
    follow = '<mimic joint="j"><multiplier>-2</multiplier><offset>0.5</offset><reference>0.25</reference></mimic>'
    more = JOINT.replace('"j"', '"k"').replace("<child>b", "<child>c").replace("<xyz>", follow + "<xyz>")
    robot = ulna.load(text(LINKS + '<link name="c"/>' + JOINT + more, "1.11"))
    assert robot.joint_names == ("j",)
    c = dict(zip(robot.link_names, robot.link_poses([0.75]), strict=True))["c"]
    assert np.allclose(c, ulna.pose(rpy=(0, 0, -2 * (0.75 - 0.25) + 0.5)), atol=1e-15)


def test_shapes_and_colors_are_those_of_the_text():
    shapes = {
        "<box><size>1 2 3</size></box>": Box((1, 2, 3)),
        "<sphere><radius>2</radius></sphere>": Sphere(2),
        "<ellipsoid><radii>2 2 2</radii></ellipsoid>": Sphere(2),
        "<cylinder><radius>1</radius><length>2</length></cylinder>": Cylinder(1, 2),
        "<capsule><radius>1</radius><length>2</length></capsule>": Capsule(1, 2),
        "<mesh><uri>model://x/a.stl</uri><scale>1 -1 2</scale></mesh>": Mesh("model://x/a.stl", (1, -1, 2)),
        "<mesh><uri>a.stl</uri></mesh>": Mesh("a.stl"),
    }
    seen = "<material><diffuse>1 0.5 0 0.25</diffuse></material>"
    bodies = "".join(f'<visual name="v{k}"><geometry>{one}</geometry>{seen}</visual>' for k, one in enumerate(shapes))
    empty = '<collision name="c"><geometry><empty/></geometry></collision>'
    (link,) = ulna.load(text(f'<link name="a">{bodies}{empty}</link>')).description.links
    assert [body.shape for body in link.visuals] == list(shapes.values())
    assert {body.color for body in link.visuals} == {(1, 0.5, 0, 0.25)}
    assert not link.collisions


def test_the_links_of_a_static_model_are_fixed_to_the_world():
    robot = ulna.load(
        text('<static>1</static><link name="a"><pose>1 0 0 0 0 0</pose></link><link name="b"/><pose>0 2 0 0 0 0</pose>')
    )
    assert (robot.n_dof, robot.link_names[0]) == (0, "world")
    assert {name: tuple(T[:3, 3]) for name, T in zip(robot.link_names, robot.link_poses(()), strict=True)}["a"] == (1, 2, 0)


def test_the_only_model_of_a_world_that_is_not_static_is_the_robot_and_its_scenery_is_left_out(tmp_path):
    scenery = (
        '<include><uri>model://sun</uri></include><model name="floor"><static>1</static><link name="l"/></model><light name="x"/>'
    )
    file = tmp_path / "room.world"
    file.write_text(f'<sdf version="1.6"><world name="w">{scenery}<model name="m">{LINKS}{JOINT}</model></world></sdf>')
    with pytest.warns(DescriptionWarning, match=r"include 'model://sun': is left out, as it has no model that can be read"):
        robot = ulna.load(file)
    assert robot.link_names == ("a", "b")
    messages = [finding.message for finding in ulna.inspect(file).findings]
    assert any(message.startswith("is static and not the robot") for message in messages)
    assert "1 <light> in <world> not used" in messages


def test_an_include_that_is_not_found_is_refused_where_no_other_model_moves():
    floor = '<model name="floor"><static>1</static><link name="l"/></model>'
    with pytest.raises(FileError, match="model://arm"):
        ulna.load(f'<sdf version="1.9"><world name="w">{floor}<include><uri>model://arm</uri></include></world></sdf>')


def test_an_included_model_finds_its_meshes_and_the_files_beside_it(tmp_path):
    write = {
        "robots/arm.sdf": text(
            '<link name="a"/><include><uri>model://hand</uri></include><joint name="j" type="fixed"><parent>a</parent><child>hand::palm</child></joint>'
        ),
        "robots/model.config": '<model><sdf version="1.9">arm.sdf</sdf></model>',
        "models/hand/model.config": '<model><sdf version="1.7">hand.sdf</sdf></model>',
        "models/hand/hand.sdf": '<sdf version="1.7"><model name="hand"><link name="palm"><collision name="c"><geometry><mesh><uri>meshes/p.stl</uri></mesh></geometry></collision></link><include><uri>parts/nail.sdf</uri></include><joint name="k" type="fixed"><parent>palm</parent><child>nail::tip</child></joint></model></sdf>',
        "models/hand/parts/nail.sdf": '<sdf version="1.9"><model name="nail"><link name="tip"><collision name="c"><geometry><mesh><uri>../meshes/p.stl</uri></mesh></geometry></collision></link></model></sdf>',
        "models/hand/meshes/p.stl": "solid p\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1\nendloop\nendfacet\nendsolid\n",
    }
    for name, content in write.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    with pytest.raises(FileError, match=r"package_dirs"):
        ulna.load(tmp_path / "robots/arm.sdf")
    robot = ulna.load(tmp_path / "robots/arm.sdf", package_dirs=[tmp_path / "models"], meshes="hulls")
    assert robot.link_names == ("a", "hand::palm", "hand::nail::tip")
    assert [len(link.collisions[0].shape.vertices) for link in robot.description.links[1:]] == [3, 3]


OUTSIDE = {
    "out of its package": ("model://hand/../secret.sdf", "lies outside its package"),
    "out of the folder": ("../secret.sdf", "lies outside the description's folder"),
    "an absolute path": ("file://{}/secret.sdf", "lies outside the description's folder"),
    "the network": ("https://fuel.example/arm.sdf", "nothing is downloaded"),
    "nothing": ("model://nobody", "package_dirs="),
    "itself": ("arm.sdf", "the file includes itself"),
    "a URDF": ("arm.urdf", "is not a supported SDF"),
}


@pytest.mark.parametrize("name", OUTSIDE)
def test_an_include_that_may_not_be_read_is_refused_by_its_address(name, tmp_path):
    uri, words = OUTSIDE[name]
    (tmp_path / "secret.sdf").write_text(text())
    folder = tmp_path / "arm"
    folder.mkdir()
    (folder / "arm.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    (folder / "arm.sdf").write_text(text(f"<include><uri>{uri.format(tmp_path)}</uri></include>"))
    with pytest.raises((DescriptionError, FileError), match=words):
        ulna.load(folder / "arm.sdf")


def test_two_files_that_include_each_other_are_refused(tmp_path):
    for one, other in ("ab", "ba"):
        (tmp_path / f"{one}.sdf").write_text(text(f'<link name="l"/><include><uri>{other}.sdf</uri></include>'))
    with pytest.raises(DescriptionError, match=r"b\.sdf:1: include 'a\.sdf': the file includes itself"):
        ulna.load(tmp_path / "a.sdf")


def test_a_range_with_one_end_is_inspected_and_compared():
    half = joint("<axis><limit><lower>-1</lower></limit></axis>")
    assert ulna.inspect(half).n_dof == 1
    assert (ulna.load(half).lower[0], ulna.load(half).upper[0]) == (-1.0, np.inf)
