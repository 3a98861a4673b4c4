"""From a mesh and a law to an equilibrium, and what the tests read from it."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field

import numpy as np
from mpi4py import MPI

from softact.loads.load_step import LoadStep
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from softact.solve.progress import Trying
from softact.solve.settings import Settings
from softact.solve.stepping import Stepper
from softact.system.term import State

CLAMP = Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0})
ROLLERS = [Support(f"{axis}_min", {number: 0.0}) for number, axis in enumerate("xyz")]


def build(
    tets: Tetrahedra,
    law,
    element: str = "P2/P1",
    layers=(),
    cavities=None,
    symmetry=None,
    wall_normal=lambda region, points: (0.0, 0.0, 1.0),
    obstacles=(),
    touching=(),
    more=None,
    **layout,
) -> Model:
    """A model of one material on a mesh of ``meshes``; ``layout``: further fields of Layout;
    more: further kinds of bodies."""
    names = {"clamp": "x_min", "tip": "x_max"} | layout
    whole = Layout(
        regions=("body",),
        surfaces=tuple(tets.surfaces),
        cavities=cavities or {},
        symmetry=symmetry or {},
        **names,
    )
    mesh = distribute(MPI.COMM_SELF, lambda: tets, whole)
    materials = {"body": law.material()}
    return Model(mesh, materials, layers, element, wall_normal, obstacles, touching, more=more)


@dataclass
class Solution:
    """An equilibrium at the end of the steps, and the accepted states on the way.

    path: all accepted states, the unloaded one first. ends: those at the end of each step. tried:
    what was told at each iteration.
    """

    model: Model
    stepper: Stepper
    path: list[State] = field(default_factory=list)
    ends: list[State] = field(default_factory=list)
    tried: list[Trying] = field(default_factory=list)

    @property
    def state(self) -> State:
        """The last state."""
        return self.stepper.state

    def displacement(self, point) -> np.ndarray:
        """Displacement (3,) in mm of the node at ``point``."""
        return displacement(self.model, self.state, point)

    def reaction(self, surface: str, state: State | None = None) -> np.ndarray:
        """Force (3,) in N that holds the nodes of a surface, in the last state or another."""
        force, _ = self.model.force(state or self.state)
        return force[self.model.displacement_dofs[self.model.surfaces.nodes(surface)]].sum(axis=0)


def displacement(model: Model, state: State, point) -> np.ndarray:
    """Displacement (3,) in mm of the node at ``point``."""
    places = model.nodes.places
    gaps = np.linalg.norm(places - point, axis=1)
    assert gaps.min() < 1e-6, f"no node at {point}"
    return state.x[model.displacement_dofs[gaps.argmin()]]


def solve(
    model: Model, steps, supports, increment: float = 1.0, stops: bool = False, **settings
) -> Solution:
    """Run the steps (one or a list); fails where no equilibrium is found, unless it is to stop."""
    path, ends, tried = [], [], []

    def keep(state, attempt, number):
        path.append(State(**{name: copy(value) for name, value in vars(state).items()}))
        if attempt.fraction == 1.0:
            ends.append(path[-1])

    increments = {"initial_increment": increment, "max_increment": increment}
    settings = Settings(**increments | settings)
    stepper = Stepper(model, settings, keep, on_iteration=tried.append)
    steps = [steps] if isinstance(steps, LoadStep) else steps
    progress = stepper.run(steps, supports)
    assert stops == bool(progress.stopped), progress.stopped
    return Solution(model, stepper, path, ends, tried)
