"""A module that is loaded once something of it is asked for, and not when it is imported. Standard library only."""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any


def imported_later(name: str) -> None:
    """From now on, who imports this module imports something that loads it when it is used, as if it had been loaded
    before. Nothing changes if it is loaded already, or doesn't exist."""
    if name not in sys.modules and (spec := find_spec(name)):
        later = _Later(name)
        later.__spec__ = spec  # without it, who looks for the module would not find it
        sys.modules[name] = later


class _Later(ModuleType):
    """In the place of a module that has not been loaded. What has kept this goes on using it."""

    def __getattr__(self, name: str) -> Any:
        with _replacing:
            if sys.modules.get(self.__name__) is self:
                del sys.modules[self.__name__]
        return getattr(import_module(self.__name__), name)


_replacing = threading.Lock()
