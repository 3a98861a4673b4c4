"""How far a run got: its stable states, the largest load that one of them bears, and whether its
path has a limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.results.folder import COMPLETE, NO_EQUILIBRIUM, Results, load, load_name

#: ``Attempt.control`` of what is no equilibrium, and of what was found by volume or arc length.
MOTION, TRACED = "motion", ("volume", "arc")


@dataclass(frozen=True)
class Reached:
    """Rows of the curve. stable: (rows,) whether a state is a stable equilibrium. limit: whether
    the load could not simply be raised: some equilibria are unstable, or the run ended early.
    largest: the stable state with the largest load, the last of several; None where there is none.
    main: the state whose figures stand for the run: the last, where all steps are solved and it is
    no unstable one or no pressure drives it there, else the largest stable. None where there is no
    state.
    """

    stable: np.ndarray
    limit: bool
    largest: int | None
    main: int | None


def reached(results: Results) -> Reached:
    """How far a run got."""
    loads = load(results)
    if not len(loads):
        return Reached(np.zeros(0, bool), results.status == NO_EQUILIBRIUM, None, None)
    unstable = unstable_rows(results)
    stable = ~unstable & ~moving_rows(results)
    largest = None
    if stable.any():
        sizes = np.where(stable, np.abs(loads), -1.0)
        near = sizes >= sizes.max() - 1e-9 * abs(sizes.max())
        largest = int(np.flatnonzero(near)[-1])
    last = len(loads) - 1
    whole = results.status not in (COMPLETE, NO_EQUILIBRIUM)  # what there is so far
    whole |= results.status == COMPLETE and (not unstable[last] or load_name(results) is None)
    limit = bool(unstable.any()) or results.status == NO_EQUILIBRIUM
    return Reached(stable, limit, largest, last if whole or largest is None else largest)


def unstable_rows(results: Results) -> np.ndarray:
    """(rows,) whether a state is an unstable equilibrium: by the inertia of its tangent or, where
    that says nothing (with friction), found by volume under a falling load."""
    loads = load(results)
    modes = results.curve.get("unstable_modes", np.zeros(len(loads)))
    falls = np.concatenate([[False], np.abs(loads[1:]) < np.abs(loads[:-1])]) if len(loads) else []
    return (modes > 0) | (np.isin(_control(results), TRACED) & falls)


def moving_rows(results: Results) -> np.ndarray:
    """(rows,) whether a state is one of a motion and no equilibrium."""
    return _control(results) == MOTION


def _control(results: Results) -> np.ndarray:
    return np.array(results.curve.get("control", [""] * len(load(results))), dtype=object)
