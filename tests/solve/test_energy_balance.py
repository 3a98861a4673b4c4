"""Where the work of the loads goes, for a mass on a spring whose every force is written here."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad

from softact.solve.energy_balance import EnergyBalance
from softact.system.term import State

# The mass at u hangs on a spring, E(e) = k e²/2 + c e⁴/4 with e = u − w, from a support at w; air
# of the volume A u and a force f push it.
MASS, K, C, AREA, DAMPING = 3.0, 2.0, 5.0, 0.7, 0.4
# Place s, time (s), u and w (mm), pressure (MPa).
S = np.array([0.0, 0.3, 0.5, 1.0])
TIME = np.array([0.0, 0.2, 0.5, 0.6])
U = np.array([0.0, 0.4, 0.9, 0.7])
W = np.array([0.0, 0.1, -0.2, 0.3])
P = np.array([0.2, 0.5, 0.1, 0.9])

V = np.array([0.0, *(np.diff(U) / np.diff(TIME))])


def spring(e):
    return K * e + C * e**3


def stored(e):
    return K * e**2 / 2 + C * e**4 / 4


# The force with which each time step obeys m Δv/Δt + α m v + spring = f + p A.
F = spring(U - W) - AREA * P
F[1:] += MASS * np.diff(V) / np.diff(TIME) + DAMPING * MASS * V[1:]


class Model:
    """What ``EnergyBalance`` asks of a model."""

    def __init__(self):
        self.cavities = {"air": SimpleNamespace(add_force=self.add_pressure)}

    @staticmethod
    def add_pressure(state, out):
        out[0] -= AREA * state["pressure"]["air"]

    @staticmethod
    def momentum(velocity):
        return np.array([MASS * velocity[0], 0.0])

    @staticmethod
    def strain_energy(state):
        return stored(state.x[0] - state.x[1])

    @staticmethod
    def cavity_volume(state, name):
        return AREA * state.x[0]

    def force(self, state):
        internal = spring(state.x[0] - state.x[1]) * np.array([1.0, -1.0])
        out = internal.copy()
        self.add_pressure(state, out)
        out[0] -= state["traction"]["mass"]
        return out, internal


def followed(force):
    """The balance after the three time steps, under such forces (4,) at S."""

    def load(state, s, q):
        state.put("pressure", {"air": float(np.interp(s, S, P))})
        state.put("traction", {"mass": float(np.interp(s, S, force))})

    newton = SimpleNamespace(held=lambda state: SimpleNamespace(start=state.x[1:]))
    state = State(np.array([U[0], W[0]]), {})
    balance = EnergyBalance(Model(), newton, SimpleNamespace(set=load), state, S[0], np.empty(0))
    for n in (1, 2, 3):
        state.x = np.array([U[n], W[n]])
        velocity = np.array([V[n], (W[n] - W[n - 1]) / (TIME[n] - TIME[n - 1])])
        balance.move(S[n], np.empty(0), velocity, TIME[n] - TIME[n - 1], DAMPING)
    return balance


def along(n, function):
    """Integral of function(share, start, end) over the n-th way."""
    return quad(lambda share: function(*((1 - share) * a[n - 1] + share * a[n]
                                         for a in (U, W, P, F))), 0, 1)[0]  # fmt: skip


def test_each_part_is_what_its_integral_says():
    """Loads and states run straight from one place to the next; the support works with the force
    that it has at the end of a time step."""
    balance, steps = followed(F), (1, 2, 3)
    du, dw, dv, dt = (np.diff(a) for a in (U, W, V, TIME))
    of_loads = sum(du[n - 1] * along(n, lambda u, w, p, f: f + p * AREA) for n in steps)
    of_support = -sum(dw[n - 1] * spring(U[n] - W[n]) for n in steps)
    assert balance.work == pytest.approx(of_loads + of_support, rel=1e-12)
    assert balance.stored == pytest.approx(stored(U[-1] - W[-1]), rel=1e-12)
    assert balance.kinetic == pytest.approx(MASS * V[-1] ** 2 / 2, rel=1e-12)
    assert balance.damped == pytest.approx(DAMPING * MASS * (dt * V[1:] ** 2).sum(), rel=1e-12)
    lost = MASS * (dv**2).sum() / 2
    for n in steps:
        end = spring(U[n] - W[n]) - P[n] * AREA - F[n], -spring(U[n] - W[n])
        lost += du[n - 1] * (
            end[0] - along(n, lambda u, w, p, f: spring(u - w) - p * AREA - f)
        ) + dw[n - 1] * (end[1] + along(n, lambda u, w, p, f: spring(u - w)))
    assert balance.lost == pytest.approx(lost, rel=1e-12)
    assert balance.unexplained < 1e-12


def test_a_force_that_no_motion_obeys_is_unexplained():
    """By its work along the way, here 2 N in the second time step and at its end."""
    wrong = F + np.array([0.0, 0.0, 2.0, 0.0])
    balance = followed(wrong)
    assert balance.unexplained * abs(balance.work) == pytest.approx(2.0 * (U[2] - U[1]), rel=1e-9)


def test_what_comes_to_rest_loses_its_motion():
    """From the last motion to the equilibrium there: all that was kinetic is lost."""
    balance = followed(F)
    before = balance.lost, balance.kinetic, balance.work
    balance.move(1.0, np.empty(0))
    assert balance.kinetic == 0.0 and balance.work == before[2]
    assert balance.lost == pytest.approx(before[0] + before[1], rel=1e-12)
