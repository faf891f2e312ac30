"""Writes docs/robots.md: every robot of example-robot-data and rtb-data, its difference from Pinocchio, its loading time.

python benchmarks/robots_table.py
"""

import sys
import tempfile
import time
from pathlib import Path

import pinocchio as pin

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

import ulna  # noqa: E402
from pinocchio_peer import Peer, farthest_jacobian, farthest_link  # noqa: E402
from robot_files import DEFEAT_THE_MIMIC_OPTION, RTB, example_urdfs, rtb_package_dirs, rtb_xacros  # noqa: E402
from ulna.description.names.arm_tables import arm_tables  # noqa: E402

ARMS = """# Robots

*Reference*

This page lists the arms that come with Ulna, with their sources, and the robots whose kinematics were compared with Pinocchio
and MuJoCo.

## Arms by name

24 arms come with Ulna: the Panda (`panda`), the FR3 (`fr3`) and the 22 arms of this table. `ulna.load("ur10e")` loads one,
`ulna view ur10e` shows it, and `ulna list` prints the names.

![Every arm that is bundled, with its name](pictures/arms.png)

| name | also | arm | payload [kg] | reach [m] | mass of its links [kg] | closed form of all solutions |
|---|---|---|---:|---:|---:|---|
"""
INERTIAS = """
The last column says whether inverse kinematics has a [closed form](closed-forms.md):

- *exact*: formulas compute all solutions, with proof.
- *near*: the axes deviate slightly from a closed form. Its solutions are starts of a search, and nothing is proved.
- *one joint held*: the arm has seven joints, and the form holds when one of them is fixed.
- *none*: a numeric search finds the solutions.

Payload and reach are the nominal values that the makers advertise. Ulna computes nothing from them. Kinematics, joint ranges,
velocities and efforts are numbers from the public descriptions below, in tables of Ulna (`src/ulna/description/names/arms`).
The repository contains no file and no mesh of these descriptions.

`plan.trajectory(limits="ur10e")` uses the velocities of these tables and, if they are known, the accelerations. Use it for a
robot that you load from another description of the same arm, such as your own URDF.

**Inertias** are published values in the axes of the links, without rotors.

- The Panda's were identified by Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca ("Dynamic Identification of the Franka Emika
  Panda Robot with Retrieval of Feasible Parameters Using Penalty-Based Optimization", IEEE RA-L 4(4), 2019).
  [frankaemika/franka_ros](https://github.com/frankaemika/franka_ros) at c11f000c has them, with those of the hand.
- The FR3's are from [frankarobotics/franka_description](https://github.com/frankarobotics/franka_description) at 566ba44a.
- Five arms have none. The descriptions of the IRB 6640 and of both KR 6 state none. Both TM5 put the center of mass of each
  link at the origin of its frame, even where the origin is outside of the link.
- The inertias of these arms are from another source than the table below, or Ulna rotated or added them:

| arm | inertias |
|---|---|
"""
SOURCES = """
Kinematics and limits are from these sources:

| arm | source, commit | license | files |
|---|---|---|---|
"""
NOT_SAID = """
- **Right angles.** Where a source rounds a right angle (1.5708), the table has the exact right angle. So closed forms are
  exact.
- **Accelerations** are stated for four arms only. The UR5e's (180 deg/s^2), the xArm 7's (20 rad/s^2) and the Gen3s' (8.6
  rad/s^2) are the values of MoveIt's configurations, chosen by their authors. ABB's MoveIt packages use a fifth of the
  velocities as accelerations; Ulna does not take them. For the other arms pass `acceleration=`.
- **Universal Robots**: the elbow turns 180 degrees to each side, as in the source, although the joint itself turns further. The
  frames are those of ROS. The base frame of the pendant is rotated by half a turn about z.
- **xArm**: the velocities (2.14 rad/s) are from MoveIt's configuration. The URDF has 3.14 rad/s.
- **M1013**: the limits are from its MoveIt configuration. Its URDF has the same limits for every joint.
- **Grippers** are not included, except the ViperX's. Its fingers do not move; the shapes contain them open and closed.

**Collision shapes** are boxes, capsules and cylinders made for Ulna, not the makers' shapes. They were computed once from the
meshes of the same sources. Each was checked to contain its mesh, triangle by triangle, outside of this repository, which has no
mesh. No test repeats this check:

| arms | the shapes contain | by at least |
|---|---|---|
| IRB 6640 | the visual meshes, for `link_1` the collision mesh; all positions of the balancing cylinder (no joint here) | 1 mm |
| TM5 | the collision meshes, since some visual meshes were not available | 0 mm |
| UR20, UR30 | the visual meshes, checked but not fitted (see below) | 5 mm |
| all others | the visual meshes | 0.5 mm |

- The meshes of the UR20 and the UR30 have another license, so no shapes were fitted to them. Dimensions in whole centimeters were
  chosen, and checked against the meshes.
- The lowest 2 mm of a base are left out, so that a floor at z = 0 does not touch it.
- A shape is larger than its link. So the shapes of two links with one link between them may touch where the links do not. Such
  a pair is allowed, and therefore not checked, if the shapes touched in some of 10,000 random configurations and the meshes in
  none. `robot.allowed_collisions` lists these pairs with the reason `never`, as an SRDF does for pairs that never touch.
- Cables, hoses and tools are not part of the shapes.

`tests/description/test_arm_tables.py` tests every arm. It compares poses with the DH tables and dimensions of the maker. It
checks the home configuration against the arm itself and a floor, solves inverse kinematics, and plans a path around a post.

"""
INTRODUCTION = """## Tested files

Ulna reads the URDFs of the package example-robot-data and the xacro robots of rtb-data, except for [three
files](#not-loaded). The kinematics is compared with Pinocchio
{pinocchio}. The columns *pose* and *Jacobian* give the largest difference over 100 random configurations. *pose* covers every
entry of the pose of every link [m or 1]. *Jacobian* covers every entry of the Jacobian of every tip in the three frames.
`tests/crosscheck` asserts that each is below 1e-9. *dof* counts the independent joints, without mimic joints.
`benchmarks/robots_table.py` writes this page.

*load* is the shortest time of five calls of `ulna.load(file)` on one machine. Use it to compare the robots with each other. For
a xacro file it includes the start of the process that expands the file. The largest file, `{largest}` with {links} links, takes
{milliseconds:.0f} ms.

"""
HEADER = """| robot | links | dof | pose | Jacobian | load [ms] |
|---|---:|---:|---:|---:|---:|
"""
NOTES = """
Of the robots of example-robot-data, Pinocchio's mimic option refuses `{}`
("The parent joint of the mimic joint is not in the kinematic tree"). For these robots Pinocchio's model was built without the
option, and the test computed the mimic joints. The slow reference implementation of the tests agrees too.

### Not loaded

| file | reason |
|---|---|
"""

