"""What the solver takes, of a spec: the model, its supports and its load steps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softact.bodies import BODIES
from softact.bodies.layer import BondedLayer
from softact.bodies.sheet import Ply, Sheet
from softact.contact.rigid import Obstacle
from softact.contact.surfaces import Touching
from softact.fields import COMPONENTS
from softact.geometry.flat_sheets import SheetGeometry
from softact.loads import LOADS
from softact.loads.load_step import LoadStep
from softact.loads.support import Spring, Support, Turn
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra, read_msh
from softact.mesh.tetrahedra import Mesh, distribute, of_sheets
from softact.model import Model
from softact.run.held import refuse_loose
from softact.spec import Spec
from softact.spec.path import joined, leaves
from softact.system.term import Value

if TYPE_CHECKING:
    from mpi4py import MPI

    from softact.spec import LayerSpec, Step, SupportSpec
    from softact.spec.films import SheetOfLayers
    from softact.spec.supports import TurnSpec

NO_PARAMETERS = ("description", "source", "assumptions", "measures")  # of a spec: no values


def build_model(comm: MPI.Comm, spec: Spec, mesh_file: Path) -> Model:
    """The ``Model`` of a spec on a mesh. Collective."""
    layout = spec.layout()
    if isinstance(spec.geometry, SheetGeometry):
        mesh = of_sheets(comm, spec.geometry.checked_mesh(), layout)
    else:
        mesh = distribute(comm, lambda: _read(mesh_file, layout, spec), layout)
    return model_on(mesh, spec)


def model_on(mesh: Mesh, spec: Spec, like: Model | None = None) -> Model:
    """The ``Model`` of a spec on a mesh that is spread over the processes. like: see ``Model``."""
    return Model(
        mesh,
        {name: law.material() for name, law in spec.materials.items()},
        [_layer(layer) for layer in spec.layers],
        spec.solver.element,
        spec.geometry.wall_normal,
        _obstacles(spec),
        _touching(spec),
        {name: _sheet(sheet) for name, sheet in spec.sheets.items()},
        {"springs": _springs(spec), **_more(spec)},
        like,
    )


def _more(spec: Spec) -> dict[str, Any]:
    """What bodies of further kinds are made of."""
    values = {key: getattr(spec, key) for key, kind in BODIES.items() if kind.annotation}
    return {key: BODIES[key].parts(value) for key, value in values.items() if value is not None}


def _read(mesh_file: Path, layout: Layout, spec: Spec) -> Tetrahedra:
    tets = read_msh(mesh_file, layout)
    refuse_loose(tets, layout, spec)
    return tets


def _layer(layer: LayerSpec) -> BondedLayer:
    relaxed = layer.wrinkling and layer.wrinkling == "tension_field"
    return BondedLayer(layer.surface, layer.material, layer.thickness, layer.bending, relaxed)


def _sheet(sheet: SheetOfLayers) -> Sheet:
    plies = [Ply(ply.material, ply.thickness, ply.angle, ply.incompressible) for ply in sheet.plies]
    relaxed = sheet.wrinkling == "tension_field"
    return Sheet(plies, relaxed, sheet.bending, sheet.axis)


def supports_of(supports: Iterable[SupportSpec]) -> list[Support]:
    """The ``Support``s of a spec or of one of its steps."""
    return [Support(s.surface, s.values, _turn(s.turn)) for s in supports if s.values or s.turn]


def _turn(turn: TurnSpec | None) -> Turn | None:
    return None if turn is None else Turn(turn.axis, turn.angle, turn.about)


def _springs(spec: Spec) -> list[Spring]:
    found = []
    for support in spec.supports or ():
        if support.spring:
            x, y, z = (support.spring.get(component, 0.0) for component in COMPONENTS)
            found.append(Spring(support.surface, (x, y, z)))
    return found


def _obstacles(spec: Spec) -> list[Obstacle]:
    turned = {n for step in spec.steps for n, o in (step.obstacles or {}).items() if o.turn}
    return [
        Obstacle(
            name,
            o.shape(),
            o.friction,
            o.active,
            o.load_cell,
            o.surfaces,
            o.mass or 0.0,
            o.held,
            name in turned,
        )
        for name, o in spec.obstacles.items()
    ]


def _touching(spec: Spec) -> list[Touching]:
    return [Touching(c.name, c.groups, c.friction, c.distance) for c in spec.contact or ()]


def load_steps(spec: Spec, model: Model) -> list[LoadStep]:
    """The ``LoadStep``s of a spec on its model. Collective."""
    return [_load_step(step, model) for step in spec.steps]


def _load_step(step: Step, model: Model) -> LoadStep:
    loads: dict[str, Mapping[str, Value]] = {}
    for key, value in step.loads.items():
        loads |= LOADS[key].ends(value, model)
    supports = supports_of(step.supports) if step.supports is not None else None
    timing = step.timing(model.mesh.layout)
    return LoadStep(step.name, supports, step.largest_increment, timing, **loads)


def parameters(spec: Spec) -> dict[str, Any]:
    """The spec's values as columns: 'geometry.wall' -> '1 mm', 'steps.1.pressure.cavity' -> ..."""
    dumped = spec.model_dump(mode="json", exclude_none=True)
    values = leaves({key: value for key, value in dumped.items() if key not in NO_PARAMETERS})
    return {joined(place): value for place, value in values if value not in ({}, [])}
