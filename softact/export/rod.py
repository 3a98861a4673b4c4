"""The reduced model as a simulator would compute it: a rod of pieces of constant curvature.

It needs numpy alone and nothing else of softact: the functional mock-up unit takes this file along.
Lengths in mm, forces in N, pressures in kPa as in curve.csv, stresses in MPa, masses in tonne.

A piece i of undeformed length l has strains w = (twist, curvature about y, curvature about z, both
in 1/mm; stretch) and per undeformed length the energy ½ (w − w₀(p))ᵀ K(p) (w − w₀(p)) − v₀(p) p, of
which everything follows: its moments and axial force K (w − w₀), and, since the energy is one
function, the volume that it takes (Maxwell's relation): v = v₀ + dwᵀ K w₀′ − ½ dwᵀ K′ dw with
dw = w − w₀ and ′ for d/dp. So no cycle of pressure and load makes energy out of nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

COMPONENTS = ("twist", "bending_y", "bending_z", "stretch")
AT_ONCE = 256  # states that are solved together, for want of memory
TURNS = 0.5  # largest change of a curvature in one iteration, radians a piece


def cross_matrices(vectors: np.ndarray) -> np.ndarray:
    """(..., 3, 3) matrices of the cross product with (..., 3) vectors."""
    zero = np.zeros(vectors.shape[:-1])
    x, y, z = np.moveaxis(vectors, -1, 0)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def rotations(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation matrices of rotation vectors (..., 3), and the mean of the rotation on the way.

    The second maps a tangent to the chord of an arc that turns by the vector (Rodrigues).
    """
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    safe = np.maximum(angle, 1e-6)
    small = angle < 1e-4
    first = np.where(small, 1 - angle**2 / 6, np.sin(safe) / safe)
    second = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    third = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    cross = cross_matrices(vectors)
    square = cross @ cross
    return np.eye(3) + first * cross + second * square, np.eye(3) + second * cross + third * square


def blocking_lever(active: float, end: float) -> float:
    """1/mm: force across the tip by the moment that the rod would turn with, where the force holds
    the tip's centre on the axis and lets it turn; small deflections.

    active: length that bends, mm; end: of the stiff part at the tip.
    """
    whole = active + end
    return 1.5 * (whole**2 - end**2) / (whole**3 - end**3)


