"""Into how many steps a mesh divides a length."""

from math import ceil

#: A step may be longer than was asked for by this part. Lengths that are a whole number of steps,
#: as those of most specs are, then keep their number when they change a little or are rounded.
SLACK = 0.002


def steps(length: float, size: float, least: int = 1) -> int:
    """Number of equal steps along a length so that none is longer than ``size``, but for SLACK;
    at least ``least``."""
    return max(least, ceil(length / size / (1 + SLACK)))
