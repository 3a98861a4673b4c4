"""What a spec holds: frozen, strict models. Inside, every value is in internal units."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    create_model,
    field_serializer,
    model_validator,
)
from pydantic_core import ErrorDetails, InitErrorDetails
from pydantic_core.core_schema import ErrorType

from softact.bodies import BODIES
from softact.bodies.base import BodyKind
from softact.fields import Name, Part, Point, fault
from softact.files.text import digest
from softact.geometry.base import Geometry
from softact.geometry.imported import Imported
from softact.loads import LOADS
from softact.loads.base import Load
from softact.loads.timing import Timing
from softact.mesh.layout import Layout
from softact.spec.building import changed
from softact.spec.checks import cross_faults, fibre_faults
from softact.spec.choice import MaterialChoice
from softact.spec.contact import AUTO, AnyObstacle, Contacts, resolved_contact
from softact.spec.fields import GEOMETRY, AnyGeometry, AnyMaterial, Measures
from softact.spec.films import LayerSpec, SheetOfLayers
from softact.spec.modules import ModuleSpec
from softact.spec.path import UNNAMED
from softact.spec.slots import walk
from softact.spec.solver import Solver
from softact.spec.supports import LineSpec, SupportSpec
from softact.spec.target_line import TargetLine
from softact.spec.text import to_text
from softact.spec.timing import AmplitudeSpec, DynamicsSpec, inertia_faults, timing, with_contents
from softact.spec.tolerances import AnyTolerance
from softact.units import Dimensionless, Time


class StepBase(Part):
    """A change of the loads or supports; loads ramp linearly from their last value.

    With a duration or an amplitude the step has a clock.
    """

    name: Name = Field("", description="default: step_1, step_2, ...")
    supports: tuple[SupportSpec, ...] | None = Field(
        None, strict=False, description="replace the supports from this step on"
    )
    max_increment: Dimensionless | None = Field(
        None,
        gt=0,
        le=1,
        description="largest increment of this step; default: the solver's, and 1 where only "
        "gravity changes",
    )

    duration: Time | None = Field(
        None,
        gt=0,
        description="how long it lasts; without one it has no clock, and all that creeps has come "
        "to its end",
    )
    amplitude: AmplitudeSpec | None = Field(
        None,
        description="how loads go in that time: ramp (default), smooth, hold, sudden, {sine: ...}, "
        "{triangle: ...} or {file: NAME.csv}",
    )
    dynamics: DynamicsSpec | None = Field(
        None, description="true, or {spectral_radius: 0.8}: with inertia, in real time"
    )

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        still = self.supports is None and not self.loads
        waits = self.amplitude and (self.amplitude.shape == "hold" or self.amplitude.file)
        if still and not waits and self.dynamics is None:
            raise fault(f"this step changes nothing; give it {', '.join(LOADS)} or supports")
        return self

    @model_validator(mode="after")
    def _inertia_has_a_clock(self) -> Self:
        if self.dynamics is not None and self.duration is None and self.amplitude is None:
            raise fault("dynamics needs a duration; write for example duration: 0.5 s")
        return self

    @model_validator(mode="after")
    def _has_one_clock(self) -> Self:
        amplitude = self.amplitude
        if amplitude is None:
            return self
        if amplitude.own_duration is None and self.duration is None:
            raise fault("an amplitude needs a duration; write for example duration: 2 s")
        if amplitude.own_duration is not None and self.duration is not None:
            says = "the file" if amplitude.file else "frequency and cycles"
            raise fault(f"{says} says how long the step lasts; leave duration out")
        if amplitude.shape == "hold" and (self.loads or any(s.move for s in self.supports or ())):
            raise fault("hold leaves loads as they are; change them in a step before it")
        if amplitude.file and {"pressure", "inject"} & set(self.loads):
            raise fault("the file gives the pressures; leave pressure and inject out")
        return self

    @property
    def loads(self) -> dict[str, Any]:
        """What the step loads: key -> value, without what it leaves alone."""
        written = {key: getattr(self, key) for key in LOADS}
        return {key: value for key, value in written.items() if value is not None}

    def for_layout(self, layout: Layout) -> Self:
        """The step with all that the geometry fills in."""
        filled = {key: LOADS[key].for_layout(value, layout) for key, value in self.loads.items()}
        return self.model_copy(update=filled)

    def timing(self, layout: Layout) -> Timing | None:
        """The step's clock; None where it has none."""
        return timing(self.duration, self.amplitude, tuple(layout.cavities), self.dynamics)

    @property
    def largest_increment(self) -> float | None:
        """``max_increment`` with its default for loads that are seldom hard; None: solver's."""
        clocked = self.duration is not None or self.amplitude is not None
        easy = self.supports is None and not clocked and all(LOADS[key].easy for key in self.loads)
        return 1.0 if self.max_increment is None and easy else self.max_increment


