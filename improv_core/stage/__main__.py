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
    helpers = {
        "standby": "outputs.ros.standby.process",
        "reader": "outputs.ros.sensors.process",
        "publisher": "outputs.ros.publisher.process",
        "graph": "outputs.ros.graph",
        **{name: f"music.{name}" for name in ("osc", "midi", "link")},
    }
    if module := helpers.get(sys.argv[1] if sys.argv[1:] else ""):
        del sys.argv[1]
        sys.exit(import_module(f"improv_core.{module}").main())

from improv_core.outputs.ros.standby.client import start_standby


def main() -> int:
    """Play what standard input requests until it ends. Returns exit code 1 after a failure, 2 if the sink can't be
    opened."""
    options = options_in(sys.argv[1:])
    arguments = ["--ros-args", *options.ros_args] if options.ros_args else []
    standby = start_standby(options.discovery, arguments, not options.no_standby)  # it loads while we do
    from improv_core.stage.robots import play

    return play(standby, options.node, arguments, reports=options.report_sent)


def options_in(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options from the arguments of the command line."""
    parser = argparse.ArgumentParser(prog="improv stage")
    parser.add_argument("--sink", choices=["ros"], required=True)
    parser.add_argument("--discovery", help="ROS_AUTOMATIC_DISCOVERY_RANGE, where the environment does not say")
    parser.add_argument("--no-standby", action="store_true", help="no second process to stop robots if this one dies")
    parser.add_argument("--report-sent", action="store_true", help="tell of every velocity that is sent")
    parser.add_argument("--node", help="the name of the node in ROS 2, if it is not to be unique")
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS's own arguments, to the end")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
