"""Plain data: what JSON has words for."""

import numpy as np

Data = dict[str, object]


def plain(value):
    """Dictionaries, lists, strings and numbers as JSON has them; what is infinite becomes None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
