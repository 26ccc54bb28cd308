"""Run by every Python that has this folder on its PYTHONPATH: sets limits of ours, and runs code, for a test."""

import json
import os
import sys
from importlib import import_module
from pathlib import Path

if limits := os.environ.get("IMPROV_TEST_LIMITS"):
    root = str(Path(__file__).parents[3])
    sys.path.append(root)
    for name, value in json.loads(limits).items():
        module, _, limit = name.rpartition(".")
        setattr(import_module(f"improv_core.{module}"), limit, value)
    sys.path.remove(root)
exec(os.environ.get("IMPROV_TEST_CODE", ""))
