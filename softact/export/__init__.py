"""Reduced models of actuators for simulators: one file per format, each with ``files``.

A new format is one file with ``files(job)``, which returns name -> content of what is to be
written, and one line in ``FORMATS``. It raises SpecError where it cannot hold a model; nothing has
been written then.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from softact.export.job import Job

__all__ = ["FORMATS", "Format"]


@dataclass(frozen=True)
class Format:
    """A file format. module: with its ``files``, imported only where it is asked for; description:
    for the help."""

    module: str
    description: str

    @property
    def files(self) -> Callable[[Job], dict[str, str | bytes]]:
        """Gives name -> content of the files of a model. Raises SpecError where this format cannot
        hold it."""
        return import_module(f"softact.export.{self.module}").files


FORMATS = {
    "mujoco": Format("to_mujoco", "MJCF: a chain of joints with springs, and a module to drive it"),
    "urdf": Format("to_urdf", "URDF: the same chain, springs for Gazebo, tables over the pressure"),
    "sofa": Format("to_sofa", "a SOFA scene with the same chain; written, but never run"),
    "simulink-csv": Format("to_simulink", "lookup tables over pressure and load, and a script"),
    "json": Format("to_json", "the model in numbers, with everything known of its deviations"),
    "fmu": Format("to_fmu", "FMI 2.0 co-simulation; needs the package pythonfmu"),
}