def step_model(loads: Mapping[str, Load]) -> type[StepBase]:
    """A step in which a spec may change ``loads``."""
    fields: dict[str, Any] = {
        key: (load.annotation | None, Field(None, description=load.description))
        for key, load in loads.items()
    }
    return create_model("Step", __base__=StepBase, __doc__=StepBase.__doc__, **fields)


if TYPE_CHECKING:

    class Step(StepBase):
        """The keys of loads are known when the registry is read, not before."""

        def __getattr__(self, name: str) -> Any: ...

else:
    Step = step_model(LOADS)


class SpecBase(Part):
    """A soft actuator, its loads, and what to compute."""

    name: Name = Field("actuator", description="default: the name of the file")
    description: str = Field("", description="free text")
    source: str = Field("", description="paper, DOI")
    assumptions: tuple[str, ...] = Field(
        (), strict=False, description="what the source leaves open"
    )
    geometry: AnyGeometry = Field(description="type and parameters (softact list geometries)")
    materials: dict[str, AnyMaterial] = Field(
        {}, description="region -> card, {card:, ...} or {law:, ...}; a card is a name or a file"
    )
    layers: tuple[LayerSpec, ...] = Field((), strict=False, description="thin layers on surfaces")
    sheets: dict[str, SheetOfLayers] = Field(
        {}, description="sheet of the geometry -> its plies, wrinkling and bending"
    )
    supports: tuple[SupportSpec, ...] | None = Field(
        None, strict=False, description="default: the clamp of the geometry, all components"
    )
    obstacles: dict[Name, AnyObstacle] = Field(
        {}, description="rigid bodies: name -> plane, block, cylinder, sphere or mesh"
    )
    contact: Contacts | None = Field(
        None,
        strict=False,
        description="surfaces that may touch themselves or each other; by default auto, the "
        "outside touches itself, of all geometries but block, tube, thick_sphere, "
        "woven_elongating and woven_stiffening; walls of cavities under vacuum do in any case, "
        "unless it is none",
    )
    steps: tuple[Step, ...] = Field(
        strict=False, description="in order; each starts from the last state"
    )
    probes: dict[Name, Point] = Field(
        {}, description="points of the undeformed actuator whose way is wanted: name -> place"
    )
    target_line: TargetLine | None = Field(
        None, description="a line that the actuator is to follow: {file:, through:}"
    )
    module: ModuleSpec | None = Field(
        None, description="the mesh is one module of a long chain: its two faces, docs/modules.md"
    )
    points: dict[Name, Point] = Field(
        {},
        description="points for supports and payloads: name -> place on the undeformed actuator; "
        "the nearest node is taken",
    )
    lines: dict[Name, LineSpec] = Field(
        {}, description="lines for supports, payloads and torques: name -> {ends:} or {between:}"
    )
    safety_factor: Dimensionless = Field(
        2.0, ge=1, le=100, description="failure pressure over safe pressure"
    )
    fields: tuple[Literal["stress", "contact_pressure"], ...] = Field(
        (),
        strict=False,
        description="further fields in fields.xdmf: stress: all components of the Cauchy stress; "
        "contact_pressure: per undeformed area",
    )
    tolerances: dict[str, AnyTolerance] = Field(
        {},
        description="path -> how far its number scatters: a standard deviation (0.1 mm or 16 %) or "
        "{limits:}; paths with commas between them scatter together",
    )
    measures: Measures = Field("all", description="'all' or a list (softact list measures)")
    tiles: tuple[str, ...] = Field(
        (),
        strict=False,
        description="columns of curve.csv that stand as large figures at the head of the report, "
        "the first one under each picture too; default: what the run held, moved and turned",
    )
    solver: Solver = Field(Solver(), description="how the equilibrium is sought")

    @model_validator(mode="wrap")
    @classmethod
    def _check(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Collect the faults of single values and those between the parts, all at once."""
        if isinstance(data, cls):
            return data
        data = _named(data)
        faults: list[InitErrorDetails] = []
        spec = None
        try:
            spec = handler(data)
        except ValidationError as error:
            faults = [_again(entry) for entry in error.errors(include_url=False)]
        between = list(cross_faults(data, _geometry(data)))
        if spec is not None and not between:
            between = list(fibre_faults(spec.materials, spec.geometry.layout()))
            module = spec.module is not None
            between += inertia_faults(spec.steps, spec.materials, module, spec.obstacles)
        faults += [{"type": fault(text), "loc": place, "input": None} for place, text in between]
        if faults or spec is None:
            raise ValidationError.from_exception_data(cls.__name__, faults)
        return spec._resolved()

    def layout(self) -> Layout:
        """Names of the parts of the geometry, and of the points and lines beside."""
        lines = {name: line.where for name, line in self.lines.items()}
        return replace(self._own_layout(), points=dict(self.points), lines=lines)

    def _own_layout(self) -> Layout:
        """That of the geometry, whose ends are the faces of a module."""
        layout, module = self.geometry.layout(), self.module
        if module is None:
            return layout
        return replace(layout, clamp=module.left, tip=module.right, repeats=module.repeats)

    @field_serializer("contact")
    def _as_written(self, contact: Any) -> Any:
        """``auto`` where that says it, so that it goes along with another geometry."""
        is_auto = contact and contact == self._contact(AUTO, self.steps, self._own_layout())
        return "auto" if is_auto else contact

    def _contact(self, written: Contacts | None, steps: Sequence[Any], layout: Layout) -> Contacts:
        return resolved_contact(written, steps, layout, self.geometry.meets_itself)

    def _resolved(self) -> Self:
        layout = self._own_layout()
        supports = () if layout.repeats else self.supports
        if supports is None:
            clamp = SupportSpec(surface=layout.clamp, fix=("x", "y", "z")) if layout.clamp else None
            supports = (clamp,) if clamp else ()
        steps = [step.for_layout(layout) for step in self.steps]
        contact = self._contact(self.contact, steps, layout)
        # Only here, before anybody else sees the new spec, a frozen model gets its defaults.
        self.__dict__.update(supports=supports, steps=tuple(steps), contact=contact)
        return self

    def with_(self, changes: Mapping[str, Any] | None = None, **values: Any) -> Self:
        """Return a copy with other values, validated anew.

        changes: dotted path -> value, with units as YAML would have them, such as
        ``{"geometry.wall": "1.2 mm", "steps.inflate.pressure": "30 kPa"}``. values: keys at the top
        of the spec, such as ``name="thick"``. Raises SpecError with one line for each fault.
        """
        return changed(self, {**(changes or {}), **values}.items())

    def to_yaml(self) -> str:
        """Return the spec with all defaults and units; it loads back to an equal spec."""
        return to_text(self.model_dump(mode="json", exclude_none=True))

    @property
    def hash(self) -> str:
        """16 hexadecimal digits that change with whatever can change a result, not with texts."""
        data = self.model_dump(mode="json", exclude_none=True)
        places = walk(type(self), data)
        laws = [law for _, slot, law in places if isinstance(slot.choice, MaterialChoice)]
        for part in (data, *laws):
            for text in ("name", "description", "source", "assumptions", "test", "notes"):
                part.pop(text, None)
        if isinstance(self.geometry, Imported):
            data["geometry"]["file"] = self.geometry.content()
        data["steps"] = with_contents(data["steps"])
        if self.target_line is not None:
            data["target_line"]["file"] = digest(Path(self.target_line.file))
        for part in ("sheets", "probes", "points", "lines", "fields"):
            if not data[part]:
                del data[part]  # as before there were any
        for ply in (ply for sheet in data.get("sheets", {}).values() for ply in sheet["plies"]):
            if not ply["incompressible"]:
                del ply["incompressible"]  # as before there was a choice
        del data["tiles"]  # of the page alone
        del data["tolerances"]  # they are of other actuators than this one
        canonical = json.dumps(data, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]


def spec_model(bodies: Mapping[str, BodyKind]) -> type[SpecBase]:
    """A spec in which the kinds of body that have an annotation get their keys."""
    fields: dict[str, Any] = {
        key: (kind.annotation | None, Field(None, description=kind.description))
        for key, kind in bodies.items()
        if kind.annotation is not None
    }
    return create_model("Spec", __base__=SpecBase, __doc__=SpecBase.__doc__, **fields)


if TYPE_CHECKING:

    class Spec(SpecBase):
        """The keys of bodies are known when the registry is read, not before."""

        def __getattr__(self, name: str) -> Any: ...

else:
    Spec = spec_model(BODIES)


def _named(data: Any) -> Any:
    """Return ``data`` with a name for each step and contact that has none."""
    if not isinstance(data, dict):
        return data
    for part, word in UNNAMED.items():
        if isinstance(data.get(part), list):
            named = [
                {"name": f"{word}_{i}", **entry} if isinstance(entry, dict) else entry
                for i, entry in enumerate(data[part], start=1)
            ]
            data = {**data, part: named}
    return data


def _geometry(data: Any) -> Geometry | None:
    try:
        return GEOMETRY.validate(data["geometry"])
    except (ValidationError, ValueError, TypeError, KeyError):
        return None  # told already by the field itself


def _again(error: ErrorDetails) -> InitErrorDetails:
    """Return an error of pydantic in the form in which it can be raised once more."""
    again: InitErrorDetails = {"type": error["type"], "loc": error["loc"], "input": error["input"]}
    if error["type"] not in get_args(ErrorType):
        again["type"] = fault(error["msg"])
    elif "ctx" in error:
        again["ctx"] = error["ctx"]
    return again
