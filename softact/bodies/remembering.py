"""Bodies whose material remembers, what creeps and what softens: regions of tetrahedra, and sheets.

What it has to know of the last equilibrium stands in ``State.memory``, at the quadrature points,
under keys that begin with the body's kind and name, see ``softact.bodies.memory``.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Sequence
from typing import Any, Protocol, cast

import numpy as np
from mpi4py import MPI

from softact.bodies.last_few import LastFew
from softact.bodies.membrane import BondedMembrane, Membrane
from softact.bodies.memory import Memory
from softact.bodies.solid import Solid
from softact.materials.base import Elastic, Law
from softact.materials.plane_stress import RememberedLaw, Response, SheetLaw, small_strain_constants
from softact.materials.tension_field import PLACE
from softact.materials.tensors import full
from softact.mesh.triangles import Triangles
from softact.system.term import Origin, State


class Remembering(Protocol):
    """What counts on the last equilibrium."""

    @property
    def softens(self) -> bool:
        """Whether something of it loses energy for good."""

    def name_of(self, what: str) -> str:
        """Key of a state's memory; with "", how all of them begin."""

    def remember(self, state: State) -> dict[str, np.ndarray | float]:
        """What is to be kept of a new equilibrium. Collective."""

    def time_error(self, state: State) -> float:
        """See ``Memory``. Collective."""

    def softened_away(self, state: State) -> float:
        """Energy that softening has taken for good, mJ, of this process."""


class RememberingSolid(Solid):
    """A region with Maxwell elements or Mullins' softening on top of its law."""

    def __init__(self, *args: Any, **more: Any):
        super().__init__(*args, **more)
        comm = self.assembler.unknowns.comm
        self.memory = Memory(f"solid {self.name}", self.material.law, self.volumes.ravel(), comm)
        self.name_of = self.memory.name_of
        self._of_law: LastFew[Elastic] = LastFew()

    @property
    def softens(self) -> bool:
        """See ``Remembering``."""
        return self.memory.mullins is not None

    def _isochoric(self, c: np.ndarray, state: State) -> tuple[np.ndarray, np.ndarray]:
        """See ``Solid``: with softening and overstress."""
        return self.memory.response(self._law(c, state.x), state)

    def _law(self, c: np.ndarray, x: np.ndarray) -> Elastic:
        """The law alone, kept for the last few states whenever they were."""

        def find() -> Elastic:
            energy = self.material.energy(full(c), self.fibres) if self.memory.mullins else None
            return *self._of_the_law(c), energy

        return self._of_law(x, b"", find)

    def _elastic(self, state: State) -> Elastic:
        return self._law(self.right_cauchy_green(state.x).reshape(-1, 6), state.x)

    def _key(self, state: State) -> bytes:
        """See ``Solid``."""
        if self.memory.has_changed(state):
            self._kept.clear()
        return super()._key(state) + repr(state.clock.elapsed).encode()

    def remember(self, state: State) -> dict[str, np.ndarray | float]:
        """See ``Remembering``."""
        return self.memory.remember(self._elastic(state), state)

    def time_error(self, state: State) -> float:
        """See ``Remembering``."""
        return self.memory.time_error(self._elastic(state), state, self.material.shear_modulus)

    def density(self, state: State) -> np.ndarray:
        """See ``Solid``: it depends on more than the unknowns."""
        self._last.pop("density", None)
        return super().density(state)

    def _stored(self, c: np.ndarray, state: State) -> np.ndarray:
        """See ``Solid``: what the law gives back in the long run; overstress is not in it."""
        return self.memory.stored(super()._stored(c, state), state)

    def softened_away(self, state: State) -> float:
        """See ``Remembering``."""
        if self.memory.mullins is None:
            return 0.0
        energy = super()._stored(self.right_cauchy_green(state.x).reshape(-1, 6), state)
        return self.memory.softened_away(energy, state)


