"""What a spec holds: frozen, strict models. Inside, every value is in internal units."""

import hashlib
import json
import math
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    PlainSerializer,
    PlainValidator,
    StringConstraints,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
    model_validator,
)
from pydantic_core.core_schema import ErrorType

from softact.geometry import Geometry
from softact.materials import Law
from softact.spec.checks import cross_faults
from softact.spec.choice import GeometryChoice, MaterialChoice, fault, fault_at, given
from softact.spec.text import to_text
from softact.units import ACCELERATION, Dimensionless, Length, Pressure, show

STANDARD_GRAVITY = 9810.0  # mm/s^2, as in the design: g = 9.81 m/s^2
ALL_CAVITIES = "*"

Component = Literal["x", "y", "z"]
Name = Annotated[
    str,
    StringConstraints(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$"),
]


def _geometries() -> dict[str, type[Geometry]]:
    from softact.geometries import GEOMETRIES

    return GEOMETRIES


def _three(value: Any) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple) or len(value) != 3:
        count = f"{len(value)} values are given" if isinstance(value, list) else given(value)
        raise fault(f"{count}; write a list of three for x, y, z")
    return tuple(value)


def _gravity(value: Any) -> tuple[float, float, float]:
    values = _three(value)
    if any(isinstance(entry, str) for entry in values):
        return tuple(_acceleration(i, entry) for i, entry in enumerate(values))
    numbers = [isinstance(v, int | float) and not isinstance(v, bool) for v in values]
    if not all(numbers) or not all(abs(v) < 1e300 for v in values):
        raise fault("three finite numbers are wanted (direction times g), or three accelerations")
    if math.hypot(*values) > 9:
        raise fault(
            f"{show(list(values))} without unit counts in g; for accelerations write units, "
            "for example [0 m/s^2, 0 m/s^2, -9.81 m/s^2]"
        )
    return tuple(STANDARD_GRAVITY * entry for entry in values)


def _acceleration(index: int, value: Any) -> float:
    try:
        return ACCELERATION.parse(value)
    except ValueError as error:
        raise fault_at((index,), str(error), value) from None


def _measures(value: Any) -> Any:
    if value == "all":
        return value
    if not isinstance(value, list | tuple) or not value:
        raise fault(f"{given(value)}; write 'all' or a list of names (softact list measures)")
    for index, name in enumerate(value):
        if not isinstance(name, str):
            raise fault_at((index,), f"{show(name)} is not the name of a measure", name)
    return tuple(value)


def _for_all_cavities(value: Any) -> Any:
    return value if isinstance(value, dict) else {ALL_CAVITIES: value}


Vector = {"type": "array", "minItems": 3, "maxItems": 3}
GRAVITY_SCHEMA = {
    **Vector,
    "items": {"type": ["number", "string"]},
    "description": "direction times g, such as [0, 0, -1], or three accelerations with unit",
}
PRESSURE_SCHEMA = TypeAdapter(Pressure).json_schema()
PRESSURES_SCHEMA = {
    "anyOf": [PRESSURE_SCHEMA, {"type": "object", "additionalProperties": PRESSURE_SCHEMA}]
}
MEASURES_SCHEMA = {"anyOf": [{"const": "all"}, {"type": "array", "items": {"type": "string"}}]}

Gravity = Annotated[
    tuple[float, float, float],
    PlainValidator(_gravity),
    PlainSerializer(lambda v: [ACCELERATION.format(a) for a in v], when_used="json"),
    WithJsonSchema(GRAVITY_SCHEMA),
]
Pressures = Annotated[
    dict[str, Pressure], BeforeValidator(_for_all_cavities), WithJsonSchema(PRESSURES_SCHEMA)
]
Measures = Annotated[
    Literal["all"] | tuple[str, ...],
    PlainValidator(_measures),
    PlainSerializer(lambda v: v if v == "all" else list(v), when_used="json"),
    WithJsonSchema(MEASURES_SCHEMA),
]
AnyGeometry = Annotated[Geometry, GeometryChoice(_geometries)]
AnyMaterial = Annotated[Law, MaterialChoice()]
LayerMaterial = Annotated[Law, MaterialChoice(layer=True)]


