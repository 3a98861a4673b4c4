"""The end of a test that is no elastic curve: the break of the specimen, or a hold at the end."""

import numpy as np

FALL = 0.1  # of the stress, within a few points: a break; an unloading falls with the stretch
SUDDEN = 8.0  # times the usual change of the stress from point to point
WINDOW = 3  # points within which a break happens
RECOVERED = 0.95  # of the stress before: a slip in the grips, not a break
STILL = 1e-3  # of the range of stretch: the machine holds
HELD = 5  # points at least that make a hold


def break_at(stretch: np.ndarray, stress: np.ndarray) -> int | None:
    """Return the place of the last point before the specimen breaks, None where it does not.

    A break: the stress falls suddenly while the stretch does not, and never recovers.
    """
    size = np.abs(stress)
    if len(size) < HELD + 1 or not np.max(size) > 0:
        return None
    deformation = np.abs(stretch - 1.0)
    usual = _usual_change(size)
    for i in range(len(size) - 1):
        if size[i] < 0.3 * np.max(size):
            continue
        window = size[i + 1 : i + 1 + WINDOW]
        low = i + 1 + int(np.argmin(window))
        fall = size[i] - size[low]
        if fall < max(FALL * size[i], SUDDEN * usual):
            continue
        if np.max(size[low:]) > RECOVERED * size[i]:
            continue
        if _unloads(deformation, size, i, low):
            continue
        near = size[i:low]
        return i + int(np.flatnonzero(near > RECOVERED * np.max(near))[-1])
    return None


def _usual_change(size: np.ndarray) -> float:
    """How much the stress usually bends between points: noise, or curvature where there is none."""
    if len(size) < 4:
        return 0.0
    return float(np.median(np.abs(np.diff(size, 2))))


def _unloads(deformation: np.ndarray, size: np.ndarray, i: int, low: int) -> bool:
    """Whether the stress falls because the stretch goes back.

    A specimen that snaps takes an extensometer back too: but then it was loaded to the most before,
    all of the stress is gone within a few points, and none comes back.
    """
    back = deformation[i] - np.min(deformation[i + 1 : low + 1])
    if back <= 0.01 * np.ptp(deformation):
        return False
    loaded = i >= HELD and deformation[i] > RECOVERED * np.max(deformation)
    gone = len(size) - low > 1 and np.max(size[low:]) < 0.1 * size[i]
    return not (loaded and gone)


def hold_from(stretch: np.ndarray) -> int | None:
    """Return the place of the first point at which the machine stands still until the end."""
    span = float(np.ptp(stretch)) if len(stretch) else 0.0
    if not span:
        return None
    moved = np.flatnonzero(np.abs(stretch - stretch[-1]) > STILL * span)
    if not len(moved):
        return None
    first = int(moved[-1]) + 1
    return first if len(stretch) - first > max(HELD, 0.02 * len(stretch)) else None
