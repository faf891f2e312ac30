"""Every SRDF of example-robot-data: read, held against its robot, and its named configurations compared with Pinocchio's."""

import pickle
import warnings

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import Peer
from robot_files import CHOSEN_SRDFS, example_srdfs, of_kinds
from ulna import DescriptionWarning, UlnaError
from ulna.description.document import Document
from ulna.description.srdf import read_srdf

FILES = example_srdfs()
WITHOUT_A_ROBOT = {"cassie_v2"}  # only an SDF lies beside it
# Which of a folder's URDFs an SRDF is for, where its name does not say so. The robot of alex_psyonic_hands cannot be loaded.
URDF_OF = {
    "alex_psyonic_hands": "alex_sake_hands",
    "alexander": "alexander_v1.lowerBodyOnly",
    "baxter_manipulation": "baxter",
    "hyq": "hyq_no_sensors",
    "pr2_manipulation": "pr2",
    "romeo_moveit": "romeo",
    "talos": "talos_full_v2",
    "ur5": "ur5_robot",
}


def urdf_of(file):
    stem = URDF_OF.get(file.stem, file.stem)
    (urdf,) = file.parents[1].rglob(f"{stem}.urdf")
    return urdf


def loaded(file):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)
        return ulna.load(urdf_of(file), srdf=file)


@pytest.fixture(
    scope="module",
    params=of_kinds([f for f in FILES if f.stem not in WITHOUT_A_ROBOT], CHOSEN_SRDFS),
    ids=lambda f: f"{f.parts[-3]}-{f.stem}",
)
def file(request):
    return request.param


def test_all_are_there():
    assert len(FILES) == 38
    assert {file for file in FILES if not file.is_file()} == set()


@pytest.mark.parametrize("path", FILES, ids=lambda f: f"{f.parts[-3]}-{f.stem}")
def test_each_is_read(path):
    srdf = read_srdf(Document(path.read_bytes(), path.name))
    assert srdf.groups or srdf.disabled_collisions


def test_each_goes_with_its_robot_and_names_only_what_the_robot_has(file):
    robot = loaded(file)
    links, joints = set(robot.link_names), {joint.name for joint in robot.description.joints}
    for pair in robot.srdf.disabled_collisions:
        assert {pair.link_a, pair.link_b} <= links
    for group in robot.groups.values():
        assert set(group.link_names) <= links
        assert set(group.joint_names) <= joints
        assert [robot.joint_names[k] for k in range(len(robot.joint_names)) if k in group.columns] == list(group.joint_names)
    raw = read_srdf(Document(file.read_bytes(), file.name))
    lost = len(raw.disabled_collisions) - len(robot.srdf.disabled_collisions)
    assert lost <= sum("disabled collision" in sentence for sentence in robot.srdf.warnings)
    assert pickle.loads(pickle.dumps(robot)).srdf == robot.srdf  # noqa: S301


def test_its_states_are_the_reference_configurations_of_pinocchio(file):
    robot = loaded(file)
    model = pin.buildModelFromUrdf(str(urdf_of(file)))
    pin.loadReferenceConfigurations(model, str(file), False)
    peer = Peer(robot, model)
    for state in robot.srdf.states:
        reference = model.referenceConfigurations[state.name]
        ours = peer.configuration(robot.named_configurations[state.key])
        for name, _ in state.values:
            if name in robot.joint_names:
                joint = model.joints[model.getJointId(name)]
                entries = slice(joint.idx_q, joint.idx_q + joint.nq)
                np.testing.assert_allclose(ours[entries], reference[entries], atol=1e-12, err_msg=f"{state.key}: {name}")


def test_a_robot_is_not_lost_on_an_srdf_of_another(tmp_path):
    a1, panda = (next(f for f in FILES if f.stem == name) for name in ("a1", "panda"))
    with pytest.warns(
        DescriptionWarning, match=r"^a1\.srdf:\d+: .* is not defined.*\(\d+ such sentences: robot.srdf.warnings\)$"
    ):
        robot = ulna.load(urdf_of(panda), srdf=a1)
    assert robot.srdf.disabled_collisions == ()
    with pytest.raises(UlnaError, match="defines a link: this is a URDF, where an SRDF is expected"):
        ulna.load(urdf_of(panda), srdf=urdf_of(panda))
