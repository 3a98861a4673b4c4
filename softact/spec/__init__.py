"""The spec: a YAML file as frozen models in internal units, every fault told at once."""

from softact.spec.films import LayerSpec
from softact.spec.loading import load, loads, opened, part, spec_at
from softact.spec.models import Spec, Step
from softact.spec.schema import json_schema
from softact.spec.solver import Solver
from softact.spec.supports import SupportSpec

__all__ = [
    "LayerSpec",
    "Solver",
    "Spec",
    "Step",
    "SupportSpec",
    "json_schema",
    "load",
    "loads",
    "opened",
    "part",
    "spec_at",
]
