"""The parts of a model's potential energy, and the states in which they are asked.

A term offers ``add_force(state, out)`` (derivative of its potential, N), ``add_tangent(state,
origin)`` (second derivative) and ``energy(state)`` (mJ, this process's share). New physics is a new
term.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from softact.system.kernels import Kernel

if TYPE_CHECKING:
    from softact.system.assembly import Assembler

FUNCTIONS = {1: 4, 2: 10}  # shape functions of a tetrahedron by degree
#: Name under which a state holds the value of a load on everything.
EVERYTHING = ""
#: How the names begin under which a state remembers the air of its cavities.
AIR = "air "
#: The same of what all processes know alike of a contact.
CONTACT = "contact "
Value = float | np.ndarray


@dataclass(frozen=True, eq=False)
class TimeStep:
    """A time step that acts on a state, see ``softact.solve.rungs`` and
    ``softact.solve.generalised_alpha``.

    factor: c of the force M c (x − away_from), 1/s²; away_from: (local,) where the body would be
    without force. before: (local,) unknowns at its beginning, which the solids resist to leave as a
    Newtonian fluid does; resistance: its viscosity by their shear modulus and the time step.
    carried: (local,) force, N, that is taken over from before; None: nothing.
    """

    factor: float
    away_from: np.ndarray
    before: np.ndarray
    resistance: float = 0.0
    carried: np.ndarray | None = None

    @functools.cached_property
    def key(self) -> bytes:
        """Differs where the resistance differs."""
        return (
            hashlib.blake2b(self.before.tobytes(), digest_size=16).digest()
            + repr(self.resistance).encode()
        )


@dataclass(frozen=True)
class Clock:
    """now: s since the start of the run. since: when the last equilibrium was. runs: whether the
    step has a duration; where it has none, all that creeps has come to its end."""

    now: float = 0.0
    since: float = 0.0
    runs: bool = False

    @property
    def elapsed(self) -> float:
        """Time from the last equilibrium to this state, s; inf where no clock runs."""
        return self.now - self.since if self.runs else np.inf

    def arrived(self) -> Clock:
        """The same with this state as the last equilibrium."""
        return replace(self, since=self.now)


@dataclass
class State:
    """Unknowns and loads at one moment, as this process holds them.

    x: (local,) unknowns, ghosts included. loads: by field of the registered loads
    (``softact.loads``), what is loaded -> value. memory: what contacts and materials keep from the
    last equilibrium (see ``softact.contact``, ``softact.bodies.remembering``). motion: a time step
    that acts. clock: when this is.
    """

    x: np.ndarray
    loads: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    memory: dict[str, np.ndarray | float] = field(default_factory=dict)
    motion: TimeStep | None = None
    clock: Clock = Clock()

    def __getitem__(self, field: str) -> Mapping[str, Value]:
        """Values of one field of the loads: ``state["pressure"]`` is cavity -> MPa."""
        return self.loads.get(field, {})

    def put(self, field: str, values: Mapping[str, Value]) -> None:
        """Replace the values of one field of the loads; other states keep theirs."""
        self.loads = {**self.loads, field: dict(values)}


class InvertedElementError(Exception):
    """An element has turned inside out: the state is not admissible."""


@dataclass(frozen=True)
class Origin:
    """The states from which the stress in the geometric stiffness is carried on.

    At a state that Newton's method came to, the stress is that of the tangent before, linearised;
    at a guess that was extrapolated, the stress is extrapolated too. A tangent with such a stress
    is Newton's for the stress as an unknown of its own: stiff directions of large rotations then
    put no false stress into it (Magisano, Leonetti, Garcea, CMAME 313, 2017).

    states: (local,) unknowns of each; weights: theirs, with the sum 1. linearised: there is one
    state, and the stress is linearised at it.
    """

    states: tuple[np.ndarray, ...]
    weights: tuple[float, ...] = (1.0,)
    linearised: bool = False


class Term(Protocol):
    """What a model asks of each of its parts."""

    def add_force(self, state: State, out: np.ndarray) -> None:
        """Add the gradient of the potential in the unknowns, N, to ``out`` (local,)."""

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """Add the second derivative to the assembler's matrix."""

    def energy(self, state: State) -> float:
        """This process's share of the potential, mJ."""


def unit_forces(assembler: Assembler, entities: np.ndarray, degree: int) -> np.ndarray:
    """Nodal forces (3, local) of 1 N/mm³ in cells, or 1 N/mm² on facets, along x, y and z."""
    form = "body_force" if np.ndim(entities) == 1 else "surface_force"
    (address,) = assembler.kernels(form, degree)
    kernel = Kernel(assembler, address, entities)
    forces = np.zeros((3, assembler.unknowns.local))
    for direction, out in zip(np.eye(3), forces, strict=True):
        kernel.add_vector(out, 3 * FUNCTIONS[degree], [], direction)
    return forces


def shared_forces(dofs: np.ndarray, shares: np.ndarray, size: int) -> np.ndarray:
    """Forces (3, size) along x, y and z, of which each node of ``dofs`` (..., 3) has a share."""
    forces = np.zeros((3, size))
    for c in range(3):
        np.add.at(forces[c], dofs[..., c], shares)
    return forces
