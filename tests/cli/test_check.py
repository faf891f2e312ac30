"""``ulna check``."""

import json
import re

import pytest

from ulna.errors import MissingExtraError, install_command

FAR = "5,0,0,0,0,0,1,1,1"
NEAR = "1.4,0,0,0,0,0,1,1,1"  # of the cube at q: overlaps by q - 0.4


def test_free_is_exit_status_0(ask, run, slider):
    answer = ask("check", slider, "--box", FAR)
    assert (answer.exit_code, answer.in_collision, answer.touching, answer.pairs) == (0, False, [], [])
    result = run("check", slider, "--box", FAR)
    assert result.exit_code == 0
    assert result.stdout.splitlines()[-1] == "free"


def test_collision_is_exit_status_1_with_the_depth(ask, slider):
    answer = ask("check", slider, "--q", "0.5", "--box", NEAR)
    assert (answer.exit_code, answer.in_collision, answer.touching) == (1, True, ["cube"])
    (pair,) = answer.pairs
    assert (pair["name_a"], pair["name_b"], pair["link_a"]) == ("cube", "box 1", "cube")
    assert pair["signed_distance"] == pytest.approx(-0.1, abs=1e-12)
    assert pair["normal"] == pytest.approx([1, 0, 0], abs=1e-12)


def test_the_table_shows_millimeters(run, slider):
    result = run("check", slider, "--q", "0.5", "--box", NEAR)
    assert result.exit_code == 1
    assert re.search(r"cube +cube +box 1 +-100\.000 +1\.00 0\.00 0\.00 +1\.000 \S+ \S+", result.stdout)
    assert result.stdout.splitlines()[-2:] == ["minimum distance: -100.000 mm", "collision"]


def test_boxes_are_numbered_and_the_deepest_comes_first(ask, slider):
    answer = ask("check", slider, "--box", "0.9,0,0,0,0,0,1,1,1", "--box", FAR, "--box", "0,0.7,0,0,0,0,1,1,1")
    assert [(pair["name_b"], round(pair["signed_distance"], 9)) for pair in answer.pairs] == [("box 3", -0.3), ("box 1", -0.1)]


@pytest.mark.parametrize(("radius", "hit"), [("0.59", False), ("0.61", True)])
def test_a_file_of_points_is_an_obstacle(ask, slider, tmp_path, radius, hit):
    (tmp_path / "seen.xyz").write_text("1.1 0 0\n3 0 0\n", encoding="utf-8")
    answer = ask("check", slider, "--cloud", tmp_path / "seen.xyz", "--cloud-radius", radius)
    assert answer.in_collision is hit
    assert answer.touching == ["cube"] * hit


@pytest.mark.parametrize(("edge", "hit"), [(1.1999, False), (1.2001, True)])
def test_the_extents_of_a_box_are_in_the_order_length_width_height(ask, slider, edge, hit):
    for axis in range(3):
        place, extents = [0.0] * 3, [0.1] * 3
        place[axis], extents[axis] = 1.1, edge
        assert ask("check", slider, "--box", " ".join(map(str, [*place, 0, 0, 0, *extents]))).in_collision is hit


def test_angles_of_a_box_may_be_degrees(ask, slider):
    for yaw, degrees in (("pi/4", ()), ("45", ("--degrees",))):  # the corner reaches 0.5 * sqrt(2) to the left
        assert ask("check", slider, "--box", f"1.2 0 0 0 0 {yaw} 1 1 1", *degrees).in_collision
        assert not ask("check", slider, "--box", f"1.21 0 0 0 0 {yaw} 1 1 1", *degrees).in_collision


def test_the_box_of_the_demo_is_free_at_home(run):
    assert run("check", "--box", "0.5,0,0.21,0,0,0,0.15,0.09,0.126").exit_code == 0


