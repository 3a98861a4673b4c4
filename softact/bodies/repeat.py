"""One module of a long chain of equal ones: two faces that a rigid motion relates.

The right face is where a rigid motion takes the left one: x₊ = c + R (x₋ − c) + t, with c the
middle of the undeformed left face, R by a rotation vector ω and t a translation. Only ω, t and the
left face are unknowns; the right face follows exactly, pressures too. A chain then repeats
its state, turned by R each time (the helical Cauchy-Born rule; Kumar, Kumar and Gupta,
Proc. R. Soc. A 2016). With J the derivative of all unknowns by these, the out-of-balance force is
Jᵀ r; what it holds at ω and t are the moment and force of a cross-section. The tangent is Jᵀ K J
and the second derivative of the motion.

The module as a whole is held by multipliers at the mean displacement and rotation of its left face:
points that are pinned would be loaded where moments and forces are given.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse
from scipy.spatial import cKDTree

from softact.bodies.images import Images
from softact.bodies.plate import LayerBending
from softact.errors import SpecError
from softact.mesh.layout import COMPONENTS, Repeats, free_components
from softact.system.rotation import RotationVector

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.term import State

THREES = 4  # of unknowns: ω by the pitch, t beyond the pitch, and the multipliers of both
SAME = 1e-6  # of the pitch: points of the two faces that are nearer are one
AS_WELL = 1e-3  # of that: how much nearer a point is on a sheet that faces the same way


class Repeat:
    """The two faces of a model. Lengths in mm, forces in N, moments in N·mm.

    pitch: (3,) from the left face to the right one, undeformed. centre: (3,) c. free: (6,) which of
    ``COMPONENTS`` are unknowns or held, not zero by symmetry. dofs: (6,) their unknowns. follows:
    unknowns that the motion gives.
    """

    def __init__(self, model: Model, faces: Repeats):
        self._model, self.faces = model, faces
        places, dofs = model.nodes.places, model.displacement_dofs
        left, right = (model.surfaces.nodes(name) for name in (faces.left, faces.right))
        shares = model.surfaces.shares
        middles = [
            share @ places[nodes] for nodes, share in (shares(faces.left), shares(faces.right))
        ]
        self.centre, self.pitch = middles[0], middles[1] - middles[0]
        self.length = float(np.linalg.norm(self.pitch))
        right = right[self._partners(left, right)]
        self.left_nodes, self.right_nodes = left, right
        self._places = places[left] - self.centre, places[right] - self.centre
        self.left, self.right = dofs[left], dofs[right]
        self._pressures = self._pressure_pairs(model)
        self._apart = model.unknowns.apart_dofs
        self.dofs = self._apart[:2].ravel()
        self._images = self.images(left)
        self.free = free_components(model.mesh.layout.symmetry).ravel()
        self.scale = np.repeat([1 / self.length, 1.0], 3)  # rad or mm of an unknown
        self._gauge = self._held_means(left)
        self._turned: tuple[np.ndarray, RotationVector] | None = None
        self._raw: tuple[np.ndarray, np.ndarray] | None = None
        for term in model.elastic:
            if isinstance(term, LayerBending):
                term.go_on(self)
        self._lay_out()

    def _partners(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Which nodes of the right face (n,) lie where the left ones (n,) do; of two that lie on
        each other, that on the sheet which faces the same way."""
        places, facing = self._model.nodes.places, SAME * AS_WELL * self.length * self._facing()
        own = np.hstack([places[left] + self.pitch, facing[left]])
        gaps, partner = cKDTree(np.hstack([places[right], facing[right]])).query(own)
        lonely = int((gaps > SAME * self.length).sum()) + abs(len(left) - len(right))
        lonely += len(partner) - len(np.unique(partner))
        if lonely:
            raise SpecError(
                f"module: the meshes of '{self.faces.left}' and '{self.faces.right}' do not match: "
                f"{lonely} of {max(len(left), len(right))} points have no partner on the other "
                "face; they are to be the same face, moved, with the same triangles"
            )
        return partner

    def _facing(self) -> np.ndarray:
        """The mean normal of the sheets at each node (nodes, 3), zero where there are none."""
        found = np.zeros((len(self._model.nodes.places), 3))
        for part in self._model.sheets.values():
            normals = part.triangles.areas[:, None] * part.triangles.normals
            np.add.at(found, part.triangles.nodes, normals[:, None])
        return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), SAME)

    def _pressure_pairs(self, model: Model) -> tuple[np.ndarray, np.ndarray]:
        """Pressure unknowns of the left face and of their partners on the right one."""
        spaces = model.unknowns.spaces[1:]
        if not spaces:
            return np.empty(0, int), np.empty(0, int)
        places, dofs = spaces[0].tabulate_dof_coordinates(), model.unknowns.space_dofs[1][:, 0]
        tree = cKDTree(places - self.centre)
        (gaps, mine), (_, partner) = (tree.query(face) for face in self._places)
        corner = gaps < SAME * self.length  # of quadratic faces, the middles have no pressure
        return dofs[mine[corner]], dofs[partner[corner]]

    def _held_means(self, left: np.ndarray) -> np.ndarray:
        """Rows (6, n, 3) of the mean displacement and rotation of the left face, N/mm."""
        nodes, share = self._model.surfaces.shares(self.faces.left)
        weight = np.zeros(len(self._model.nodes.places))
        weight[nodes] = share
        arms, w = self._places[0] / self.length, weight[left][:, None]
        rows = [w * np.eye(3)[c] for c in range(3)]
        rows += [w * np.cross(np.eye(3)[c], arms) for c in range(3)]
        stiffness = max(body.stiffness for body in self._model.bodies) / self.length
        keep = np.concatenate([self.free[3:], self.free[:3]])
        return stiffness * keep[:, None, None] * np.array(rows)

    @property
    def rows_of_multipliers(self) -> np.ndarray:
        """Their unknowns (6,): of the mean displacement, then of the rotation."""
        return self._apart[2:].ravel()

    def images(self, nodes: np.ndarray, modules: np.ndarray | None = None) -> Images:
        """Of nodes (n,) of the model, see ``Images``."""
        rest = self._model.nodes.places[nodes] - self.centre
        return Images(self, rest, self._model.displacement_dofs[nodes], modules)

    # --- the motion -----------------------------------------------------------------------------

    def motion(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation vector (3,) rad and translation t (3,) mm."""
        turn, shift = x[self._apart[:2]]
        return turn / self.length, self.pitch + shift

    def turned(self, x: np.ndarray) -> RotationVector:
        """R and its derivatives by ω; kept, since it is asked for again and again."""
        turn = self.motion(x)[0]
        if self._turned is None or not np.array_equal(self._turned[0], turn):
            self._turned = turn.copy(), RotationVector(turn)
        return self._turned[1]

    def follow(self, x: np.ndarray) -> np.ndarray:
        """Put the right face where the motion takes the left one, in place."""
        x[self.right] = self._images.places(x) - self._places[1]
        x[self._pressures[1]] = x[self._pressures[0]]
        return x

    def held(self) -> dict[int, float]:
        """Unknowns that keep a value: those that symmetry or ``hold`` gives."""
        values = {int(d): 0.0 for d, free in zip(self.dofs, self.free, strict=True) if not free}
        rest = np.concatenate([np.zeros(3), self.pitch])
        for name, value in self.faces.hold.items():
            i = COMPONENTS.index(name)
            values[int(self.dofs[i])] = (value - rest[i]) / self.scale[i]
        return values

    # --- force and tangent ----------------------------------------------------------------------

    def condense(self, x: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Jᵀ of a force (local,), as a new array."""
        out = force.copy()
        self._images.pull(x, force[self.right], out)
        out[self._pressures[0]] += force[self._pressures[1]]
        out[self.right], out[self._pressures[1]] = 0.0, 0.0
        return out

    def force(self, state: State, raw: np.ndarray) -> np.ndarray:
        """The out-of-balance force, of that of a body whose right face is free (local,)."""
        self._raw = state.x.copy(), raw
        out = self.condense(state.x, raw)
        rows = self.rows_of_multipliers
        out[self.left] += np.tensordot(state.x[rows], self._gauge, 1)
        out[rows] += np.tensordot(self._gauge, state.x[self.left], 2)
        out[rows] -= self._idle * state.x[rows]
        return out

    @property
    def _idle(self) -> np.ndarray:
        """1 (6,) at multipliers that hold what symmetry holds already."""
        return (~np.concatenate([self.free[3:], self.free[:3]])).astype(float)

    def _jacobian(self, x: np.ndarray) -> scipy.sparse.csr_matrix:
        """J (local, local), the identity but at the right face. Its entries are always the same."""
        follow, by, values = self._images.jacobian(x, self.right)
        size = self._model.unknowns.local
        others = np.setdiff1d(np.arange(size), self.follows)
        same = np.ones(len(self._pressures[0]) + len(others))
        rows = np.concatenate([follow, self._pressures[1], others])
        columns = np.concatenate([by, self._pressures[0], others])
        return scipy.sparse.csr_matrix(
            (np.append(values, same), (rows, columns)), shape=(size, size)
        )

    def carried(self, x: np.ndarray) -> scipy.sparse.csr_matrix:
        """The part of J (local, local) by which the right face follows the left one alone."""
        matrix, n = self.turned(x).matrix, len(self.left)
        rows = [np.repeat(self.right, 3, axis=1).ravel(), self._pressures[1]]
        columns = [np.tile(self.left, 3).ravel(), self._pressures[0]]
        values = [np.tile(matrix.ravel(), n), np.ones(len(self._pressures[0]))]
        size = self._model.unknowns.local
        return scipy.sparse.csr_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(size, size),
        )

    def _lay_out(self) -> None:
        """Make room in the matrix for what the right face's rows and columns become."""
        assembler, size = self._model.assembler, self._model.unknowns.local
        follows = np.zeros(size, dtype=bool)
        follows[self.right], follows[self._pressures[1]] = True, True
        self.follows = np.flatnonzero(follows)
        both = assembler.pattern, assembler.beyond
        self._touched = [np.flatnonzero(follows[i] | follows[j]) for i, j in both]
        entries = [(i[at], j[at]) for (i, j), at in zip(both, self._touched, strict=True)]
        self._entries = tuple(np.concatenate(each) for each in zip(*entries, strict=True))
        ones = self._folded(np.ones(len(self._entries[0])), self._ones())
        apart = self._apart.ravel()
        face = np.concatenate([self.left.ravel(), apart])
        border = np.repeat(face, len(apart)), np.tile(apart, len(face))
        keys = [(ones.row, ones.col), border, border[::-1], (self.follows, self.follows)]
        self._keys = np.unique(np.concatenate([self._key(*pair) for pair in keys]))
        self._slots = assembler.couple(*np.divmod(self._keys, size))

    def _key(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """One number for each entry of the matrix."""
        return rows.astype(np.int64) * self._model.unknowns.local + columns

    def _ones(self) -> scipy.sparse.csr_matrix:
        jacobian = self._jacobian(np.zeros(self._model.unknowns.local))
        jacobian.data[:] = 1.0
        return jacobian

    def _folded(
        self, values: np.ndarray, jacobian: scipy.sparse.csr_matrix
    ) -> scipy.sparse.coo_matrix:
        size = self._model.unknowns.local
        matrix = scipy.sparse.csr_matrix((values, self._entries), shape=(size, size))
        return (jacobian.T @ matrix @ jacobian).tocoo()

    def fold_tangent(self, state: State) -> None:
        """Turn the assembler's matrix K, of a free right face, into that of the unknowns."""
        assembler, fixed = self._model.assembler, self._model.assembler.fixed
        raw, all_values = [], (assembler.values, assembler.extra_values)
        for values, at in zip(all_values, self._touched, strict=True):
            raw.append(values[at])
            values[at] = 0.0
        folded = self._folded(np.concatenate(raw), self._jacobian(state.x))
        rows, columns, values = self._beyond(state)
        entries = np.append(self._key(folded.row, folded.col), self._key(rows, columns))
        at = np.searchsorted(self._keys, entries)
        out = np.bincount(at, np.append(folded.data, values), len(self._keys))
        # As many pivots are negative as there are pressures, those that follow among them.
        diagonal = np.searchsorted(self._keys, self._key(self.follows, self.follows))
        out[diagonal] = np.where(np.isin(self.follows, self._pressures[1]), -1.0, 1.0)
        # Fixed unknowns have their 1 from the assembler.
        row, column = np.divmod(self._keys, self._model.unknowns.local)
        assembler.extra_values[self._slots] += out * (fixed[row] == 0) * (fixed[column] == 0)

    def _beyond(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and values of the motion's second derivative and of the multipliers."""
        rows, left = self.rows_of_multipliers, self.left.ravel()
        down, across = np.repeat(rows, len(left)), np.tile(left, len(rows))
        gauge, idle = self._gauge.ravel(), -self._idle
        found = [self._images.second(state.x, self._push(state))]
        found += [(down, across, gauge), (across, down, gauge), (rows, rows, idle)]
        down, across, values = (np.concatenate(each) for each in zip(*found, strict=True))
        return down, across, values

    def _push(self, state: State) -> np.ndarray:
        """Forces (n, 3) at the right face."""
        if self._raw is None or not np.array_equal(self._raw[0], state.x):
            self._model.force(state)
        assert self._raw is not None
        return self._raw[1][self.right]
