"""Rooms that are called as the function of their name: ``softact.run(spec)``.

``softact.run`` is a package with modules of its own as soon as anything imports one of them, so the
function of that name cannot stand beside it.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any


class CallableRoom(ModuleType):
    """A package that hands a call on to ``softact.api``."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """See the function of this name in ``softact.api``."""
        return self.__wrapped__(*arguments, **options)

    @property
    def __wrapped__(self) -> Any:
        """The function, for ``inspect.signature``."""
        return getattr(import_module("softact.api"), self.__name__.rpartition(".")[2])