class Model(BaseModel):
    """Base of the parts of a spec."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Layer(Model):
    """A thin layer bonded to a surface: membrane stiffness, no bending stiffness, no mesh."""

    surface: str = Field(description="surface of the geometry, outer or embedded")
    thickness: Length = Field(gt=0, description="thickness of the layer")
    material: LayerMaterial = Field(description="a card or {law: linear, ...}")


class Support(Model):
    """Components of the displacement of a surface that are held or prescribed."""

    surface: str = Field(description="surface of the geometry")
    fix: tuple[Component, ...] = Field(
        (), strict=False, description="components held where they are when the support begins"
    )
    move: dict[Component, Length] = Field(
        {}, description="components moved, counted from the undeformed state: {x: 2 mm}"
    )

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        if not self.fix and not self.move:
            raise fault("neither fixes nor moves anything; write for example fix: [x, y, z]")
        for component in self.fix:
            if component in self.move:
                raise fault(f"'{component}' is both fixed and moved; keep one")
            if self.fix.count(component) > 1:
                raise fault(f"'{component}' is fixed twice")
        return self

    @property
    def values(self) -> dict[int, float | None]:
        """Component (0, 1, 2) -> prescribed displacement in mm, None: held where it is."""
        fixed: dict[int, float | None] = {"xyz".index(component): None for component in self.fix}
        return fixed | {"xyz".index(component): value for component, value in self.move.items()}


class Traction(Model):
    """A dead force per undeformed area on a surface: it keeps its direction."""

    surface: str = Field(description="surface of the geometry")
    value: Annotated[tuple[Pressure, Pressure, Pressure], BeforeValidator(_three)] = Field(
        description="force per area along x, y, z"
    )


class Step(Model):
    """A change of the loads or supports; loads ramp linearly from their last value."""

    name: Name = Field("", description="default: step_1, step_2, ...")
    gravity: Gravity | None = Field(
        None, description="direction times g, such as [0, 0, -1], or three accelerations"
    )
    pressure: Pressures | None = Field(
        None, description="of all cavities, or {cavity: pressure}; below zero for a vacuum"
    )
    traction: Traction | None = Field(None, description="dead load on a surface")
    surface_pressure: dict[str, Pressure] | None = Field(
        None, description="on faces that enclose no cavity: {surface: pressure}, pushing inwards"
    )
    supports: tuple[Support, ...] | None = Field(
        None, strict=False, description="replace the supports from this step on"
    )
    max_increment: Dimensionless | None = Field(
        None,
        gt=0,
        le=1,
        description="largest increment of this step; default: the solver's, and 1 where only "
        "gravity changes",
    )

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        if self.gravity is None and self._changes_only_gravity:
            raise fault(
                "this step changes nothing; give it gravity, pressure, traction or supports"
            )
        return self

    @property
    def largest_increment(self) -> float | None:
        """``max_increment`` with its default for gravity, which is seldom hard; None: solver's."""
        if self.max_increment is None and self._changes_only_gravity:
            return 1.0
        return self.max_increment

    @property
    def _changes_only_gravity(self) -> bool:
        others = (self.pressure, self.traction, self.surface_pressure, self.supports)
        return others == (None,) * 4


