"""Runs either end of a link: `python …/improv_core/hosts near HOST …` here, and `far …` on the other machine."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    # As in stage/__main__.py: none of our modules hides another of the same name, and no other version hides ours.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.insert(0, str(here.parent.parent))
    import_module("improv_core")
    sys.path.append(sys.path.pop(0))
    if sys.argv[1:2] not in (["near"], ["far"]):
        sys.exit("say `near` or `far`")
    sys.exit(import_module(f"improv_core.hosts.{sys.argv.pop(1)}").main())
