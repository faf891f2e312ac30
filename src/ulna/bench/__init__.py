"""Measures Ulna on this machine: timing, arms, targets and the protocols of inverse kinematics.

``benchmarks/``, beside the package, measures peers by the same protocols.
"""
