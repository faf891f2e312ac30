"""Writes docs/robots.md: every robot of example-robot-data and rtb-data, how far it is from Pinocchio, how long it takes to load.

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

## Arms by name

These are in Ulna itself: `ulna.load("ur10e")`, `ulna view ur10e`, `ulna list`. The Panda and the FR3 are too.

![Every arm that is bundled, with its name](pictures/arms.png)

| name | also | arm | payload [kg] | reach [m] | closed form of all solutions |
|---|---|---|---:|---:|---|
"""
SOURCES = """
Payload and reach are those of the makers' data sheets. Kinematics, positions, velocities and efforts are from these public
descriptions, as numbers in tables of our own (`src/ulna/description/names/arms`): no file or mesh of theirs is here.
`plan.trajectory(limits="ur10e")` takes the velocities and, where one is stated, the acceleration.

| arm | source, commit | licence | files |
|---|---|---|---|
"""
NOT_SAID = """
- Angles of a source that are right angles but for rounding (1.5708) are right angles here, so closed forms are exact.
- **Accelerations** are stated for four arms only. The UR5e's (180 deg/s^2), the xArm 7's (20 rad/s^2), the Gen3s' (8.6 rad/s^2)
  are those of MoveIt's configurations, chosen by their authors. Those of ABB's MoveIt packages are a fifth of the velocities,
  and are not taken. Of other arms, give `acceleration=`.
- The elbow of a UR has 180 degrees to each side, as in the source: the joint itself turns further. The frames are those of ROS.
  The base on the pendant is turned by half a turn about z.
- The xArms' velocities (2.14 rad/s) are those of MoveIt's configuration. The URDF has 3.14 rad/s.
- The M1013's limits are those of its MoveIt configuration. Its URDF has the same ones for every joint.
- A gripper is no part of an arm here. The ViperX's is, but its fingers do not move: the shapes contain them open and closed.

**Collision shapes** are boxes, capsules and cylinders of our own, not the makers'. They were computed once from the meshes of the
same sources and compared with these triangle by triangle, outside of this repository, which has no mesh; no test repeats it:

| arms | contained | by at least |
|---|---|---|
| IRB 6640 | visual meshes, of `link_1` the collision mesh; all places of the balancing cylinder, which is no joint here | 1 mm |
| TM5 | collision meshes, as some visual meshes could not be had | 0 mm |
| UR20, UR30 | visual meshes; of other terms, so no shape was fitted to them: whole centimetres were chosen, and checked | 5 mm |
| all others | visual meshes | 0.5 mm |

The lowest 2 mm of a base are left out, so that a floor at z = 0 does not touch it. A shape is larger than its link. So the shapes
of two links with one link between them may touch where the links do not. If their meshes touched in none of 10,000 random
configurations, and the shapes did, the pair is allowed: `robot.allowed_collisions` has these pairs with the reason `Never`.
Cables, hoses and a tool are not in the shapes.

Every arm is tested: its poses against the DH tables and dimensions that its maker states, its home against itself and a floor,
inverse kinematics and a plan round a post (`tests/description/test_arm_tables.py`).

"""
INTRODUCTION = """## Tested files

Every URDF of the package example-robot-data and every xacro robot of rtb-data, read by Ulna and compared with Pinocchio
{pinocchio}. The columns *pose* and *Jacobian* give the largest difference in any entry of the pose of any link [m or 1],
and of the Jacobian of any tip in any of the three frames, over 100 random configurations. `tests/crosscheck` asserts that each is
below 1e-9. *dof* counts the independent joints, without those that mimic another. `benchmarks/robots_table.py` writes this page.

*load* is the time of `ulna.load(file)`, the shortest of five, on the machine that wrote the page: use it to compare the robots
with each other. For a xacro file it includes the start of the process that expands it. The largest, `{largest}` with {links}
links, takes {milliseconds:.0f} ms.

"""
HEADER = """| robot | links | dof | pose | Jacobian | load [ms] |
|---|---:|---:|---:|---:|---:|
"""
NOTES = """
Pinocchio's mimic option refuses `{}` ("The parent joint of the mimic joint is not in the
kinematic tree"). For these robots it was built without that option, and the test computed the mimicking joints; the slow
reference of the tests agrees too.

### Not loaded

| file | reason |
|---|---|
"""

