"""Computes inverse kinematics in closed form: the family of an arm, all branches of a target, and their proofs."""
