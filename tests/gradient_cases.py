"""Robots for tests of gradients: chains, links inside them, slides, mimics of mimics, floating joints."""

import numpy as np

import robots
import ulna

FRAMES = ["base", "link", "spatial"]
LINKS = {
    "panda": "panda_ee",
    "panda link": "panda_link4",
    "slides": "l4",
    "mimics": "fingertip",
    "floating": "propeller",
    "one floating": "b",  # as many joints of the table as entries of q, in another order
    "planar": "tray",
    "fixed": "base",
}


def robot_of(name):
    if name.startswith("panda"):
        return ulna.load("panda")
    if name == "one floating":
        return ulna.Robot(robots.two_links("floating", robots.Z, origin=robots.place(1)))
    if name == "slides":
        return ulna.Robot(
            robots.of_chain("prismatic", "revolute", "prismatic", "revolute", axis=robots.unit(1, 2, 3), origin=robots.place(0))
        )
    return ulna.Robot(robots.every_joint())


def case(name, n=2):
    """A robot, the name of a link, and n configurations."""
    robot = robot_of(name)
    q = np.random.default_rng(7).uniform(-0.4, 0.4, (n, robot.n_dof)) + (robot.home if name.startswith("panda") else 0.0)
    return robot, LINKS[name], q


def crate():
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0.6, 0.1, 0.4)))
    return world