COLLECTIONS = """
### Collections

`benchmarks/urdf_files.py FOLDER` reads every URDF below a folder with Ulna and with Pinocchio (urdfdom), and compares the poses
of all links at 20 random configurations. Drake's `<frame>` is a link here, which Pinocchio does not have. Read once for this
page, at these versions:

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

Refused although Pinocchio reads them, since poses or limits would be guessed:

| file | reason |
|---|---|
| `pioneer-lx-devil.urdf`, `cube_no_rotation.urdf` (PyBullet) | a lower limit is above the upper one: Bullet takes it for none |
| `spirit40newer.urdf` (PyBullet) | a joint has two `axis` |

Refused by both: files without links or with several roots (`test_bench`, `imu_test`, `spot_arm`, two grippers of Rethink,
`torus_deform`), a name used twice (`r2_left_gripper`), a prismatic joint without limits (`pr2_simplified`), commas or four
numbers in an origin (`bike`, `microtaur`), two documents in one (`humanoid`), a spherical joint (`spherical_joint_limit`),
crossed limits (`biped2d_pybullet`), an end tag that is missing (Klampt's `human_hand`). Drake's own parser takes more than ROS's:
revolute joints without limits (`cassie_v2`, `acrobot`, `kuka_iiwa_robot`, `arm`, `joint_parsing_test`), a link `world` that is
not in the file (`Acrobot`, `Acrobot_unicode`). Files of its tests have several roots (6), a ball joint, and no XML at all.

### Models of MuJoCo

`benchmarks/mjcf_files.py FOLDER` compares each MJCF model below a folder with MuJoCo's own compiled model (4.0.0): poses of all
bodies and geoms at 20 random configurations to 1e-12, types and limits of joints, and all shapes. What is not equal is refused by
name. Read once for this page:

| collection | models | equal | refused | not compiled by MuJoCo | largest difference |
|---|---:|---:|---:|---:|---:|
| [MuJoCo Menagerie](https://github.com/google-deepmind/mujoco_menagerie), commit 75df466b | 198 | 167 | 29 | 2 | 5.7e-15 |
| dm_control 1.0.50 | 63 | 53 | 6 | 4 | 8.3e-15 |
| robosuite 1.5.2 | 56 | 51 | 4 | 1 | 6.6e-15 |
| gymnasium-robotics 1.4.2 | 37 | 17 | 16 | 4 | 5.2e-15 |
| dm-robotics-panda 0.4.8 | 2 | 2 | 0 | 0 | 4.9e-15 |

Refused are equalities that close loops (in grippers such as the Robotiq 2F-85 and that of the xArm 7, in Cassie, Fetch and
ToddlerBot), tendons that hold joints (the hands of Shadow and Aero, `fish`, `ball_in_cup`) and a ball joint. Where a mesh or a
texture was absent or larger than 4 MB, 46 models of the first row and 7 of the others were read without these. The poses are
those of the model's own numbers: MuJoCo by itself takes a geom within 1e-6 of its body's frame or center of mass to be there.
"""


def named_arms() -> str:
    """The arms that have tables: what they are, where the figures are from, and what the shapes contain."""
    arms, page = arm_tables().values(), ARMS
    for arm in arms:
        form = ulna.load(arm.name).closed_form
        exact = "none" if form is None else ("exact" if form.is_exact else "near") + (", one joint held" if form.held else "")
        also = ", ".join(f"`{name}`" for name in arm.also)
        page += f"| `{arm.name}` | {also} | {arm.maker} {arm.model} | {arm.payload:g} | {arm.reach:g} | {exact} |\n"
    page += SOURCES
    for arm in arms:
        repository, commit = arm.source.split(" at ")
        page += f"| `{arm.name}` | [{repository}](https://github.com/{repository}), {commit} | {arm.licence} | {arm.files} |\n"
    return page + NOT_SAID


def row(file: Path, package_dirs: list[Path]) -> tuple[str, ulna.Robot, float]:
    """One line of the table, the robot, and the seconds it took to load."""
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        robot = ulna.load(file, package_dirs=package_dirs)
        seconds.append(time.perf_counter() - start)
    peer = Peer(robot, pin.buildModelFromXML(robot.to_urdf(), mimic=file.stem not in DEFEAT_THE_MIMIC_OPTION))
    difference = f"{farthest_link(peer):.1e} | {farthest_jacobian(peer):.1e}"
    least = min(seconds)
    return f"| `{file.name}` | {len(robot.link_names)} | {robot.n_dof} | {difference} | {1e3 * least:.1f} |\n", robot, least


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
                    line, robot, seconds = row(file, dirs)
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