class RememberingMembrane(Membrane):
    """A sheet of plies of which some remember, as the same material in a solid does: each one's
    isochoric stress softens, and its Maxwell elements follow that; of law linear the plane stress.

    name: of the body, "sheet ..." or "layer ...". plies: (law of the library, law in the plane,
    thickness) of each.
    """

    def __init__(
        self,
        name: str,
        triangles: Triangles,
        along: np.ndarray,
        plies: Sequence[tuple[Law, SheetLaw, float]],
        comm: MPI.Comm,
    ):
        super().__init__(triangles, along, [(law, t) for _, law, t in plies])
        self._name = name
        self._moduli = [small_strain_constants(law)[0] for law, *_ in plies]
        self._memories = [
            Memory(self.name_of(str(number)), law, t * self.weights.ravel(), comm)
            if law.remembers
            else None
            for number, (law, _, t) in enumerate(plies)
        ]
        self._now: State | None = None  # whose memory and clock count

    def name_of(self, what: str) -> str:
        """See ``Remembering``."""
        return f"{self._name}.{what}"

    @property
    def softens(self) -> bool:
        """See ``Remembering``."""
        return any(memory is not None and memory.mullins for memory in self._memories)

    def _at(self, state: State) -> None:
        """Count on the memory and the clock of a state from here on."""
        before = self._now
        changed = [memory.has_changed(state) for memory in self._memories if memory]
        if any(changed) or before is None or before.clock.elapsed != state.clock.elapsed:
            self._kept.clear()
        self._now = state

    def response(self, c: np.ndarray) -> Response:
        """See ``Membrane``: at the time, and with the memory, of the state that counts; the energy
        is what is given back in the long run."""
        parts = []
        for (law, t), memory in zip(self.laws, self._memories, strict=True):
            energy, stress, moduli = self._ply(law, memory, c)
            parts.append((t * energy, t * stress, t * moduli))
        energy, stress, moduli = (
            functools.reduce(operator.add, (part[i] for part in parts)) for i in range(3)
        )
        return energy, stress, moduli

    def _ply(self, law: SheetLaw, memory: Memory | None, c: np.ndarray) -> Response:
        if memory is None:
            return law.evaluate(c)
        remembered, now = cast(RememberedLaw, law), cast(State, self._now)
        elastic = remembered.elastic(c)
        stress, moduli = remembered.in_plane(c, *memory.response(elastic, now))
        return memory.stored(cast(np.ndarray, elastic[2]), now), stress, moduli

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        self._at(state)
        super().add_force(state, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        self._at(state)
        super().add_tangent(state, origin)

    def energy(self, state: State) -> float:
        """See ``Term``."""
        self._at(state)
        return super().energy(state)

    def _elastic(self, state: State) -> list[tuple[Memory, Elastic, float]]:
        """Of each ply that remembers: its memory, what its law alone says, and Young's modulus."""
        c = self.metric(state.x)
        found = []
        for (law, _), memory, modulus in zip(self.laws, self._memories, self._moduli, strict=True):
            if memory is not None:
                stress, moduli, energy = cast(RememberedLaw, law).elastic(c)
                known = energy if memory.mullins else None
                found.append((memory, (stress, moduli, known), modulus))
        return found

    def remember(self, state: State) -> dict[str, np.ndarray | float]:
        """See ``Remembering``."""
        found: dict[str, np.ndarray | float] = {}
        for memory, elastic, _ in self._elastic(state):
            found |= memory.remember(elastic, state)
        return found

    def time_error(self, state: State) -> float:
        """See ``Remembering``."""
        return max(m.time_error(elastic, state, e) for m, elastic, e in self._elastic(state))

    def softened_away(self, state: State) -> float:
        """See ``Remembering``."""
        each = self._elastic(state)
        return sum(m.softened_away(e[2], state) for m, e, _ in each if e[2] is not None)

    def ply_stresses(self, x: np.ndarray) -> list[np.ndarray]:
        """See ``Membrane``: with what each remembers."""
        c, pairs = self.metric(x), zip(self.laws, self._memories, strict=True)
        return [self._ply(law, memory, c)[1][:, PLACE] for (law, _), memory in pairs]


class RememberingLayer(RememberingMembrane, BondedMembrane):
    """The same on a solid, see ``BondedMembrane``."""
