"""The inertias of the arms that go by a name, against what their sources state, and against the weights that makers state."""

import numpy as np
import pytest

import ulna
from doc_pages import ROOT
from robot_files import EXAMPLES
from ulna.description.names.arm_tables import arm_tables
from ulna.inspection.boxes import Boxes

# Of the source: the mass of all links [kg], and of one its name, mass, center of mass and tensor in the axes of the link. Those
# of the UR3e and the UR5e are turned about y by a right angle, that of the vx300s about z; that of the M1013 is in axes z, x, y.
STATED = {
    "panda": (
        17.451901,
        "panda_link4",
        3.587895,
        (-5.317e-2, 0.104419, 2.7454e-2),
        (2.5853e-2, 7.796e-3, -1.332e-3, 1.9552e-2, 8.641e-3, 2.8323e-2),
    ),
    "fr3": (
        18.6040010262,
        "fr3_link1",
        2.9274653454,
        (0.0000004128, -0.0181251324, -0.0386035970),
        (
            0.023927316485107913,
            1.3317903455714081e-05,
            -0.00011404774918616684,
            0.0224821613275756,
            -0.0019950320628240115,
            0.006350098258530016,
        ),
    ),
    "irb120": (
        18.146,
        "link_2",
        3.909,
        (0.00078, -0.00212, 0.10124),
        (0.0603111, 9.83431e-06, 5.72407e-05, 0.041569, -0.00050497, 0.0259548),
    ),
    "crx10ia": (
        38.027,
        "J2_link",
        10.892,
        (-3e-05, -0.18256, 0.25387),
        (0.73421484, 1.7153e-05, -4.4993e-05, 0.704450672, 0.057314025, 0.0607225),
    ),
    "gen3_6": (6.9861, "bicep_link", 1.262, (3.5e-05, -0.208207, -0.01889), (0.046752, -9e-06, 0, 0.00085, -9.8e-05, 0.047188)),
    "gen3_7": (
        8.0519,
        "half_arm_1_link",
        1.1636,
        (-4.4e-05, -0.09958, -0.013278),
        (0.011088, 5e-06, 0, 0.001072, -0.000691, 0.011255),
    ),
    "iiwa7": (23.899999, "lbr_link_2", 4.031991, (0, 0.039793, 0.086944), (0.031697, 0, 0, 0.03008, 0.005889, 0.009666)),
    "iiwa14": (
        29.9,
        "lbr_link_2",
        5.688888,
        (0.000136, 0.047548, 0.076322),
        (0.055182, -3.3e-05, 5.6e-05, 0.053983, 0.010034, 0.016523),
    ),
    "m1013": (32.862, "link2", 10.569, (0.266058, -1.6e-05, 0.154872), (0.031, -0.000263, -0.008, 0.82, 1.19e-05, 0.82)),
    "vx300s": (
        3.741939,
        "upper_arm_link",
        0.792592,
        (0.0206949, 4e-10, 0.226459),
        (0.008937, 0, -0.001201, 0.008925, 0, 0.0009357),
    ),
    "xarm6": (
        12.05164,
        "link2",
        2.2675,
        (0.03881, -0.22783, 0.03496),
        (0.028315776, 0.005, 0.00066546, 0.0058, -0.0045741, 0.0273447),
    ),
    "xarm7": (
        11.31706,
        "link3",
        1.6383,
        (0.0466, -0.02463, -0.00768),
        (0.00310955, 0.00030837, -0.00058453, 0.00264483, 0.000338893, 0.0026624),
    ),
    "lite6": (
        7.21893501783165,
        "link2",
        1.192,
        (0.178, 0, 0.0576),
        (0.0015854, -6.766e-06, -0.00115136, 0.0056097, 1.14e-06, 0.00485),
    ),
    "ur3e": (10.7985, "upper_arm_link", 3.4445, (-0.11355, 0, 0.1157), (0.00961875, 0, 0, 0.0217284919125, 0, 0.0217284919125)),
    "ur5e": (
        21.7,
        "upper_arm_link",
        8.058,
        (-0.2125, 0, 0.11336),
        (0.0151074, 0, 0, 0.13388583541666665, 0, 0.13388583541666665),
    ),
    "ur10e": (33.104, "upper_arm_link", 13.051, (-0.2327, 0, 0.158), (0.02814, 5e-05, -0.01561, 0.77068, 2e-05, 0.76943)),
    "ur16e": (31.26, "upper_arm_link", 10.45, (-0.1764, 0, 0.16), (0.02796, -0.0001, -0.0072, 0.47558, 3e-05, 0.47635)),
    "ur20": (64.96, "upper_arm_link", 29.632, (-0.3394, 0, 0.2098), (0.1467, 0.00019, -0.05163, 4.6659, 4e-05, 4.6348)),
    "ur30": (63.147, "upper_arm_link", 28.542, (-0.2476, 0, 0.2103), (0.02796, -0.0001, -0.0072, 0.47558, 3e-05, 0.47635)),
}
# What an arm weighs as its maker states it [kg], cables and covers included; of Franka with the hand.
WEIGHTS = {
    "panda": 18.5, "fr3": 18.5, "irb120": 25, "crx10ia": 40, "gen3_6": 7.2, "gen3_7": 8.2, "iiwa7": 23.9, "iiwa14": 29.9,
    "m1013": 33, "xarm6": 12.2, "xarm7": 13.7, "lite6": 7.2, "ur3e": 11.2, "ur5e": 20.6, "ur10e": 33.5,
    "ur16e": 33.1, "ur20": 64, "ur30": 63.5,
}  # fmt: skip
NONE = {"irb6640_185_280", "kr6_r700", "kr6_r900", "tm5_700", "tm5_900"}


