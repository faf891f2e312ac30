"""Poses, Jacobians and distances of PyTorch's tensors: values against the robot's own, gradients against finite differences."""

import numpy as np
import pytest

pytest.importorskip("torch", reason="PyTorch is in an environment of its own: make test-learning")

import torch
from torch.autograd import gradcheck, gradgradcheck

import ulna
import ulna.torch
from gradient_cases import FRAMES, LINKS, case, crate

PLACES = ["cpu", *(["cuda"] if torch.cuda.is_available() else [])]


def tensor(q):
    return torch.tensor(q, requires_grad=True)


@pytest.fixture(params=PLACES)
def place(request):
    return request.param


def there(robot, place):
    return robot if place == "cpu" else robot.on_gpu()


@pytest.mark.parametrize("name", LINKS)
def test_poses_have_the_robots_numbers_and_first_and_second_derivatives(name, place):
    robot, link, q = case(name)
    at, x = there(robot, place), torch.tensor(q, device=place, requires_grad=True)

    def poses(x):
        return ulna.torch.forward_kinematics(at, x, link=link)

    T = poses(x)
    assert np.allclose(T.detach().cpu().numpy(), robot.forward_kinematics(q, link=link), rtol=0, atol=1e-13)
    assert T.device.type == place
    assert gradcheck(poses, x)
    assert gradgradcheck(poses, x)


@pytest.mark.parametrize("expressed_in", FRAMES)
@pytest.mark.parametrize("name", LINKS)
def test_jacobians_have_the_robots_numbers_and_first_and_second_derivatives(name, expressed_in, place):
    robot, link, q = case(name)
    at, x = there(robot, place), torch.tensor(q, device=place, requires_grad=True)

    def jacobians(x):
        return ulna.torch.jacobian(at, x, link=link, expressed_in=expressed_in)

    expected = robot.jacobian(q, link=link, expressed_in=expressed_in)
    assert np.allclose(jacobians(x).detach().cpu().numpy(), expected, rtol=0, atol=1e-13)
    assert gradcheck(jacobians, x)
    assert gradgradcheck(jacobians, x)


@pytest.mark.parametrize("expressed_in", FRAMES)
def test_the_columns_of_mimic_joints_are_differentiated_one_by_one(expressed_in):
    robot, link, q = case("mimics", 1)
    chain = robot.tree.chain(link)
    assert len(np.unique(chain[chain[:, 12] != 2, 13])) < np.count_nonzero(chain[:, 12] != 2)  # or it would test nothing
    x, h = tensor(q[0]), 1e-6
    by_torch = torch.autograd.functional.jacobian(
        lambda x: ulna.torch.jacobian(robot, x, link=link, expressed_in=expressed_in), x
    )
    steps = h * np.eye(robot.n_dof)
    ends = [robot.jacobian(q[0] + sign * steps, link=link, expressed_in=expressed_in) for sign in (1, -1)]
    by_steps = np.moveaxis((ends[0] - ends[1]) / (2 * h), 0, -1)
    assert np.allclose(by_torch.numpy(), by_steps, rtol=0, atol=1e-8)
    assert np.abs(by_steps).max() > 0.1


@pytest.mark.parametrize("world", [crate(), None])
def test_distances_have_the_robots_numbers_and_a_derivative(world, place):
    robot, _, _ = case("panda")
    q = robot.random(6, seed=3)
    at, x = there(robot, place), torch.tensor(q, device=place, requires_grad=True)

    def distances(x):
        return ulna.torch.signed_distance(at, x, world)

    expected = robot.signed_distance(q, world)
    assert np.ptp(expected) > 0.01
    assert np.allclose(distances(x).detach().cpu().numpy(), expected, rtol=0, atol=1e-12)
    assert gradcheck(distances, x)
    assert distances(x[0]).shape == ()
    apart = robot.signed_distance(q, crate(), self_collision=False)
    found = ulna.torch.signed_distance(at, x, crate(), self_collision=False)
    assert np.allclose(found.detach().cpu().numpy(), apart, rtol=0, atol=1e-12)
    assert np.abs(apart - expected).max() > 0.01


def test_a_second_derivative_of_distances_is_refused():
    robot, _, q = case("panda")
    x = tensor(q)
    (first,) = torch.autograd.grad(ulna.torch.signed_distance(robot, x).sum(), x, create_graph=True)
    with pytest.raises(ulna.InputError, match="signed_distance: has first derivatives only"):
        first.sum().backward()


def test_a_gradient_leads_out_of_a_contact():
    robot, world = case("panda")[0], crate()
    q = robot.random(200, seed=0)
    inside = q[robot.signed_distance(q, world, self_collision=False) < -0.02][:1]
    x = tensor(inside)
    optimizer = torch.optim.SGD([x], lr=0.02)
    for _ in range(200):
        optimizer.zero_grad()
        (-ulna.torch.signed_distance(robot, x, world, self_collision=False)).clamp(min=-0.01).sum().backward()
        optimizer.step()
    assert not robot.in_collision(x.detach().numpy(), world, self_collision=False).any()


