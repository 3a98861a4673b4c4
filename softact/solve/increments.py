"""How long the next increment is, after one that was accepted and after one that failed."""

# Newton counts that let the increment grow, and beyond which it shrinks.
EASY, HARD = 5, 8
GROWTH, SHRINK, CUT = 1.6, 0.7, 0.4
# Part of the largest increment below which an accepted one always grows, by this factor at least.
SMALL, RECOVERY = 0.1, 1.25


def next_size(size: float, iterations: int, largest: float) -> float:
    """Increment after one that was accepted.

    A small one does not shrink for its many iterations: where they converge slowly in themselves
    (a follower pressure on an open face) no increment would be small enough.
    """
    factor = growth(iterations)
    if size < SMALL * largest:
        factor = max(factor, RECOVERY)
    return min(largest, size * factor)


def growth(iterations: int) -> float:
    """Factor for the next increment after so many iterations."""
    if iterations <= EASY:
        return GROWTH
    return 1.0 if iterations <= HARD else SHRINK
