"""A network learns inverse kinematics of a Panda that keeps clear of a ball, by the gradients of poses and distances.

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


def off_and_clear(n):
    """How far the hand is from n random points in front of the arm, and the arm from the ball [m], shape (n,) each."""
    points = torch.tensor([0.35, -0.4, 0.2]) + torch.rand(n, 3) * torch.tensor([0.25, 0.8, 0.5])
    q = middle + span * network(points)
    hand = ulna.torch.forward_kinematics(robot, q)[:, :3, 3]
    return (hand - points).norm(dim=1), ulna.torch.signed_distance(robot, q, world, self_collision=False)


def tested():
    """The median of how far the hand is off [m], and the share of configurations in which the arm touches the ball."""
    with torch.no_grad():
        off, clear = off_and_clear(2000)
    return off.median().item(), (clear <= 0).double().mean().item()


steps = 2000
optimizer = torch.optim.Adam(network.parameters(), lr=3e-3)
schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
before = tested()
for _ in range(steps):
    off, clear = off_and_clear(256)
    optimizer.zero_grad()
    (off.mean() + 5 * torch.relu(0.02 - clear).mean()).backward()
    optimizer.step()
    schedule.step()

after = tested()
for when, (off, touching) in (("before", before), ("after", after)):
    print(f"{when}: {1000 * off:.0f} mm off, {100 * touching:.1f} % touch the ball")
assert before[0] > 0.2
assert after[0] < 0.03
assert after[1] < 0.01
