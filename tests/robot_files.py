"""Lists the robots of the packages example-robot-data and rtb-data, with their known properties."""

import importlib.util
import sys
import warnings
from collections.abc import Collection
from pathlib import Path

import ulna
from matrix import matrix

SHARE = Path("cmeel.prefix") / "share" / "example-robot-data" / "robots"
EXAMPLES = next(Path(entry) / SHARE for entry in sys.path if (Path(entry) / SHARE).is_dir())
# For these Pinocchio's mimic option fails: a mimic stands before its leader.
DEFEAT_THE_MIMIC_OPTION = {"romeo", "talos_full_v2", "talos_full_v2_box"}

_FOUND = importlib.util.find_spec("rtbdata")
RTB = None if _FOUND is None else Path(next(iter(_FOUND.submodule_search_locations or ())))
_PARTS = ("_macro.xacro", "common_colours.xacro", "common_constants.xacro", "common_materials.xacro")

# The URDFs and SRDFs of example-robot-data, and the xacro files of rtb-data that are whole robots. They stand here because tests
# are chosen by them: to look for the files takes longer. tests/crosscheck has those that a newer version adds.
URDFS = """
a1_description/urdf/a1.urdf alex_description/urdf/alex_nub_hands.urdf alex_description/urdf/alex_psyonic_hands.urdf
alex_description/urdf/alex_sake_hands.urdf alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf
allegro_hand_description/urdf/allegro_left_hand.urdf allegro_hand_description/urdf/allegro_right_hand.urdf
anymal_b_simple_description/robots/anymal-kinova.urdf anymal_b_simple_description/robots/anymal.urdf
anymal_c_simple_description/urdf/anymal.urdf asr_twodof_description/urdf/TwoDofs.urdf b1_description/urdf/b1-z1.urdf
b1_description/urdf/b1.urdf baxter_description/urdf/baxter.urdf bolt_description/robots/bolt.urdf
borinot_description/urdf/borinot_flying_arm_2.urdf centauro_description/urdf/centauro.urdf
double_pendulum_description/urdf/double_pendulum.urdf double_pendulum_description/urdf/double_pendulum_continuous.urdf
double_pendulum_description/urdf/double_pendulum_simple.urdf finger_edu_description/robots/finger_edu.urdf
g1_description/urdf/g1_29dof_rev_1_0.urdf g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf go1_description/urdf/go1.urdf
go2_description/urdf/go2.urdf hector_description/robots/quadrotor_base.urdf
hextilt_description/urdf/hextilt_flying_arm_5.urdf human_description/robots/human.urdf
hyq_description/robots/hyq_no_sensors.urdf icub_description/robots/icub.urdf icub_description/robots/icub_reduced.urdf
iris_description/robots/iris.urdf iris_description/robots/iris_simple.urdf kinova_description/robots/kinova.urdf
laikago_description/urdf/laikago.urdf panda_description/urdf/panda.urdf panda_description/urdf/panda_collision.urdf
pr2_description/urdf/pr2.urdf quadruped_description/urdf/quadruped.urdf romeo_description/urdf/romeo.urdf
romeo_description/urdf/romeo_laas_small.urdf romeo_description/urdf/romeo_small.urdf
simple_humanoid_description/urdf/simple_humanoid.urdf simple_humanoid_description/urdf/simple_humanoid_classical.urdf
so_arm_description/urdf/so100.urdf so_arm_description/urdf/so101.urdf solo_description/robots/solo.urdf
solo_description/robots/solo12.urdf talos_data/robots/talos_full_v2.urdf talos_data/robots/talos_full_v2_box.urdf
talos_data/robots/talos_left_arm.urdf talos_data/robots/talos_reduced.urdf talos_data/robots/talos_reduced_box.urdf
talos_data/robots/talos_reduced_corrected.urdf tiago_description/robots/tiago.urdf tiago_description/robots/tiago_dual.urdf
tiago_description/robots/tiago_no_hand.urdf tiago_pro_description/robots/tiago_pro.urdf
ur_description/urdf/ur10_joint_limited_robot.urdf ur_description/urdf/ur10_robot.urdf ur_description/urdf/ur3.urdf
ur_description/urdf/ur3_gripper.urdf ur_description/urdf/ur3_joint_limited_robot.urdf ur_description/urdf/ur3_robot.urdf
ur_description/urdf/ur5_gripper.urdf ur_description/urdf/ur5_joint_limited_robot.urdf ur_description/urdf/ur5_robot.urdf
xarm_description/urdf/xarm7.urdf z1_description/urdf/z1.urdf
"""
SRDFS = """
a1_description/srdf/a1.srdf alex_description/srdf/alex_nub_hands.srdf alex_description/srdf/alex_psyonic_hands.srdf
alex_description/srdf/alex_sake_hands.srdf alexander_description/srdf/alexander.srdf
anymal_b_simple_description/srdf/anymal-kinova.srdf anymal_b_simple_description/srdf/anymal.srdf
anymal_c_simple_description/srdf/anymal.srdf b1_description/srdf/b1-z1.srdf b1_description/srdf/b1.srdf
baxter_description/srdf/baxter_manipulation.srdf bolt_description/srdf/bolt.srdf
borinot_description/srdf/borinot_flying_arm_2.srdf cassie_description/srdf/cassie_v2.srdf
centauro_description/srdf/centauro.srdf finger_edu_description/srdf/finger_edu.srdf go1_description/srdf/go1.srdf
go2_description/srdf/go2.srdf hextilt_description/srdf/hextilt_flying_arm_5.srdf hyq_description/srdf/hyq.srdf
icub_description/srdf/icub.srdf kinova_description/srdf/kinova.srdf panda_description/srdf/panda.srdf
pr2_description/srdf/pr2.srdf pr2_description/srdf/pr2_manipulation.srdf romeo_description/srdf/romeo.srdf
romeo_description/srdf/romeo_moveit.srdf romeo_description/srdf/romeo_small.srdf
simple_humanoid_description/srdf/simple_humanoid.srdf simple_humanoid_description/srdf/simple_humanoid_classical.srdf
solo_description/srdf/solo.srdf talos_data/srdf/talos.srdf ur_description/srdf/ur3_gripper.srdf ur_description/srdf/ur5.srdf
ur_description/srdf/ur5_gripper.srdf ur_description/srdf/ur5_joint_limited_robot.srdf xarm_description/srdf/xarm7.srdf
z1_description/srdf/z1.srdf
"""
XACROS = """
armer_xarm/data/xacro/robots/xarm6/xarm6.xacro xacro/abb_irb140_description/urdf/irb140.xacro
xacro/clearpath_ridgeback_description/urdf/ridgeback.urdf.xacro xacro/kuka_description/kuka_kr10/urdf/kr10r1100sixx.xacro
xacro/kuka_description/kuka_kr120/urdf/kr120r2500pro.xacro xacro/kuka_description/kuka_kr150/urdf/kr150_2.xacro
xacro/kuka_description/kuka_kr16/urdf/kr16_2.xacro xacro/kuka_description/kuka_kr210/urdf/kr210l150.xacro
xacro/kuka_description/kuka_kr3/urdf/kr3r540.xacro xacro/kuka_description/kuka_kr5/urdf/kr5_arc.xacro
xacro/kuka_description/kuka_kr6/urdf/kr6r700sixx.xacro xacro/kuka_description/kuka_kr6/urdf/kr6r900sixx.xacro
xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.xacro
xacro/qut_frankie_description/robots/dual_panda_example.urdf.xacro
xacro/qut_frankie_description/robots/frankieOmni_arm.urdf.xacro xacro/qut_frankie_description/robots/frankieOmni_arm.xacro
xacro/qut_frankie_description/robots/frankieOmni_arm_hand.urdf.xacro
xacro/qut_frankie_description/robots/frankie_arm.urdf.xacro xacro/qut_frankie_description/robots/frankie_arm.xacro
xacro/qut_frankie_description/robots/frankie_arm_hand.urdf.xacro xacro/qut_frankie_description/robots/hand.urdf.xacro
xacro/qut_frankie_description/robots/hand.xacro xacro/qut_frankie_description/robots/panda_arm.urdf.xacro
xacro/qut_frankie_description/robots/panda_arm.xacro xacro/qut_frankie_description/robots/panda_arm_hand.urdf.xacro
xacro/trossen_descriptions/urdf/px100.urdf.xacro xacro/trossen_descriptions/urdf/px150.urdf.xacro
xacro/trossen_descriptions/urdf/pxxls.urdf.xacro xacro/trossen_descriptions/urdf/rx150.urdf.xacro
xacro/trossen_descriptions/urdf/rx200.urdf.xacro xacro/trossen_descriptions/urdf/vx250.urdf.xacro
xacro/trossen_descriptions/urdf/vx300.urdf.xacro xacro/trossen_descriptions/urdf/vx300s.urdf.xacro
xacro/trossen_descriptions/urdf/vxxmd.urdf.xacro xacro/trossen_descriptions/urdf/vxxms.urdf.xacro
xacro/trossen_descriptions/urdf/wx200.urdf.xacro xacro/trossen_descriptions/urdf/wx250.urdf.xacro
xacro/trossen_descriptions/urdf/wx250s.urdf.xacro xacro/trossen_descriptions/urdf/wxxmd.urdf.xacro
xacro/trossen_descriptions/urdf/wxxms.urdf.xacro xacro/unimation_puma560_description/urdf/puma560_robot.urdf.xacro
"""
# An arm, an arm with a gripper that mimics, a robot on legs, a hand, a humanoid; and of the others.
CHOSEN = {"ur5_robot", "panda", "a1", "allegro_left_hand", "talos_reduced"}
CHOSEN_SRDFS = {"ur5", "panda", "pr2_manipulation", "talos", "baxter_manipulation"}
CHOSEN_XACROS = {"lbr_iiwa_14_r820", "puma560_robot.urdf", "irb140", "kr5_arc", "xarm6"}