def test_a_box_around_the_hand_touches_the_hand(ask):
    answer = ask("check", "--box", "0.306891,0,0.55,0,0,0,0.05,0.05,0.05")
    assert answer.exit_code == 1
    assert "box 12" in answer.touching


def test_a_box_around_the_whole_arm_touches_all_of_it(ask):
    assert ask("check", "--box", "0,0,0,0,0,0,9,9,9").touching == [f"box {k}" for k in range(1, 13)]


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        (["--box", "1,2,3"], "--box: 3 numbers, but 9 are expected: x, y, z, roll, pitch, yaw, length, width, height"),
        (["--box", "0,0,0,0,0,0,1,1,-1"], "extents: "),
        (["--cloud", "none.npy"], "none.npy: no such file"),
        (["--cloud", "none.las"], "none.las: "),
        (
            ["--box", FAR, "--q", "one"],
            "no state of the SRDF is called 'one'; there are none; states are read from an SRDF: --srdf",
        ),
    ],
)
def test_bad_arguments_are_refused(refusal, arguments, start):
    assert refusal("check", *arguments).startswith(start)


def test_a_robot_whose_shapes_cannot_be_checked_is_an_error(refusal, odd):
    assert "mast.stl: no such file" in refusal("check", odd, "--box", FAR)
    assert "1 of its collision shapes are meshes" in refusal("check", odd, "--meshes", "none", "--box", FAR)


def test_a_robot_without_shapes_is_an_error_not_free(refusal, xacro):
    assert "has no collision shapes" in refusal("check", xacro, "--xacro-arg", "length:=1", "--box", FAR)


def test_without_a_box_the_robot_is_checked_against_itself(ask):
    answer = ask("check")
    assert (answer.exit_code, answer.pairs) == (0, [])
    assert answer.signed_distance == pytest.approx(0.0357, abs=1e-4)
    folded = ask("check", "--q", "0 1.7 0 -3 0 0 0")
    assert folded.exit_code == 1
    assert {pair["link_b"] for pair in folded.pairs} & {"panda_link5", "panda_link7"}
    assert ask("check", "--q", "0 1.7 0 -3 0 0 0", "--no-self", "--box", FAR).exit_code == 0


def test_an_empty_world_without_self_collision_has_no_distance(ask):
    assert ask("check", "--no-self").signed_distance is None


def test_within_lists_pairs_nearer_than_a_distance(ask, slider):
    answer = ask("check", slider, "--box", "1.3,0,0,0,0,0,1,1,1", "--within", "0.35")
    assert answer.exit_code == 0
    (pair,) = answer.pairs
    assert pair["signed_distance"] == answer.signed_distance == pytest.approx(0.3, abs=1e-12)
    assert pair["witness_b"][0] - pair["witness_a"][0] == pytest.approx(0.3, abs=1e-12)


def test_a_pair_names_the_point_of_a_cloud(ask, run, slider, tmp_path):
    points = tmp_path / "seen.csv"
    points.write_text("5,0,0\n0.9,0,0\n7,0,0\n")
    arguments = "check", slider, "--cloud", str(points), "--within", "1"
    (pair,) = ask(*arguments).pairs
    assert (pair["name_b"], pair["point"]) == ("seen", 1)
    assert "seen, point 1" in run(*arguments).output
    (pair,) = ask("check", slider, "--box", "1.3,0,0,0,0,0,1,1,1", "--within", "0.35").pairs
    assert pair["point"] is None


@pytest.mark.parametrize("options", [(), ("--meshes", "hulls")])
def test_meshes_are_checked_as_hulls_and_a_line_says_so(ask, run, wedge, options):
    box = ("--box", "0.2,0.2,0.2,0,0,0,0.1,0.1,0.1")
    assert run("check", wedge, *options, *box).stderr.splitlines().count("collision by convex hulls of 1 mesh") == 1
    found = ask("check", wedge, *options, *box)
    assert (found.touching, found.in_place_of_meshes) == (["wedge"], "collision by convex hulls of 1 mesh")
    assert ask("check", wedge, *options, "--box", "0.9,0.9,0.9,0,0,0,0.1,0.1,0.1").touching == []


