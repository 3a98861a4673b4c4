"""What must hold of every accepted state of a run, checked by other means than the solver's own.

``Watch`` is what a ``Stepper`` calls with each state. It collects what is wrong in plain lines:

- forces: reactions, weight, dead loads and obstacles add up to nothing, and what is free is in
  balance;
- work: what pressures, weight and dead loads have done is in the strain energy, as far as
  increments resolve it;
- impossible states: cavities without air, bodies that overlap, elements inside out, points that
  went through an obstacle;
- the way: a state after a limit is none that was passed before.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from softact.solve.rungs.motion import MOTIONS
from softact.system.term import EVERYTHING, State

NOTHING = 1e-6  # of the largest force or energy of a run
FORCES = 1e-5  # of the largest force in play
WORK = 0.05  # of the larger of work and energy, over at least SOME increments
SOME = 5
OVERLAP = 0.021  # of an element
THROUGH = 0.06  # of an element, on the way from one state to the next
ON_THE_WAY = 40  # places at which the way is looked at
BACK = 0.3  # of the way from the last state to the one that was passed


@dataclass
class Watch:
    """Collects faults of the states of one run."""

    model: object
    faults: list[str] = field(default_factory=list)
    states: int = 0
    work: float = 0.0
    _last: State | None = None
    _rest_energy: float = 0.0
    _quasi_static: bool = True
    _branches: dict = field(default_factory=dict)
    # Largest internal force (N) and energy (mJ) so far: where a body has been let go, its rest is
    # measured by what it was.
    _force: float = 0.0
    _energy: float = 0.0

    def __call__(self, state: State, attempt, number: int) -> None:
        now = replace(state, x=state.x.copy())
        self.states += 1
        place = f"{attempt.step} {attempt.fraction:.2%} ({attempt.control})"
        if attempt.control not in MOTIONS and self.states > 1:
            # Not the first, which nobody solved; and before contact is asked about another state:
            # at the edge of two facets a point keeps the one that it faced before.
            self._forces(now, place)
        if self._last is None:
            self._rest_energy = self.model.strain_energy(now)
        elif attempt.control in MOTIONS:
            self._quasi_static = False
        else:
            self.work += self._work_since(now)
            self._through(now, place)
        if attempt.control not in MOTIONS:
            self._branch(now, attempt, place)
        self._impossible(now, place)
        self._energy = max(self._energy, abs(self.model.strain_energy(now)))
        self._last = now

    def end(self) -> list[str]:
        """All faults, with that of the work over the whole run."""
        if self._last is not None and self._quasi_static and self.states > SOME:
            stored = self.model.strain_energy(self._last) - self._rest_energy
            scale = max(abs(self.work), abs(stored), self._energy)
            if scale > 0 and abs(self.work - stored) > WORK * scale and self._closes():
                self.faults.append(f"work of the loads {self.work:.6g} mJ, energy {stored:.6g} mJ")
        return self.faults

    # --- forces and work ----------------------------------------------------------------------

    def _closes(self) -> bool:
        """Whether the loads are those whose work is counted: no friction, no open surfaces."""
        state = self._last
        return not any(v for v in state["surface_pressure"].values()) and not len(
            self.model.contacts
        )

    def _forces(self, state: State, place: str) -> None:
        model = self.model
        force, internal = model.force(state)
        dofs = model.displacement_dofs[: model.nodes.owned]
        fixed = model.assembler.fixed[dofs].astype(bool)
        scale = np.linalg.norm(internal[dofs])
        self._force = max(self._force, scale)
        scale = max(scale, NOTHING * self._force)
        free = np.linalg.norm(np.where(fixed, 0.0, force[dofs]))
        if free > FORCES * max(scale, 1e3 * model.force_floor):
            self.faults.append(f"{place}: {free:.2e} N are out of balance of {scale:.2e} N")
        if any(v for v in state["surface_pressure"].values()) or self._open():
            return
        loads = self._loads(state)
        total = np.where(fixed, force[dofs], 0.0).sum(axis=0) + loads
        total[list(model.mesh.layout.symmetry.values())] = 0.0
        largest = np.abs(np.where(fixed, force[dofs], 0.0)).sum() + np.abs(loads).sum()
        if np.abs(total).max() > FORCES * max(largest, scale):
            self.faults.append(f"{place}: reactions and loads leave {total} N of {largest:.2e} N")

    def _open(self) -> bool:
        """Whether a cavity's walls are not closed but for the symmetry planes (flux of a sheet)."""
        return bool(self.model.sheets)

    def _loads(self, state: State) -> np.ndarray:
        """Weight, dead loads and forces of obstacles on the meshed part, N."""
        model, total = self.model, np.zeros(3)
        for solid in model.solids.values():
            total += solid.material.density * solid.volumes.sum() * state["gravity"][EVERYTHING]
        for layer in model.layers:
            mass = (
                layer.made_of.material.density
                * layer.made_of.thickness
                * model.surfaces.area(layer.surface)
            )
            total += mass * state["gravity"][EVERYTHING]
        for load in ("traction", "payload"):
            for name, value in state[load].items():
                total += value * model.surfaces.area(name)
        for contact in model.contacts:
            if contact.obstacle is not None:
                total += contact.force(state)
        return total

    def _work_since(self, now: State) -> float:
        """Work of pressures, weight, dead loads and moved supports since the last state, mJ, by the
        trapezoidal rule."""
        model, last = self.model, self._last
        work = 0.0
        for name in model.cavities:
            mean = (last["pressure"].get(name, 0.0) + now["pressure"].get(name, 0.0)) / 2
            change = model.cavity_volume(now, name) - model.cavity_volume(last, name)
            work += mean * change
        way = now.x - last.x
        for term in (*model.weights, *model.load_terms.values()):
            for state in (last, now):
                out = np.zeros_like(way)
                term.add_force(state, out)
                work -= float(out @ way) / 2
        dofs = np.flatnonzero(model.assembler.fixed)
        reactions = (model.force(last)[0] + model.force(now)[0]) / 2
        return work + float(reactions[dofs] @ way[dofs])

    # --- impossible states ---------------------------------------------------------------------

    def _impossible(self, state: State, place: str) -> None:
        model = self.model
        for name, at_rest in model.cavity_volumes_at_rest.items():
            if at_rest > 0 and model.cavity_volume(state, name) <= 0:
                self.faults.append(f"{place}: cavity '{name}' has no volume")
        if model.smallest_jacobian(state.x) <= 0:
            self.faults.append(f"{place}: an element is inside out")
        for contact in model.contacts:
            overlap = -model.contacts.smallest_gap(contact, state)[1]
            if overlap > OVERLAP:
                self.faults.append(f"{place}: {contact.name} overlaps by {overlap:.1%}")

    def _through(self, now: State, place: str) -> None:
        for contact in self.model.contacts:
            if not contact.stands(now):
                continue
            begin, end = (contact._places(s, s.x).reshape(-1, 3) for s in (self._last, now))
            size = np.repeat(contact.facets.size, contact.facets.areas.shape[1])
            allowed = np.maximum(THROUGH * size, 0.3 * min(contact.obstacle.shape.room, 1e9))
            for share in np.linspace(0, 1, ON_THE_WAY):
                gap = contact.obstacle.shape.distance((1 - share) * begin + share * end)[0]
                if (gap < -allowed).any():
                    self.faults.append(f"{place}: a point went through '{contact.name}'")
                    return

    def _branch(self, state: State, attempt, place: str) -> None:
        """A state under a load that was passed in the same step, on the same branch again."""
        known = self._branches.setdefault(attempt.step, [])
        top = max((fraction for fraction, _ in known), default=-1.0)
        if attempt.fraction <= top and self._last is not None:
            fractions = np.array([fraction for fraction, _ in known])
            order = np.argsort(fractions)
            after = int(
                np.clip(np.searchsorted(fractions[order], attempt.fraction), 1, len(order) - 1)
            )
            (s, one), (t, other) = known[order[after - 1]], known[order[after]]
            share = (attempt.fraction - s) / (t - s) if t > s else 0.0
            passed = (1 - share) * one + share * other
            if np.linalg.norm(state.x - passed) < BACK * np.linalg.norm(self._last.x - passed):
                self.faults.append(f"{place}: returned to a branch that was passed")
        elif attempt.control in ("load", "search") and attempt.unstable_modes == 0:
            known.append((attempt.fraction, state.x))
