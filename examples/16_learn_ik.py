"""Trains a network for inverse kinematics of a Panda around a ball, with gradients of poses and distances.

Needs the extra ``torch``: pip install -e ".[torch]" in a copy of the repository.
"""

import torch  # pyright: ignore[reportMissingImports]

import ulna
import ulna.torch

torch.manual_seed(0)
torch.set_num_threads(1)  # the network is small
torch.set_default_dtype(torch.float64)
robot, world = ulna.load("panda"), ulna.World()
world.add("ball", ulna.Sphere(0.1), ulna.pose((0.45, 0.0, 0.35)))
middle, span = torch.tensor(robot.home), torch.tensor(robot.upper - robot.lower) / 3
sizes = (3, 128), (128, 128), (128, 7)
network = torch.nn.Sequential(*(layer for size in sizes for layer in (torch.nn.Linear(*size), torch.nn.Tanh())))


def errors_and_distances(n):
    """Evaluate the network at n random points in front of the arm.

    Returns the distances of the hand from the points and of the arm from the ball [m], shape (n,) each.
    """
    points = torch.tensor([0.35, -0.4, 0.2]) + torch.rand(n, 3) * torch.tensor([0.25, 0.8, 0.5])
    q = middle + span * network(points)
    hand = ulna.torch.forward_kinematics(robot, q)[:, :3, 3]
    return (hand - points).norm(dim=1), ulna.torch.signed_distance(robot, q, world, self_collision=False)


def evaluate():
    """The median error of the hand [m], and the share of configurations in collision with the ball."""
    with torch.no_grad():
        error, distance = errors_and_distances(2000)
    return error.median().item(), (distance <= 0).double().mean().item()


steps = 2000
optimizer = torch.optim.Adam(network.parameters(), lr=3e-3)
schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
before = evaluate()
for _ in range(steps):
    error, distance = errors_and_distances(256)
    optimizer.zero_grad()
    (error.mean() + 5 * torch.relu(0.02 - distance).mean()).backward()
    optimizer.step()
    schedule.step()

after = evaluate()
for when, (error, touching) in (("before", before), ("after", after)):
    print(f"{when}: a median error of {1000 * error:.0f} mm, {100 * touching:.1f} % touch the ball")
assert before[0] > 0.2
assert after[0] < 0.03
assert after[1] < 0.01
