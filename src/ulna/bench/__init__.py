"""Measures Ulna on this machine: timing, arms, targets and the protocols of inverse kinematics.

The folder ``benchmarks/`` of the repository measures peers by the same protocols.
"""
