"""The dynamics of a tree of rigid bodies: torques, the mass matrix, and what is derived from them.

Motions and wrenches are pairs of vectors, linear part first: a motion is the velocity of a point and the angular velocity, a
wrench a force and the moment about that point. The point is the origin of the frame in whose axes both are given.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008); Lynch and Park, Modern Robotics (2017), chapter 8.
"""
