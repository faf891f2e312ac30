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

INTRODUCTION = """# Tested robots

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

## Not loaded

| file | reason |
|---|---|
"""

COLLECTIONS = """
## Collections

`benchmarks/urdf_files.py FOLDER` reads every URDF below a folder with Ulna and with Pinocchio (urdfdom), and compares the poses
of all links at 20 random configurations. Read once for this page, at these versions:

| collection | URDFs | read by both | by Ulna alone | by Pinocchio alone | largest difference |
|---|---:|---:|---:|---:|---:|
| [urdf_files_dataset](https://github.com/Daniella1/urdf_files_dataset), commit 81f4cdac | 320 | 306 | 4 | 1 | 3.4e-15 |
| data of PyBullet 3.2.7, without `random_urdfs` | 95 | 86 | 1 | 2 | 1.3e-15 |
| `random_urdfs` of PyBullet 3.2.7 | 1000 | 1000 | 0 | 0 | 0 |

Refused although Pinocchio reads them, since poses or limits would be guessed:

| file | reason |
|---|---|
| `pioneer-lx-devil.urdf`, `cube_no_rotation.urdf` (PyBullet) | a lower limit is above the upper one: Bullet takes it for none |
| `spirit40newer.urdf` (PyBullet) | a joint has two `axis` |

Refused by both: files without links or with several roots (`test_bench`, `imu_test`, `spot_arm`, two grippers of Rethink,
`torus_deform`), a name used twice (`r2_left_gripper`), a prismatic joint without limits (`pr2_simplified`), commas or four
numbers in an origin (`bike`, `microtaur`), two documents in one (`humanoid`), a spherical joint (`spherical_joint_limit`),
crossed limits (`biped2d_pybullet`).
"""


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
            tables.append(f"## {title}\n\n{HEADER}")
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
    page = head + "".join(tables).rstrip() + "\n" + notes + "".join(refused) + COLLECTIONS
    (HERE.parent / "docs" / "robots.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
