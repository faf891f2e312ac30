"""Trains a network for inverse kinematics of a Panda around a ball, with gradients of poses and distances.

Needs the extra ``torch``: pip install -e ".[torch]" in a copy of the repository.
"""

import torch  # pyright: ignore[reportMissingImports]

import ulna
import ulna.torch

torch.manual_seed(1)
torch.set_num_threads(1)  # the network is small
torch.set_default_dtype(torch.float64)
robot, world = ulna.load("panda"), ulna.World()
world.add("ball", ulna.Sphere(0.1), ulna.pose((0.45, 0.0, 0.35)))
middle, span = torch.tensor(robot.home), torch.tensor(robot.upper - robot.lower) / 3
sizes, steps = ((3, 128), (128, 128), (128, 7)), 2000
network = torch.nn.Sequential(*(layer for size in sizes for layer in (torch.nn.Linear(*size), torch.nn.Tanh())))
optimizer = torch.optim.Adam(network.parameters(), lr=3e-3)
schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)


def errors_and_distances(n):
    """At n random points: the distances of the hand from the points, and of the arm from the ball [m], shape (n,) each."""
    points = torch.tensor([0.35, -0.4, 0.2]) + torch.rand(n, 3) * torch.tensor([0.25, 0.8, 0.5])
    q = middle + span * network(points)
    error = (ulna.torch.forward_kinematics(robot, q)[:, :3, 3] - points).norm(dim=1)
    return error, ulna.torch.signed_distance(robot, q, world, self_collision=False)


for _ in range(steps):
    error, distance = errors_and_distances(256)
    optimizer.zero_grad()
    (error.mean() + 5 * torch.relu(0.02 - distance).mean()).backward()
    optimizer.step()
    schedule.step()

error, distance = errors_and_distances(2000)
touching = (distance <= 0).double().mean()
print(f"a median error of {1000 * error.median():.0f} mm, {100 * touching:.1f} % touch the ball")
assert error.median() < 0.03
assert touching < 0.01
