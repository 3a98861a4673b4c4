"""A rigid body that moves by what touches it: an object that is grasped.

Six unknowns: how far its centre of mass has moved, and how far it has turned. Its rotation is
R = exp([(θ − θ₀)]×) R₀, with θ₀ and R₀ those of the last equilibrium: θ counts on through any
number of turns, and no rotation is singular. The unknowns are u and a θ, in mm, with the arm a, so
that what is out of balance is in N.

Where nothing holds the body, as a ball about its own centre, a very soft spring to where it was at
the last equilibrium does: it makes the matrix regular, pulls at nothing where nothing pushes, and
says where the body is lost: there it carries what should have held it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.memory import remembered
from softact.contact.pose import Pose
from softact.contact.rests import Rest
from softact.errors import SpecError
from softact.system.rotation import RotationVector
from softact.system.term import CONTACT, EVERYTHING, Origin, State

if TYPE_CHECKING:
    from softact.contact.rigid import Obstacle
    from softact.model import Model
    from softact.system.assembly import BlockTable

# Springs that hold a body, by the stiffness of the actuator: in place, and where nothing does.
FIRMLY, SOFTLY = 1e4, 1e-7
SAME = 1e-6  # of the arm: what is nearer to a symmetry plane lies on it
# The body is lost where the soft spring carries more than this part of all that acts on it.
LOST = 0.01


@dataclass(frozen=True)
class Motion:
    """shift: u (3,) mm. turn: R (3, 3); first, second: its derivatives by the unknowns, 1/mm and
    1/mm²: (3, 3, 3) and (3, 3, 3, 3)."""

    shift: np.ndarray
    turn: np.ndarray
    first: np.ndarray
    second: np.ndarray


class FreeBody:
    """A free body of a model.

    State: ``hold[name]`` 1 where it is held in place, 0 where it is free; between, the force that
    held it fades. ``memory``: place (6,) and rotation (3, 3) of the last equilibrium, where it is
    held (6,), and by what (6,) N. others: obstacles that it may touch. dofs: (6,) unknowns; mine:
    whether this process owns them. mass: of the meshed part, tonne. arm: mm. rests: where it
    touches ``others``. still: unknowns that symmetry holds, and their values.
    """

    def __init__(
        self,
        model: Model,
        obstacle: Obstacle,
        others: Iterable[Obstacle],
        table: BlockTable,
        number: int,
    ):
        filled = obstacle.shape.filled
        assert filled is not None  # or it is endless, and has no mass
        self.name, self.centre = obstacle.name, np.asarray(obstacle.shape.center, float)
        self.mass = obstacle.mass / model.mesh.layout.copies
        self.gyration = filled.gyration
        self.arm = float(np.sqrt(np.trace(self.gyration) / 2))
        self.dofs = model.unknowns.apart_dofs[2 * number : 2 * number + 2].ravel()
        self._table, self._number = table, number
        self.mine = model.comm.rank == 0
        stiffness = max(body.stiffness for body in model.bodies) / self.arm
        self.stiffness = stiffness
        self.firm, self.soft = FIRMLY * stiffness, SOFTLY * stiffness
        self.rests = [Rest(self, obstacle, other) for other in others]
        self.still = self._mirrored(model)
        self._known: tuple[tuple[bytes, bytes], Motion] | None = None

    def _mirrored(self, model: Model) -> dict[int, float]:
        """Unknowns that symmetry holds. Raises SpecError where a plane does not halve the body."""
        held: dict[int, float] = {}
        for name, axis in model.mesh.layout.symmetry.items():
            nodes = model.surfaces.nodes(name)
            planes = model.comm.allgather(model.nodes.places[nodes, axis])
            off = abs(float(np.concatenate(planes).mean()) - self.centre[axis])
            beside = [c for c in range(3) if c != axis]
            if off > SAME * self.arm or np.any(np.abs(self.gyration[axis, beside]) > SAME):
                raise SpecError(
                    f"obstacles.{self.name}: a free body is its own mirror image; put its middle "
                    f"on the symmetry plane '{name}' and its sides along it, or model the whole "
                    "actuator"
                )
            held |= {int(self.dofs[c]): 0.0 for c in (axis, *(3 + c for c in beside))}
        return held

    # --- where it is ----------------------------------------------------------------------------

    def _last(self, state: State, what: str, default: np.ndarray) -> np.ndarray:
        kept = remembered(state, f"{CONTACT}{self.name}", what)
        return default if kept is None else kept

    def place(self, state: State) -> np.ndarray:
        """Where it was (6,) at the last equilibrium, mm."""
        return self._last(state, "body", np.zeros(6))

    def motion(self, state: State, x: np.ndarray | None = None) -> Motion:
        """Where it is at the unknowns ``x`` (local,), by default those of the state."""
        q = (state.x if x is None else x)[self.dofs]
        before, start = self.place(state), self._last(state, "turn", np.eye(3))
        delta = (q - before)[3:] / self.arm
        key = q.tobytes() + delta.tobytes(), start.tobytes()
        if self._known is None or self._known[0] != key:
            turn = RotationVector(delta)
            first, second = turn.first @ start / self.arm, turn.second @ start / self.arm**2
            self._known = key, Motion(q[:3], turn.matrix @ start, first, second)
        return self._known[1]

    def pose(self, state: State, x: np.ndarray | None = None) -> Pose:
        """See ``motion``."""
        found = self.motion(state, x)
        return Pose(found.shift, found.turn, self.centre)

    def remember(self, state: State) -> dict[str, np.ndarray]:
        """What is to be kept of an equilibrium; from it the rotation counts on."""
        q = state.x[self.dofs]
        kept = {"body": q.copy(), "turn": self.motion(state).turn}
        if self.held(state) == 1.0:
            kept["grip"] = self._grip(state)
        else:
            kept["anchor"] = q.copy()
        found = {f"{CONTACT}{self.name}.{what}": value for what, value in kept.items()}
        for rest in self.rests:
            found |= rest.remember(state)
        return found

    # --- what acts on it beside contact ---------------------------------------------------------

    def held(self, state: State) -> float:
        """See the class."""
        return float(state["hold"].get(self.name, 0.0))

    def _grip(self, state: State) -> np.ndarray:
        """Out-of-balance force (6,) N of what holds it in place."""
        return self.firm * (state.x[self.dofs] - self._last(state, "anchor", np.zeros(6)))

    def hold_force(self, state: State) -> np.ndarray:
        """Out-of-balance force (6,) N of what holds it in place, or fades."""
        held = self.held(state)
        if held == 1.0:
            return self._grip(state)
        return held * self._last(state, "grip", np.zeros(6))

    def weight(self, state: State) -> np.ndarray:
        """Weight (3,) N of the meshed part."""
        gravity = state["gravity"].get(EVERYTHING)
        return np.zeros(3) if gravity is None else self.mass * np.asarray(gravity)

    def resistance(self, state: State) -> np.ndarray:
        """Out-of-balance force (6,) N of the soft spring."""
        return self.soft * (state.x[self.dofs] - self.place(state))

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``: on the process that owns its unknowns."""
        if not self.mine:
            return
        out[self.dofs[:3]] -= self.weight(state)
        out[self.dofs] += self.resistance(state)
        for rest in self.rests:
            out[self.dofs] += rest.force(state)
        out[self.dofs] += self.hold_force(state)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        if self.mine:
            held = self.firm if self.held(state) == 1.0 else 0.0
            rests = sum((rest.tangent(state) for rest in self.rests), np.zeros((6, 6)))
            self.add_to_matrix((held + self.soft) * np.eye(6) + rests)

    def add_to_matrix(self, block: np.ndarray) -> None:
        """Add a matrix (6, 6) of its own unknowns to the tangent."""
        self._table.add(block.reshape(1, 2, 3, 2, 3), np.array([self._number]))

    def energy(self, state: State) -> float:
        """See ``Term``."""
        if not self.mine:
            return 0.0
        q, held = state.x[self.dofs], self.held(state)
        found = -float(self.weight(state) @ q[:3])
        found += float(self.resistance(state) @ (q - self.place(state))) / 2
        found += sum(rest.energy(state) for rest in self.rests)
        force = self.hold_force(state)
        return found + float(force @ force / (2 * self.firm) if held == 1.0 else force @ q)

    @property
    def mass_matrix(self) -> np.ndarray:
        """(6, 6) tonne, of its unknowns as it was placed."""
        matrix = self.mass * np.eye(6)
        matrix[3:, 3:] = self.mass * self.gyration / self.arm**2
        return matrix
