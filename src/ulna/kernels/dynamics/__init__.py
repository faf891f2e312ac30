"""The dynamics of a tree of rigid bodies: torques, the mass matrix, and their derivatives.

Motions and wrenches are pairs of vectors, linear part first. A motion is the velocity of a point and the angular velocity. A
wrench is a force and the moment about the same point. The point is the origin of the frame in whose axes both are given.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008); Lynch and Park, Modern Robotics (2017), chapter 8.
"""
