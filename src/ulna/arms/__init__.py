"""Drivers of real arms: one interface, the Franka by its maker's client, and a dry run without dependencies."""

from ulna.arms.arm import FR3, Arm, ArmModel, Record
from ulna.arms.franka import Franka
from ulna.arms.recorder import Recorder

__all__ = ["FR3", "Arm", "ArmModel", "Franka", "Record", "Recorder"]
