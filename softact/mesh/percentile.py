"""Percentiles of values that have weights, such as volumes or areas."""

import numpy as np


def percentile(values: np.ndarray, weights: np.ndarray, part: float) -> float:
    """The smallest of the values (n,) that, with all smaller ones, have this part (0 to 1) of the
    weights (n,)."""
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / weights.sum()
    return float(values[order[min(int(np.searchsorted(share, part)), len(values) - 1)]])
