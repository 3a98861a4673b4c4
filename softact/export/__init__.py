"""Reduced models of actuators for simulators: one file per format, each with ``write``.

A new format is one file with ``write(job, directory)``, which returns the files that it wrote, and
one line in ``FORMATS``; ``check(job)`` beside it may refuse a model before anything is written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from softact.export.job import Job

__all__ = ["FORMATS", "Format"]


@dataclass(frozen=True)
class Format:
    """A file format. module: with its ``write``, imported only where it is asked for; description:
    for the help."""

    module: str
    description: str

    @property
    def _module(self) -> ModuleType:
        return import_module(f"softact.export.{self.module}")

    @property
    def write(self) -> Callable[[Job, Path], list[Path]]:
        """Writes the files of a model into a folder and returns them."""
        return self._module.write

    def check(self, job: Job) -> None:
        """Raise SpecError where this format cannot hold a model, before anything is written."""
        if check := getattr(self._module, "check", None):
            check(job)


FORMATS = {
    "mujoco": Format("to_mujoco", "MJCF: a chain of joints with springs, and a module to drive it"),
    "urdf": Format("to_urdf", "URDF: the same chain, springs for Gazebo, tables over the pressure"),
    "sofa": Format("to_sofa", "a SOFA scene with the same chain; written, but never run"),
    "simulink-csv": Format("to_simulink", "lookup tables over pressure and load, and a script"),
    "json": Format("to_json", "the model in numbers, with everything known of its deviations"),
    "fmu": Format("to_fmu", "FMI 2.0 co-simulation; needs the package pythonfmu"),
}
