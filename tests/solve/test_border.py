"""Bordered rows of Newton's method beside the bordered matrix, solved whole."""

from types import SimpleNamespace

import numpy as np
import pytest

from softact.solve.border import ArcControl, Border, VolumeControl
from softact.system.term import State

RANDOM = np.random.default_rng(7)
SIZE, FIXED = 6, np.array([1, 4])
FREE = np.setdiff1d(np.arange(SIZE), FIXED)
GRADIENTS = {name: RANDOM.standard_normal(SIZE) for name in ("a", "b")}
X = RANDOM.standard_normal(SIZE)


class Model:
    """Cavities whose volumes are linear in the unknowns."""

    def __init__(self):
        self.unknowns = SimpleNamespace(local=SIZE, owned=SIZE, sum_shared=lambda row: row)
        self.cavities = {
            name: SimpleNamespace(add_volume_gradient=self._adder(gradient))
            for name, gradient in GRADIENTS.items()
        }

    @staticmethod
    def _adder(gradient):
        def add(x, weight, out):
            out += weight * gradient

        return add

    @staticmethod
    def cavity_volume(state, name):
        return 5.0 + GRADIENTS[name] @ state.x

    @staticmethod
    def sum(value):
        return value


def stiffness(lowest=1.0):
    """Of the free unknowns, with its eigenvalues from the lowest to 5."""
    turn, _ = np.linalg.qr(RANDOM.standard_normal((len(FREE),) * 2))
    return (turn * [lowest, 2.0, 3.0, 5.0]) @ turn.T


def corrected(control, matrix, residual):
    """Newton's step and the change of the loads, and the border."""

    def solve(vector):
        out = np.zeros(SIZE)
        out[FREE] = np.linalg.solve(matrix, vector[FREE])
        return out

    border, step = Border(Model(), control, FIXED), solve(residual)
    change = border.correct(State(X.copy(), {}), step, solve)
    return step, change, border


VOLUMES = VolumeControl([{"a": 1.0}, {"a": 0.3, "b": -2.0}], np.array([4.0, 7.0]))
TANGENT = np.array([0.6, 0.0, 0.0, 0.8, 0.0, 0.0])
ARC = ArcControl([{"a": 0.5, "b": 1.0}], X - 0.1, TANGENT, np.array([0.25]))


@pytest.mark.parametrize("control", [VOLUMES, ARC], ids=["volumes", "way"])
def test_the_elimination_solves_the_bordered_system(control):
    """K δx − g δq = −R and c · δx = what is lacking."""
    matrix, residual = stiffness(), RANDOM.standard_normal(SIZE)
    pushes = np.array([sum(w * GRADIENTS[n] for n, w in d.items()) for d in control.directions])
    rows = TANGENT[None] if control is ARC else pushes
    values = control.values(Model(), State(X, {}))
    count = len(values)
    whole = np.block([[matrix, -pushes[:, FREE].T], [rows[:, FREE], np.zeros((count, count))]])
    right = np.concatenate([-residual[FREE], control.targets - values])
    exact = np.linalg.solve(whole, right)
    step, change, border = corrected(control, matrix, residual)
    np.testing.assert_allclose(-step[FREE], exact[: len(FREE)], rtol=1e-10)
    np.testing.assert_allclose(change, exact[len(FREE) :], rtol=1e-10)
    assert not step[FIXED].any()
    state = State(X - step, {"pressure": {"a": 1.0}})
    assert border.error(state) < 1e-12  # volumes are linear here
    border.add(state, change)
    added = sum(d.get("a", 0.0) * q for d, q in zip(control.directions, change, strict=True))
    assert state["pressure"]["a"] == pytest.approx(1.0 + added, rel=1e-12)


def test_a_volume_that_grows_as_the_pressure_falls_is_counted():
    """Where the lowest eigenvalue is close below zero: one direction of the two."""
    assert corrected(VOLUMES, stiffness(), np.zeros(SIZE))[2].softening == 0
    assert corrected(VOLUMES, stiffness(-1e-3), np.zeros(SIZE))[2].softening == 1


def test_a_volume_that_no_pressure_changes_is_no_number():
    """The solve fails, and nothing is raised."""
    nothing = VolumeControl([{}], np.array([4.0]))
    step, change, _ = corrected(nothing, np.eye(len(FREE)), np.zeros(SIZE))
    assert np.isnan(change).all() and np.isnan(step).all()