def inertias(robot):
    return {link.name: link.inertia for link in robot.description.links if link.inertia is not None}


def test_every_named_arm_is_judged():
    assert {*STATED, *NONE} == {*arm_tables(), "panda", "fr3"}
    for name in NONE:
        assert not inertias(ulna.load(name))


@pytest.mark.parametrize("name", STATED)
def test_the_numbers_are_those_of_the_source(name):
    total, link, mass, center, (xx, xy, xz, yy, yz, zz) = STATED[name]
    found = inertias(ulna.load(name))
    assert sum(one.mass for one in found.values()) == pytest.approx(total, rel=1e-9)
    assert found[link].mass == mass
    np.testing.assert_array_equal(found[link].center, center)
    np.testing.assert_allclose(found[link].tensor, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], rtol=1e-12, atol=1e-17)


@pytest.mark.parametrize("name", WEIGHTS)
def test_an_arm_weighs_about_what_its_maker_says(name):
    assert 0.7 < sum(one.mass for one in inertias(ulna.load(name)).values()) / WEIGHTS[name] < 1.1


@pytest.mark.parametrize("name", STATED)
def test_inspect_finds_nothing_that_no_body_has(name):
    words = (
        "inertia of no real body",
        "positive definite",
        "its center of mass",
        "moments of",
        "denser",
        "in sum",
        "without the inertia",
    )
    assert not [one for one in ulna.inspect(name).findings if any(word in one.message for word in words)]


@pytest.mark.parametrize("name", sorted({*STATED} & {*arm_tables()}))
def test_the_center_of_mass_of_every_link_is_within_its_shapes(name):
    description = ulna.load(name).description
    judged = [link for link in description.links if link.collisions and link.inertia is not None]
    assert len(judged) >= 6
    for link in judged:
        low, high = Boxes(description).box_of_link(link)
        assert np.linalg.norm(link.inertia.center - np.clip(link.inertia.center, low, high)) < 0.02, link.name


@pytest.mark.parametrize("name", STATED)
def test_every_part_that_a_joint_moves_has_a_mass(name):
    robot = ulna.load(name)
    movers = {joint.child: joint.type != "fixed" for joint in robot.description.joints}
    assert {child for child, moves in movers.items() if moves} <= set(inertias(robot))


def test_the_xarm7_has_the_inertias_of_that_of_example_robot_data():
    theirs, ours = inertias(ulna.load(next(EXAMPLES.rglob("xarm7.urdf")))), inertias(ulna.load("xarm7"))
    assert set(ours) <= set(theirs)
    for name, one in ours.items():
        assert one.mass == theirs[name].mass
        np.testing.assert_array_equal(one.center, theirs[name].center)
        np.testing.assert_array_equal(one.tensor, theirs[name].tensor)


def added(parts):
    """The mass, the center and the tensor of several bodies: each a mass, a center and a tensor in the common frame."""
    mass = sum(part[0] for part in parts)
    center = sum(part[0] * part[1] for part in parts) / mass
    apart = [part[1] - center for part in parts]
    tensor = sum(part[2] + part[0] * (d @ d * np.eye(3) - np.outer(d, d)) for part, d in zip(parts, apart, strict=True))
    return mass, center, tensor


# Of the source, in the frame of the hand: mass, center and moments of the hand, of a finger in its frame, 0.0584 m along z.
HANDS = {
    "panda": (
        "panda_link8",
        -np.pi / 4,
        (0.73, (-0.01, 0, 0.03), np.diag([0.001, 0.0025, 0.0017])),
        (0.015, (0, 0, 0), np.diag([2.375e-06, 2.375e-06, 7.5e-07])),
    ),
    "fr3": (
        "fr3_hand",
        0.0,
        (0.6544, (-0.0000376, 0.0119128, 0.0207260), np.array([[0.00186, 0, 0], [0, 0.0003, -0.00002], [0, -0.00002, 0.00174]])),
        (0.0291, (0, 0.015285, 0.0219675), np.array([[8.49e-06, 0, 0], [0, 8.53e-06, -1.06e-06], [0, -1.06e-06, 1.77e-06]])),
    ),
}


@pytest.mark.parametrize("name", HANDS)
def test_the_hand_has_both_fingers_half_open(name):
    link, yaw, hand, (mass, place, moments) = HANDS[name]
    half_turn = np.diag([-1.0, -1.0, 1.0])
    left = mass, np.array([0, 0.02, 0.0584]) + place, moments
    right = mass, np.array([0, -0.02, 0.0584]) + half_turn @ place, half_turn @ moments @ half_turn
    total, center, tensor = added([(hand[0], np.array(hand[1]), hand[2]), left, right])
    R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    found = inertias(ulna.load(name))[link]
    assert found.mass == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(found.center, R @ center, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.tensor, R @ tensor @ R.T, rtol=0, atol=1e-12)


def test_the_page_of_robots_says_what_each_arm_weighs():
    page = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
    for name, arm in arm_tables().items():
        total = sum(one.mass for one in inertias(ulna.load(name)).values())
        (row,) = (line for line in page.splitlines() if line.startswith(f"| `{name}` |") and arm.model in line)
        assert row.split(" | ")[5] == (f"{total:.1f}" if total else "none")
        assert not arm.inertias_from or f"| `{name}` | {arm.inertias_from} |" in page
