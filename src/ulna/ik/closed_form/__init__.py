"""Inverse kinematics in closed form: which arms have one, all branches of a target, and what is proved of them."""