def test_unconverted_meshes_are_refused_with_the_options_that_convert_them(run, wedge):
    result = run("check", wedge, "--meshes", "none")
    assert result.exit_code == 2
    assert f"--meshes hulls ({install_command('hulls')})" in result.stderr
    assert "robot.with" not in result.stderr


def test_a_robot_without_meshes_is_checked_without_a_line_about_meshes(run):
    assert run("check", "panda", "--meshes", "decompose").stderr == ""


def test_a_missing_extra_is_named(run, wedge, monkeypatch):
    def missing_extra():
        raise MissingExtraError("reading meshes", "hulls")

    monkeypatch.setattr("ulna.description.meshes.hulls.mesh_reader", missing_extra)
    result = run("check", wedge)
    assert result.exit_code == 2
    assert install_command("hulls") in result.stderr


def test_touch_links_of_a_scene_file_are_excluded_from_the_check(ask, slider, tmp_path):
    scene = {"ulna_scene": 1, "objects": [{"name": "floor", "shape": "half_space"}]}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene))
    assert ask("check", slider, "--scene", path).in_collision
    scene["objects"][0]["touch_links"] = ["cube"]
    path.write_text(json.dumps(scene))
    answer = ask("check", slider, "--scene", path)
    assert (answer.exit_code, answer.in_collision, answer.signed_distance, answer.pairs) == (0, False, None, [])


@pytest.fixture
def motion_file(tmp_path):
    """A motion of the cube from 0 to 0.5 m, from rest to rest, whose greatest speed is 0.75 m/s."""
    points = [
        {"positions": [q], "velocities": [0.0], "time_from_start": {"sec": sec, "nanosec": 0}} for q, sec in ((0.0, 0), (0.5, 1))
    ]
    path = tmp_path / "motion.json"
    path.write_text(json.dumps({"joint_names": ["slide"], "points": points}), encoding="utf-8")
    return path


def test_a_motion_is_certified_free_and_within_the_limits_of_the_hand_or_touches_at_a_time(ask, run, slider, motion_file):
    answer = ask("check", slider, "--motion", motion_file, "--box", FAR, "--hand-speed", "0.76")
    assert (answer.exit_code, answer.in_collision, answer.touches_at, answer.certified) == (0, False, None, True)
    assert answer.within_limits
    assert "the speed of cube peaks at 0.75 m/s at 0.500 s" in answer.check
    assert answer.duration == 1
    answer = ask("check", slider, "--motion", motion_file, "--hand-speed", "0.74")
    assert (answer.exit_code, answer.certified, answer.within_limits) == (1, True, False)
    answer = ask("check", slider, "--motion", motion_file, "--box", NEAR)  # it touches from q = 0.4 on
    assert (answer.exit_code, answer.in_collision, answer.certified) == (1, True, False)
    t = answer.touches_at
    assert 0.5 * (3 * t**2 - 2 * t**3) == pytest.approx(0.4, abs=1e-3)
    assert run("check", slider, "--motion", motion_file, "--box", NEAR).stdout.splitlines()[-1] == f"collision at {t:.3f} s"
    assert run("check", slider, "--motion", motion_file).stdout.splitlines()[-1] == "certified free"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--hand-speed", "1"), "--hand-speed: requires --motion"),
        (("--motion", "motion.json", "--q", "0"), "--q, --no-self, --within: apply to a configuration"),
        (("--motion", "none.json"), "none.json: no such file"),
        (("--motion", "motion.json", "--hand-speed", "0"), "--hand-speed: 0.0; a number above 0"),
    ],
)
def test_options_of_a_motion_go_together(refusal, slider, motion_file, monkeypatch, arguments, message):
    monkeypatch.chdir(motion_file.parent)
    assert refusal("check", slider, *arguments).startswith(message)
