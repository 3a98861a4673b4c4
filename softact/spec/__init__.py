"""The spec: a YAML file as frozen models in internal units, every fault told at once."""

from softact.spec.loading import load, loads, opened, part, spec_at
from softact.spec.models import Layer, Solver, Spec, Step, Support
from softact.spec.schema import json_schema

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