def test_float32_is_computed_in_float64_and_returned_as_float32():
    robot, _, q = case("panda", 5)
    single = torch.tensor(q, dtype=torch.float32, requires_grad=True)
    T = ulna.torch.forward_kinematics(robot, single)
    assert T.dtype == torch.float32
    exact = robot.forward_kinematics(single.detach().numpy().astype(float))
    assert np.array_equal(T.detach().numpy(), exact.astype(np.float32))
    T.sum().backward()
    double = single.detach().double().requires_grad_()
    ulna.torch.forward_kinematics(robot, double).sum().backward()
    assert np.array_equal(single.grad.numpy(), double.grad.numpy().astype(np.float32))


@pytest.mark.parametrize("batch", [(), (0,), (3,), (2, 3)])
def test_batch_axes_lead(batch):
    robot, _, _ = case("panda")
    q = robot.random(6, seed=1)[: int(np.prod(batch))].reshape(*batch, 7)
    x = tensor(q)
    T = ulna.torch.forward_kinematics(robot, x)
    assert T.shape == (*batch, 4, 4)
    T[..., 0, 3].sum().backward()
    assert np.allclose(x.grad.numpy(), robot.jacobian(q)[..., 0, :])


def test_a_tensor_that_is_not_contiguous_is_read_by_its_strides():
    robot, _, q = case("panda", 3)
    T = ulna.torch.forward_kinematics(robot, torch.tensor(q.T.copy()).T)
    assert np.array_equal(T.numpy(), robot.forward_kinematics(q))


def test_the_numbers_on_the_cpu_are_read_where_they_are(monkeypatch):
    robot, _, q = case("panda", 3)
    seen, x = [], tensor(q)

    def spy(self, q, **named):
        seen.append((q.ctypes.data, named["out"].ctypes.data))
        return forward(self, q, **named)

    forward = ulna.Robot.forward_kinematics
    monkeypatch.setattr(ulna.Robot, "forward_kinematics", spy)
    T = ulna.torch.forward_kinematics(robot, x)
    assert seen == [(x.data_ptr(), T.data_ptr())]


def test_functional_transformations_nest():
    robot, _, q = case("panda", 3)

    def height(x):
        return ulna.torch.forward_kinematics(robot, x)[2, 3]

    first = torch.func.vmap(torch.func.grad(height))(torch.tensor(q))
    assert np.allclose(first.numpy(), robot.jacobian(q)[:, 2])
    second = torch.func.vmap(torch.func.jacrev(torch.func.jacrev(height)))(torch.tensor(q))
    assert np.allclose(second, second.mT, rtol=0, atol=1e-12)
    assert second.abs().max() > 0.1
    with pytest.raises(NotImplementedError, match="forward mode"):
        torch.func.jacfwd(height)(torch.tensor(q[0]))


def test_what_cannot_be_taken_is_refused_by_name():
    robot, _, q = case("panda")
    x = torch.tensor(q)
    with pytest.raises(ulna.InputError, match=r"q: ndarray; a tensor of float32 or float64 is expected"):
        ulna.torch.forward_kinematics(robot, q)
    with pytest.raises(ulna.InputError, match=r"q: a tensor of torch.float16"):
        ulna.torch.forward_kinematics(robot, x.half())
    with pytest.raises(ulna.InputError, match=r"q: shape \(2, 6\), but shape \(..., 7\)"):
        ulna.torch.jacobian(robot, x[:, :6])
    with pytest.raises(ulna.InputError, match=r"q\[1, 2\]: nan is not a finite number"):
        ulna.torch.forward_kinematics(robot, torch.where(torch.arange(14).reshape(2, 7) == 9, torch.nan, x))
    with pytest.raises(ulna.InputError, match=r"expressed_in: 'bse' is not a frame"):
        ulna.torch.jacobian(robot, x, expressed_in="bse")
    with pytest.raises(ulna.UnknownNameError, match="panda_lnk4"):
        ulna.torch.forward_kinematics(robot, x, link="panda_lnk4")
    with pytest.raises(ulna.InputError, match=r"robot: str; a Robot, or the result of robot.on_gpu\(\), is expected"):
        ulna.torch.signed_distance("panda", x)
    with pytest.raises(ulna.InputError, match=r"q: a tensor on meta; a Robot takes tensors on the CPU"):
        ulna.torch.forward_kinematics(robot, x.to("meta"))
    with pytest.raises(ulna.InputError, match="self_collision"):
        ulna.torch.signed_distance(robot, x, self_collision="no")
