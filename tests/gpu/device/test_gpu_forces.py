"""The forces of ``robot.on_gpu()`` against those of the robot on the CPU: on a GPU, or with simulated threads."""

import os

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import ulna
from ulna.errors import InputError, SingularityError

N = 5 if os.environ.get("NUMBA_ENABLE_CUDASIM") == "1" else 20_000
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)


@pytest.fixture(scope="module", params=["panda", "with a payload on a wall", "scara", "in float32"])
def arm(request):
    """A robot and itself on the device."""
    robot = ulna.load(SCARA if request.param == "scara" else "panda")
    if request.param == "with a payload on a wall":
        robot = robot.with_attached("part", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0, 0, 0.1)), mass=2.0)
        robot = robot.with_gravity((0.0, 9.81, 0.0))
    return robot, robot.on_gpu(float32=request.param == "in float32")


@pytest.fixture
def motion(arm):
    rng = np.random.default_rng(5)
    n = arm[0].n_dof
    return rng.uniform(arm[0].lower, arm[0].upper, (N, n)), rng.normal(size=(N, n)), rng.normal(size=(N, n))


CALLS = {
    "inverse_dynamics": 3,
    "gravity_torque": 1,
    "mass_matrix": 1,
    "forward_dynamics": 3,
    "inverse_dynamics_derivatives": 3,
}


@pytest.mark.parametrize("name", CALLS)
def test_forces_are_those_of_the_cpu(arm, motion, name):
    robot, on_gpu = arm
    given = motion[: CALLS[name]]
    expected = np.stack(getattr(robot, name)(*given))
    most = np.abs(expected).max()
    np.testing.assert_allclose(np.stack(getattr(on_gpu, name)(*given)), expected, rtol=0, atol=1e-12 * most)
    one = np.stack(getattr(on_gpu, name)(*(each[0] for each in given)))
    np.testing.assert_allclose(one, np.stack(getattr(robot, name)(*(each[0] for each in given))), rtol=0, atol=1e-12 * most)
    there = getattr(on_gpu, name)(*map(cuda.to_device, given))
    there = np.stack([each.copy_to_host() for each in (there if isinstance(there, tuple) else (there,))])
    np.testing.assert_allclose(there.reshape(expected.shape), expected, rtol=0, atol=1e-12 * most)


def test_batches_are_broadcast_and_gravity_is_the_callers(arm, motion):
    robot, on_gpu = arm
    q, qd, qdd = motion
    given, g = (q, qd[0], qdd[:2, None]), (0.0, 0.0, -1.62)
    expected = robot.inverse_dynamics(*given, gravity=g)
    np.testing.assert_allclose(on_gpu.inverse_dynamics(*given, gravity=g), expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(on_gpu.gravity_torque(q, gravity=g), robot.gravity_torque(q, gravity=g), rtol=0, atol=1e-9)


def test_results_go_where_the_caller_wants_them(arm, motion):
    _, on_gpu = arm
    for given in (motion, tuple(map(cuda.to_device, motion))):
        out = np.empty(motion[0].shape) if given is motion else cuda.device_array(motion[0].shape)
        assert on_gpu.inverse_dynamics(*given, out=out) is out
        with pytest.raises(InputError, match="out"):
            on_gpu.forward_dynamics(*given, out=out[:1])


def test_what_cannot_be_taken_is_named(arm, motion):
    _, on_gpu = arm
    q, qd, qdd = motion
    bad = qd.copy()
    bad[1, 0] = np.nan
    for given in ((q, bad, qdd), tuple(map(cuda.to_device, (q, bad, qdd)))):
        with pytest.raises(InputError, match=r"qd\[1, 0\]"):
            on_gpu.inverse_dynamics(*given)
        with pytest.raises(InputError, match=r"qd\[1, 0\]"):
            on_gpu.inverse_dynamics_derivatives(*given)
    with pytest.raises(InputError, match=r"torque\[1, 0\]"):
        on_gpu.forward_dynamics(q, qd, bad)
    with pytest.raises(InputError, match="all on the host, or all on the device"):
        on_gpu.inverse_dynamics(cuda.to_device(q), qd, qdd)
    with pytest.raises(InputError, match="with the same shape"):
        on_gpu.inverse_dynamics(cuda.to_device(q), cuda.to_device(qd[:1]), cuda.to_device(qdd))
    far = q.copy()
    far[0, 0] = 1e30
    with pytest.raises(InputError, match="q"):
        on_gpu.gravity_torque(far)


@pytest.mark.filterwarnings("ignore:.*(divide by zero|invalid value)")
def test_a_joint_that_moves_no_mass_is_refused():
    on_gpu = ulna.load(SCARA.replace('<mass value="0.5"/>', '<mass value="0"/>').replace('"0.001"', '"0"')).on_gpu()
    q = np.zeros((3, 3))
    assert on_gpu.inverse_dynamics(q, q, q).shape == (3, 3)
    with pytest.raises(SingularityError, match="moves no mass"):
        on_gpu.forward_dynamics(q, q, q)


def _link(name, mass, length, tensor):
    return f"""<link name="{name}"><inertial><origin xyz="{length} 0 0"/><mass value="{mass}"/>
    <inertia ixx="{tensor}" iyy="{tensor}" izz="{tensor}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""


def _joint(name, kind, ends, x):
    limit = '<limit lower="-2" upper="2" effort="50" velocity="2"/>'
    return f"""<joint name="{name}" type="{kind}"><parent link="{ends[0]}"/><child link="{ends[1]}"/><origin xyz="{x} 0 0.1"/>
    <axis xyz="0 0 1"/>{limit}</joint>"""


SCARA = (
    '<robot name="scara"><link name="base"/>'
    + _link("upper", 3, 0.2, "0.02") + _link("fore", 2, 0.15, "0.01") + _link("quill", 0.5, 0.0, "0.001")
    + _joint("shoulder", "revolute", ("base", "upper"), 0) + _joint("elbow", "revolute", ("upper", "fore"), 0.4)
    + _joint("slide", "prismatic", ("fore", "quill"), 0.3) + "</robot>"
)  # fmt: skip
