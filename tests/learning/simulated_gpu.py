"""Passes tensors through a robot on a simulated GPU and through the robot on the CPU; writes the largest differences as JSON.

The simulator has no tensors of its own: these are on the CPU, so their rows are copied to the simulated GPU and back.
"""

import json
import sys

import numpy as np
import torch

import ulna
import ulna.torch
from ulna.gpu import device

robot, world = ulna.load("panda"), ulna.World()
world.add("box", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0.0, 0.3)))
q = robot.random(2, seed=0)
launched = set()
compiled = device.compiled


def noted(driver):
    launched.add(driver.__name__)
    return compiled(driver)


def values_and_gradient(at):
    """Poses, Jacobians and distances, and the gradient of a loss of them all."""
    x = torch.tensor(q, requires_grad=True)
    T, J = ulna.torch.forward_kinematics(at, x), ulna.torch.jacobian(at, x, expressed_in="link")
    d = ulna.torch.signed_distance(at, x, world)
    (T.square().sum() + (J * torch.arange(42.0).reshape(6, 7)).sum() + d.sum()).backward()
    return [each.detach().numpy() for each in (T, J, d, x.grad)]


device.compiled = noted
on_gpu = robot.on_gpu()
with on_gpu.checked():
    found = values_and_gradient(on_gpu)
expected = values_and_gradient(robot)
off = [float(np.abs(a - b).max()) for a, b in zip(found, expected, strict=True)]
json.dump({"off": off, "launched": sorted(launched)}, sys.stdout)
