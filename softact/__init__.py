"""softact: from a YAML spec of a soft pneumatic actuator to its data sheet.

From Python: ``load``, ``run``, ``read``, ``sweep``, ``fit`` and what they return; see
``softact.api``.
"""

from importlib import import_module
from typing import Any

_FUNCTIONS = ("DataSheet", "SoftactError", "Spec", "load", "loads", "read")  # of softact.api
_ROOMS = ("fit", "run", "sweep")  # which are called as functions of softact.api


def __getattr__(name: str) -> Any:
    """Names of ``softact.api``, imported when first asked for: a command must start at once."""
    if name in _FUNCTIONS:
        return getattr(import_module("softact.api"), name)
    if name in _ROOMS:
        return import_module(f"softact.{name}")
    raise AttributeError(f"module 'softact' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*globals(), *_FUNCTIONS, *_ROOMS])
