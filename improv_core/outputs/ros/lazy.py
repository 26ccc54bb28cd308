"""Modules that are loaded on first use rather than on import. Standard library only."""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any


def imported_later(name: str) -> None:
    """Make later imports of this module return a stand-in that loads it on first use. Nothing changes if the module is
    loaded already or doesn't exist."""
    if name not in sys.modules and (spec := find_spec(name)):
        later = _LazyModule(name)
        later.__spec__ = spec  # without it, `find_spec` would fail
        sys.modules[name] = later


class _LazyModule(ModuleType):
    """A stand-in for a module that isn't loaded yet. It keeps working after the module was loaded."""

    def __getattr__(self, name: str) -> Any:
        with _replacing:
            if sys.modules.get(self.__name__) is self:
                del sys.modules[self.__name__]
        return getattr(import_module(self.__name__), name)


_replacing = threading.Lock()
