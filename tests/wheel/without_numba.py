"""Fails if Numba can be imported."""

import sys
from importlib.util import find_spec

if __name__ == "__main__":
    sys.exit("Numba is installed" if find_spec("numba") else 0)