def example_urdfs() -> list[Path]:
    return [EXAMPLES / name for name in URDFS.split()]


def example_srdfs() -> list[Path]:
    return [EXAMPLES / name for name in SRDFS.split()]


def of_kinds(files: list[Path], chosen: Collection[str] = CHOSEN) -> list:
    """The files as parameters of a test, of which ``make test`` takes the chosen ones."""
    return matrix(files, [file for file in files if file.stem in chosen])


def load_baxter() -> ulna.Robot:
    """Baxter with the convex hulls of its meshes and the pairs of its SRDF, which names links that it has not."""
    (srdf,) = (file for file in example_srdfs() if file.stem == "baxter_manipulation")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ulna.DescriptionWarning)
        return ulna.load("baxter", srdf=srdf).with_convex_hulls()


def rtb_xacros() -> list[Path]:
    """The xacro files of rtb-data that are whole robots."""
    return [] if RTB is None else [RTB / name for name in XACROS.split()]


def installed(root: Path, suffix: str) -> set[str]:
    """The files below a folder, relative to it, without the parts of which xacro files are made."""
    files = (file for file in root.rglob(f"*{suffix}") if not file.name.endswith(_PARTS) and "accessories" not in file.parts)
    return {file.relative_to(root).as_posix() for file in files}


def rtb_package_dirs(links: Path) -> list[Path]:
    """Where the packages of these lie. Some are in folders of other names: for those a folder of links is filled."""
    assert RTB is not None
    for folder in (RTB / "xacro" / "kuka_description").glob("kuka_*"):
        (links / f"{folder.name}_support").symlink_to(folder)
    (links / "abb_irb140").symlink_to(RTB / "xacro" / "abb_irb140_description")
    return [links, RTB / "xacro", RTB / "xacro" / "kuka_description"]
