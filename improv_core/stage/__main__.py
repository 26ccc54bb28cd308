"""The stage's process: JSON lines in, velocities out. Whatever ends it, it first sends every robot zeros.

Started as `python …/improv_core/stage`, perhaps by ROS's interpreter, in which our package is not installed. Its own
helper processes, and a look at ROS's graph, begin here too, with a name.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

if __name__ == "__main__":
    # Python puts the folder it runs first on the path, where our modules would hide others of the same name. The folder
    # of our package goes last, so that it hides none of ROS's; but first, the package is found there, because another
    # version of it may be installed.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.insert(0, str(here.parent.parent))
    import_module("improv_core")
    sys.path.append(sys.path.pop(0))
    if sys.argv[1:] and not sys.argv[1].startswith("-"):  # a helper, by the name of its module
        module = sys.argv.pop(1)
        sys.exit(import_module(f"improv_core.{module}").main())


def main() -> int:
    """Play what standard input requests. Returns exit code 1 after a failure, 2 if the sink can't be opened."""
    options, theirs = options_in(sys.argv[1:])
    open_sink = import_module(f"improv_core.outputs.{options.sink}.opening").prepare(theirs)
    from improv_core.stage.process import play

    return int(play(open_sink, options.name, reports=options.report_sent))


def options_in(arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
    """Return the options from the arguments of the command line, and the arguments of the output."""
    parser = argparse.ArgumentParser(prog="improv stage", allow_abbrev=False)
    parser.add_argument("--sink", required=True, help="the package in `outputs` whose `opening` opens the output")
    parser.add_argument("--name", default="ros", help="the name of this stage in a performance")
    parser.add_argument("--report-sent", action="store_true", help="tell of every velocity that is sent")
    return parser.parse_known_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
