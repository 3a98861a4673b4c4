"""The spec: a YAML file as frozen models in internal units, every fault told at once."""

from typing import TYPE_CHECKING

from softact.spec.loading import load, loads, opened, part, spec_at
from softact.spec.models import Layer, Solver, Support
from softact.spec.schema import json_schema

if TYPE_CHECKING:
    # The registered loads and bodies add fields, which a type checker cannot see.
    from softact.spec.models import SpecBase as Spec
    from softact.spec.models import StepBase as Step
else:
    from softact.spec.models import Spec, Step

__all__ = [
    "Layer",
    "Solver",
    "Spec",
    "Step",
    "Support",
    "json_schema",
    "load",
    "loads",
    "opened",
    "part",
    "spec_at",
]