COLLECTIONS = """
### Collections

`benchmarks/urdf_files.py FOLDER` reads every URDF below a folder with Ulna and with Pinocchio (urdfdom), and compares the poses
of all links at 20 random configurations. Ulna reads Drake's `<frame>` as a link; Pinocchio does not have it. "By Ulna alone"
counts the files that Ulna reads and Pinocchio refuses, "by Pinocchio alone" the opposite. The remaining files of a collection are
read by neither. The largest difference is of any entry of a pose, in meters for positions. The figures are of these versions:

| collection | URDFs | read by both | by Ulna alone | by Pinocchio alone | largest difference |
|---|---:|---:|---:|---:|---:|
| [urdf_files_dataset](https://github.com/Daniella1/urdf_files_dataset), commit 81f4cdac | 320 | 306 | 4 | 1 | 3.4e-15 |
| data of PyBullet 3.2.7, without `random_urdfs` | 95 | 86 | 1 | 2 | 1.3e-15 |
| `random_urdfs` of PyBullet 3.2.7 | 1000 | 1000 | 0 | 0 | 0 |
| [Klampt-examples](https://github.com/krishauser/Klampt-examples), commit 473dabbd | 11 | 10 | 0 | 0 | 1.8e-15 |
| [drake](https://github.com/RobotLocomotion/drake), commit be259df7 | 47 | 30 | 2 | 0 | 7.8e-16 |
| [models of Drake](https://github.com/RobotLocomotion/models), commit 4723170e | 34 | 33 | 0 | 0 | 1.0e-15 |
| [onshape-to-robot-examples](https://github.com/Rhoban/onshape-to-robot-examples), commit a0f8b921 | 15 | 15 | 0 | 0 | 1.8e-15 |
| [onshape-to-robot](https://github.com/Rhoban/onshape-to-robot), commit 980a3b97 | 1 | 1 | 0 | 0 | 0 |

Ulna refuses these files, which Pinocchio reads, since poses or limits would be guessed:

| file | reason |
|---|---|
| `pioneer-lx-devil.urdf`, `cube_no_rotation.urdf` (PyBullet) | a lower limit above the upper; for Bullet this is no limit |
| `spirit40newer.urdf` (PyBullet) | a joint has two `axis` elements |

Both refuse:

| cause | files |
|---|---|
| no links, or several roots | `test_bench`, `imu_test`, `spot_arm`, two Rethink grippers, `torus_deform`; 6 Drake tests |
| a name used twice | `r2_left_gripper` |
| a prismatic joint without limits | `pr2_simplified` |
| commas or four numbers in an origin | `bike`, `microtaur` |
| two documents in one | `humanoid` |
| a spherical joint or a ball joint | `spherical_joint_limit`; one Drake test |
| a lower limit above the upper limit | `biped2d_pybullet` |
| a missing end tag | Klampt's `human_hand` |
| no XML | one Drake test |
| revolute joints without limits (Drake reads them) | `cassie_v2`, `acrobot`, `kuka_iiwa_robot`, `arm`, `joint_parsing_test` |
| a link `world` that is not defined (Drake reads it) | `Acrobot`, `Acrobot_unicode` |

### Models of MuJoCo

`benchmarks/mjcf_files.py FOLDER` compares each MJCF model below a folder with MuJoCo's own compiled model (4.0.0). It compares
the poses of all bodies and geoms at 20 random configurations to 1e-12, types and limits of joints, and all shapes. A model is
equal, or Ulna refuses it by name. The figures are of these versions:

| collection | models | equal | refused | not compiled by MuJoCo | largest difference |
|---|---:|---:|---:|---:|---:|
| [MuJoCo Menagerie](https://github.com/google-deepmind/mujoco_menagerie), commit 75df466b | 198 | 167 | 29 | 2 | 5.7e-15 |
| dm_control 1.0.50 | 63 | 53 | 6 | 4 | 8.3e-15 |
| robosuite 1.5.2 | 56 | 51 | 4 | 1 | 6.6e-15 |
| gymnasium-robotics 1.4.2 | 37 | 17 | 16 | 4 | 5.2e-15 |
| dm-robotics-panda 0.4.8 | 2 | 2 | 0 | 0 | 4.9e-15 |

Ulna refuses:

- equalities that close loops: in grippers such as the Robotiq 2F-85 and the xArm 7's, in Cassie, Fetch and ToddlerBot;
- tendons that hold joints: the hands of Shadow and Aero, `fish`, `ball_in_cup`;
- a ball joint.

In 46 models of the first row and 7 of the others a mesh or a texture was missing or larger than 4 MB; they were read without
it. The poses are computed from the numbers in the model. MuJoCo itself rounds the frame of a
geom: if the frame is within 1e-6 of the body's frame, MuJoCo takes the body's frame instead. It does the same with the frame at
the body's center of mass. So MuJoCo's pose of such a geom may differ from Ulna's by up to 1e-6.
"""


