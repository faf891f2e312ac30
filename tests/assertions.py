"""``assert_close`` with no tolerance but the one that is given: NumPy's own adds a relative 1e-7 unasked."""

from functools import partial

import numpy as np

assert_close = partial(np.testing.assert_allclose, rtol=0.0, atol=0.0)
