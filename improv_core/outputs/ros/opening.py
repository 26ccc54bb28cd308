"""Opens the output to ROS 2. The standby starts first, so that it loads while the stage's modules do."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from improv_core.outputs.ros.standby.client import start_standby

if TYPE_CHECKING:
    from improv_core.ipc.arrivals import OutputChannel
    from improv_core.protocol.output import Sink


def prepare(arguments: Sequence[str]) -> Callable[[OutputChannel], Sink]:
    """Return a function that opens the output, with these arguments of the command line. It raises ImportError without
    rclpy, and what rclpy raises if the arguments are wrong."""
    parser = argparse.ArgumentParser(prog="improv stage --sink ros")
    parser.add_argument("--discovery", help="ROS_AUTOMATIC_DISCOVERY_RANGE, where the environment does not say")
    parser.add_argument("--no-standby", action="store_true", help="no second process to stop robots if this one dies")
    parser.add_argument("--node", help="the name of the node in ROS 2, if it is not to be unique")
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS's own arguments, to the end")
    options = parser.parse_args(arguments)
    theirs = ["--ros-args", *options.ros_args] if options.ros_args else []
    standby = start_standby(options.discovery, theirs, not options.no_standby)

    def opened(channel: OutputChannel) -> Sink:
        from improv_core.outputs.ros.output import RosSink

        return RosSink(standby, channel.hear, channel.ask, options.node, theirs, channel.warn)

    return opened