class Solver(Model):
    """How the equilibrium is sought. Increments are fractions of a step."""

    element: Literal["P2/P1", "P2/P0", "P2"] = Field(
        "P2/P1", description="displacement and pressure; P2 alone locks near incompressibility"
    )
    initial_increment: Dimensionless = Field(0.1, gt=0, le=1, description="first increment")
    max_increment: Dimensionless = Field(0.1, gt=0, le=1, description="largest increment")
    min_increment: Dimensionless = Field(1e-4, gt=0, le=1, description="below it the run ends")
    max_iterations: int = Field(
        15, ge=2, le=1000, description="Newton iterations before the increment is cut"
    )
    tolerance: Dimensionless = Field(1e-8, gt=0, le=1e-2, description="on the relative residual")
    predictor: Literal["none", "linear", "quadratic"] = Field(
        "quadratic", description="extrapolation from the last states as the first guess"
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.min_increment <= self.initial_increment <= self.max_increment:
            raise fault(
                "min_increment <= initial_increment <= max_increment is wanted, not "
                f"{self.min_increment:g}, {self.initial_increment:g}, {self.max_increment:g}"
            )
        return self


class Spec(Model):
    """A soft actuator, its loads, and what to compute."""

    name: Name = Field("actuator", description="default: the name of the file")
    description: str = Field("", description="free text")
    source: str = Field("", description="paper, DOI")
    assumptions: tuple[str, ...] = Field(
        (), strict=False, description="what the source leaves open"
    )
    geometry: AnyGeometry = Field(description="type and parameters (softact list geometries)")
    materials: dict[str, AnyMaterial] = Field(
        description="region -> card, {card:, ...} or {law:, ...}"
    )
    layers: tuple[Layer, ...] = Field((), strict=False, description="thin layers on surfaces")
    supports: tuple[Support, ...] | None = Field(
        None, strict=False, description="default: the clamp of the geometry, all components"
    )
    steps: tuple[Step, ...] = Field(
        strict=False, description="in order; each starts from the last state"
    )
    measures: Measures = Field("all", description="'all' or a list (softact list measures)")
    solver: Solver = Field(Solver(), description="how the equilibrium is sought")

    @model_validator(mode="wrap")
    @classmethod
    def _check(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Collect the faults of single values and those between the parts, all at once."""
        if isinstance(data, Spec):
            return data
        data = _named_steps(data)
        faults, spec = [], None
        try:
            spec = handler(data)
        except ValidationError as error:
            faults = [_again(entry) for entry in error.errors(include_url=False)]
        faults += [
            {"type": fault(text), "loc": place, "input": None}
            for place, text in cross_faults(data, _geometry(data))
        ]
        if faults:
            raise ValidationError.from_exception_data(cls.__name__, faults)
        return spec._resolved()

    def _resolved(self) -> Self:
        layout = self.geometry.layout()
        supports = self.supports
        if supports is None:
            supports = (Support(surface=layout.clamp, fix=("x", "y", "z")),)
        steps = [
            step.model_copy(update={"pressure": dict.fromkeys(layout.cavities, value)})
            if step.pressure and (value := step.pressure.get(ALL_CAVITIES)) is not None
            else step
            for step in self.steps
        ]
        # Only here, before anybody else sees the new spec, a frozen model gets its defaults.
        self.__dict__.update(supports=supports, steps=tuple(steps))
        return self

    def to_yaml(self) -> str:
        """Return the spec with all defaults and units; it loads back to an equal spec."""
        return to_text(self.model_dump(mode="json", exclude_none=True))

    @property
    def hash(self) -> str:
        """16 hexadecimal digits that change with whatever can change a result, not with texts."""
        data = self.model_dump(mode="json", exclude_none=True)
        for part in (data, *data["materials"].values(), *(la["material"] for la in data["layers"])):
            for text in ("name", "description", "source", "assumptions", "test", "notes"):
                part.pop(text, None)
        canonical = json.dumps(data, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]


def _named_steps(data: Any) -> Any:
    """Return ``data`` with a name for each step that has none."""
    if not isinstance(data, dict) or not isinstance(data.get("steps"), list):
        return data
    steps = [
        {"name": f"step_{i}", **step} if isinstance(step, dict) else step
        for i, step in enumerate(data["steps"], start=1)
    ]
    return {**data, "steps": steps}


def _geometry(data: Any) -> Geometry | None:
    try:
        return GeometryChoice(_geometries).validate(data["geometry"])
    except (ValidationError, ValueError, TypeError, KeyError):
        return None  # told already by the field itself


def _again(error: dict[str, Any]) -> dict[str, Any]:
    """Return an error of pydantic in the form in which it can be raised once more."""
    if error["type"] not in get_args(ErrorType):
        return {"type": fault(error["msg"]), "loc": error["loc"], "input": error["input"]}
    keys = ("type", "loc", "input", "ctx")
    return {key: error[key] for key in keys if key in error}
