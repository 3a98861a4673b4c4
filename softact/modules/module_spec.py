"""From the spec of an actuator to those of its module."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from softact.spec import Spec
from softact.spec.one_module import blocked_modules, free_module

HINT = "hold components with --hold, such as --hold turn_y='10 deg'"


@dataclass(frozen=True)
class ModuleSpecs:
    """runs: ``free``: what nothing holds but ``--hold``; ``straight`` and ``clamped``: see
    ``blocked_modules``.

    pitches: modules of the whole actuator, of several segments those of the first; None where the
    spec is that of a module itself.
    """

    runs: dict[str, Spec]
    pitches: float | None


def module_specs(
    spec: Spec, hold: Mapping[str, str], weight: bool = True, contact: bool = True
) -> ModuleSpecs:
    """The specs of an actuator's module. hold, weight, contact: see ``free_module``.

    Raises SpecError with one line for each fault.
    """
    free = free_module(spec, hold, weight, contact)
    alone = spec.layout().repeats is not None
    modules = None if alone else spec.geometry.pitches / len(spec.geometry.in_segments())
    return ModuleSpecs({"free": free} | blocked_modules(free), modules)
