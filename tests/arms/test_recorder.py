from dataclasses import replace

import numpy as np
import pytest

import ulna
from ulna.arms import FR3, Arm, ArmLimits, Recorder

from .conftest import HOME  # noqa: TID252