class Rod:
    """A reduced model, from the data of ``model.json``.

    All directions are those of the model: x from the clamp to the tip, y and z across; the clamp's
    centre is the origin.
    """

    def __init__(self, data: Mapping[str, Any]):
        self.pieces = int(data["pieces"])
        self.start, self.end = float(data["start_mm"]), float(data["end_mm"])
        self.active = float(data["active_length_mm"])
        self.offset = np.array([0.0, data["offset_y_mm"], data["offset_z_mm"]])
        tip = np.array([self.end, data["tip_y_mm"], data["tip_z_mm"]])
        self.arm = tip - self.offset  # from the rod's end to the tip's centre
        self.free = np.array([name in data["components"] for name in COMPONENTS])
        table = data["table"]
        self.pressure = np.array(table["pressure_kPa"], float)
        self.rest_table = np.array([table[f"rest_{c}"] for c in COMPONENTS], float).T
        self.stiffness_table = np.array([table[f"stiffness_{c}"] for c in COMPONENTS], float).T
        self.volume_table = np.array(table["rest_volume_mm3"], float)
        masses = data["masses"]
        self.masses = np.array(masses["mass_tonne"], float)  # clamp's end, pieces, tip's end
        self.centres = np.array(masses["centre_mm"], float)  # from the middle of each, on the rod

    # --- what depends on the pressure alone -------------------------------------------------

    def _table(self, table: np.ndarray, pressure: ArrayLike) -> np.ndarray:
        """Linear between the rows; outside, the first or last value."""
        pressure = np.asarray(pressure, float)
        columns = [np.interp(pressure, self.pressure, column) for column in table.T]
        return np.stack(columns, axis=-1)

    def rest(self, pressure: ArrayLike) -> np.ndarray:
        """(..., 4) strains that the rod takes without a load."""
        return self._table(self.rest_table, pressure)

    def stiffness(self, pressure: ArrayLike) -> np.ndarray:
        """(..., 4) N·mm² for twist and curvatures, N for the stretch."""
        return self._table(self.stiffness_table, pressure)

    def rest_volume(self, pressure: ArrayLike) -> np.ndarray:
        """(...,) mm³ without a load."""
        return np.interp(np.asarray(pressure, float), self.pressure, self.volume_table)

    # --- shape ------------------------------------------------------------------------------

    def shape(self, strains: np.ndarray) -> tuple[np.ndarray, ...]:
        """Frames along rods of strains (m, pieces, 4).

        Returns ends (m, pieces + 1, 3) and frames there (m, pieces + 1, 3, 3), and the same in the
        middles of the pieces. Positions are those of the rod's line; the tip's centre is ``tip``.
        """
        length = self.active / self.pieces
        turn, half = rotations(strains[..., :3] * length), rotations(strains[..., :3] * length / 2)
        stretched = length * (1 + strains[..., 3])[..., None]
        steps = stretched * turn[1][..., 0], stretched / 2 * half[1][..., 0]
        place = np.zeros((len(strains), 3)) + self.offset + [self.start, 0.0, 0.0]
        frame = np.broadcast_to(np.eye(3), (len(strains), 3, 3))
        ends, frames, middles, middle_frames = [place], [frame], [], []
        for i in range(self.pieces):
            middles.append(place + (frame @ steps[1][:, i, :, None])[..., 0])
            middle_frames.append(frame @ half[0][:, i])
            place = place + (frame @ steps[0][:, i, :, None])[..., 0]
            frame = frame @ turn[0][:, i]
            ends.append(place)
            frames.append(frame)
        stacked = ends, frames, middles, middle_frames
        return tuple(np.stack(part, axis=1) for part in stacked)

    def tip(self, strains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Centre (m, 3) of the tip's end face and its frame (m, 3, 3)."""
        ends, frames, _, _ = self.shape(strains)
        return ends[:, -1] + frames[:, -1] @ self.arm, frames[:, -1]

    # --- equilibrium ------------------------------------------------------------------------

    def loads(
        self, strains: np.ndarray, force: np.ndarray, moment: np.ndarray, gravity: np.ndarray
    ) -> np.ndarray:
        """(m, pieces, 4) moments (N·mm) and axial forces (N) in the middles of the pieces, from
        what acts beyond them.

        force, moment (m, 3): at the tip's centre, dead. gravity (m, 3): mm/s².
        """
        ends, frames, middles, middle_frames = self.shape(strains)
        tip = ends[:, -1] + frames[:, -1] @ self.arm
        end_middle = np.array([self.end / 2, 0.0, 0.0]) + self.centres[-1]
        places = np.concatenate(
            [middles + (middle_frames @ self.centres[1:-1, :, None])[..., 0],
             (ends[:, -1] + frames[:, -1] @ end_middle)[:, None], tip[:, None]], axis=1
        )  # fmt: skip
        weights = self.masses[1:, None] * gravity[:, None, :]
        forces = np.concatenate([weights, force[:, None, :]], axis=1)
        # What acts on piece i itself counts by one half: it is spread over the piece.
        halves = forces[:, : self.pieces] / 2
        beyond = _sums_from_behind(forces)[:, 1 : self.pieces + 1] + halves
        turning = np.cross(places, forces)
        turned = _sums_from_behind(turning)[:, 1 : self.pieces + 1]
        turned = turned + turning[:, : self.pieces] / 2
        about = turned - np.cross(middles, beyond) + moment[:, None, :]
        local = np.swapaxes(middle_frames, -1, -2)
        axial = (local @ beyond[..., None])[..., 0, 0]
        return np.concatenate([(local @ about[..., None])[..., 0], axial[..., None]], axis=-1)

    def solve(
        self,
        pressure: ArrayLike,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        gravity: ArrayLike | None = None,
        tolerance: float = 1e-8,
    ) -> np.ndarray:
        """Strains (m, pieces, 4) in equilibrium at m pressures (kPa) and loads; see ``loads``.

        Newton's method with the residual's differences; raises ArithmeticError where it fails.
        """
        all_at = np.atleast_1d(np.asarray(pressure, float))
        m = len(all_at)
        loads = [
            np.zeros((m, 3)) + (0.0 if load is None else np.asarray(load, float))
            for load in (force, moment, gravity)
        ]
        parts = [slice(start, start + AT_ONCE) for start in range(0, m, AT_ONCE)]
        solved = [self._solve(all_at[p], [load[p] for load in loads], tolerance) for p in parts]
        return np.concatenate([np.zeros((0, self.pieces, 4)), *solved])

    def _solve(self, pressure: np.ndarray, loads: list[np.ndarray], tolerance: float) -> np.ndarray:
        m = len(pressure)
        rest, stiffness = self.rest(pressure)[:, None], self.stiffness(pressure)[:, None]
        strains = np.repeat(rest, self.pieces, axis=1)
        size = np.array([1 / self.active] * 3 + [1.0])  # a radian over the rod, a stretch of one
        free = np.flatnonzero(self.free)
        unknowns = self.pieces * len(free)

        def residual(strains: np.ndarray, copies: int = 1) -> np.ndarray:
            repeated = [np.repeat(load, copies, axis=0) for load in loads]
            at = [np.repeat(part, copies, axis=0) for part in (rest, stiffness)]
            found = strains - at[0] - self.loads(strains, *repeated) / at[1]
            return (found / size)[..., free].reshape(len(strains), unknowns)

        moves = np.zeros((unknowns, self.pieces, 4))
        moves[:, :, free] = np.eye(unknowns).reshape(unknowns, self.pieces, len(free))
        for _ in range(60):
            here = residual(strains)
            if np.abs(here).max(initial=0.0) < tolerance:
                return strains
            step = 1e-6
            moved = strains[:, None] + step * moves * size
            there = residual(moved.reshape(-1, self.pieces, 4), unknowns)
            slope = (there.reshape(m, unknowns, unknowns) - here[:, None]) / step
            try:
                change = np.linalg.solve(np.swapaxes(slope, 1, 2), -here[..., None])[..., 0]
            except np.linalg.LinAlgError:
                break
            most = TURNS * self.pieces
            change *= np.minimum(1.0, most / np.maximum(np.abs(change).max(axis=1), 1e-30))[:, None]
            strains = strains + np.einsum("mu,upc->mpc", change, moves) * size
        raise ArithmeticError("the reduced model finds no equilibrium under these loads")

    def state(
        self,
        pressure: ArrayLike,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        gravity: ArrayLike | None = None,
    ) -> dict[str, np.ndarray]:
        """What a run would have measured, see ``figures``, in equilibrium, see ``solve``."""
        at = np.atleast_1d(np.asarray(pressure, float))
        return self.figures(at, self.solve(at, force, moment, gravity))

    def figures(self, pressure: np.ndarray, strains: np.ndarray) -> dict[str, np.ndarray]:
        """Columns of curve.csv -> (m,) values of rods of strains (m, pieces, 4)."""
        place, _ = self.tip(strains)
        turned = strains[..., :3].mean(axis=1) * self.active
        angle = turned[:, 1]  # with its sign, where there is one plane of bending
        if self.free[COMPONENTS.index("bending_z")]:
            angle = np.hypot(turned[:, 1], turned[:, 2])
        found = {
            "bending_y_deg": np.degrees(turned[:, 1]),
            "bending_z_deg": np.degrees(turned[:, 2]),
            "bending_angle_deg": np.degrees(angle),
            "twist_angle_deg": np.degrees(turned[:, 0]),
            "cavity_volume_mm3": self.volume(pressure, strains),
        }
        return found | {f"tip_{c}_mm": place[:, i] for i, c in enumerate("xyz")}

    def volume(self, pressure: np.ndarray, strains: np.ndarray) -> np.ndarray:
        """(m,) mm³ of the driven cavities."""
        change = strains - self.rest(pressure)[:, None]
        step = 1e-3 * np.ptp(self.pressure)
        low = np.clip(pressure - step, self.pressure[0], self.pressure[-1])
        high = np.clip(pressure + step, self.pressure[0], self.pressure[-1])
        width = 1e-3 * (high - low)  # MPa
        moving = (self.rest(high) - self.rest(low)) / width[:, None]
        softening = (self.stiffness(high) - self.stiffness(low)) / width[:, None]
        first = (self.stiffness(pressure) * moving)[:, None] * change
        whole = (first - 0.5 * softening[:, None] * change**2)[..., self.free].sum(axis=(1, 2))
        return self.rest_volume(pressure) + self.active / self.pieces * whole


def _sums_from_behind(values: np.ndarray) -> np.ndarray:
    """(m, k, 3) sums from each entry to the last."""
    return np.cumsum(values[:, ::-1], axis=1)[:, ::-1]