def named_arms() -> str:
    """The arms of the tables: makers and models, sources of the figures, and contents of the shapes."""
    arms, page = arm_tables().values(), ARMS
    for arm in arms:
        robot = ulna.load(arm.name)
        form, mass = robot.closed_form, sum(link.inertia.mass for link in robot.description.links if link.inertia is not None)
        exact = "none" if form is None else ("exact" if form.is_exact else "near") + (", one joint held" if form.held else "")
        also = ", ".join(f"`{name}`" for name in arm.also)
        page += f"| `{arm.name}` | {also} | {arm.maker} {arm.model} | {arm.payload:g} | {arm.reach:g} | "
        page += f"{f'{mass:.1f}' if mass else 'none'} | {exact} |\n"
    page += INERTIAS
    page += "".join(f"| `{arm.name}` | {arm.inertias_from} |\n" for arm in arms if arm.inertias_from)
    page += SOURCES
    for arm in arms:
        repository, commit = arm.source.split(" at ")
        page += f"| `{arm.name}` | [{repository}](https://github.com/{repository}), {commit} | {arm.license} | {arm.files} |\n"
    return page + NOT_SAID


def name_among(files: list[Path], file: Path) -> str:
    """The name of a file in the table, with its package if another file has the same name."""
    is_alone = sum(other.name == file.name for other in files) == 1
    return f"`{file.name}`" if is_alone else f"`{file.name}` (`{file.parents[1].name}`)"


def row(name: str, file: Path, package_dirs: list[Path]) -> tuple[str, ulna.Robot, float]:
    """One line of the table, the robot, and its loading time [s]."""
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        robot = ulna.load(file, package_dirs=package_dirs)
        seconds.append(time.perf_counter() - start)
    peer = Peer(robot, pin.buildModelFromXML(robot.to_urdf(), mimic=file.stem not in DEFEAT_THE_MIMIC_OPTION))
    difference = f"{farthest_link(peer):.1e} | {farthest_jacobian(peer):.1e}"
    least = min(seconds)
    return f"| {name} | {len(robot.link_names)} | {robot.n_dof} | {difference} | {1e3 * least:.1f} |\n", robot, least


def main() -> None:
    """Load, compare, write."""
    tables, refused, largest = [], [], (0, "", 0.0)
    with tempfile.TemporaryDirectory() as links:
        for title, files, dirs in (
            ("example-robot-data", example_urdfs(), []),
            ("rtb-data", rtb_xacros(), [] if RTB is None else rtb_package_dirs(Path(links))),
        ):
            tables.append(f"### {title}\n\n{HEADER}")
            for file in files:
                try:
                    line, robot, seconds = row(name_among(files, file), file, dirs)
                except ulna.UlnaError as error:
                    refused.append(f"| `{file.name}` | {error} |\n")
                    continue
                tables.append(line)
                largest = max(largest, (len(robot.link_names), file.name, seconds))
                sys.stdout.write(line)
            tables.append("\n")
    links_of_largest, name, seconds = largest
    head = INTRODUCTION.format(pinocchio=pin.__version__, largest=name, links=links_of_largest, milliseconds=1e3 * seconds)
    notes = NOTES.format("`, `".join(sorted(DEFEAT_THE_MIMIC_OPTION)))
    page = named_arms() + head + "".join(tables).rstrip() + "\n" + notes + "".join(refused) + COLLECTIONS
    (HERE.parent / "docs" / "robots.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
