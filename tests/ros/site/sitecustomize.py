"""Set limits of ours and run code for a test, in every Python that has this folder on its PYTHONPATH.

A limit is set when its module is imported, before any code reads it: most processes import few of these modules.
"""

import json
import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any


class Limits:
    """A finder of the modules that have these limits: `{"player.decide.LATE": 20}`."""

    def __init__(self, limits: dict[str, Any]) -> None:
        self._limits: dict[str, dict[str, Any]] = {}
        for name, value in limits.items():
            module, _, limit = name.rpartition(".")
            self._limits.setdefault(f"improv_core.{module}", {})[limit] = value

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if name not in self._limits:
            return None
        spec = PathFinder.find_spec(name, path, target)
        assert spec
        assert spec.loader
        run = spec.loader.exec_module

        def run_and_set(module: ModuleType) -> None:
            run(module)
            vars(module).update(self._limits[name])

        spec.loader.exec_module = run_and_set  # type: ignore[method-assign]
        return spec


if limits := os.environ.get("IMPROV_TEST_LIMITS"):
    sys.meta_path.insert(0, Limits(json.loads(limits)))
exec(os.environ.get("IMPROV_TEST_CODE", ""))
