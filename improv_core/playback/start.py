"""Starts the stages that play a performance. Standard library only."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from improv_core.playback.interpreter import InterpreterError, find_ros_python
from improv_core.playback.stage_process import Hear, Stage, StageError
from improv_core.playback.stops import Stops
from improv_core.stage.messages import FOLDER

SinkName = Literal["simulator", "ros"]


@dataclass(frozen=True, slots=True)
class Options:
    """What to play on. `backend` is auto, sim, ros, or both; the ROS fields are as in the settings.

    `node` is the name of the node in ROS 2 (None: a unique one); `ros_arguments` are ROS's own, after `--ros-args`.

    With `report_sent`, stages report every velocity they send. `takes_start_poses` is for a listener that handles
    `place` requests: only then does the page have start poses written into the program.
    """

    backend: str = "auto"
    port: int = 0
    ros_python: str | None = None
    discovery: str | None = None
    standby: bool = True
    report_sent: bool = False
    takes_start_poses: bool = False
    node: str | None = None
    ros_arguments: Sequence[str] = ()


async def start_stage(sink: SinkName, options: Options, token: str, hear: Hear, stops: Stops) -> Stage | None:
    """Start a stage and return it when it is ready. `token` opens the simulator's page. Raises StageError.

    None if the backend is auto and no Python has rclpy.
    """
    reporting = ["--report-sent"] if options.report_sent else []
    if sink == "simulator":
        taking = ["--takes-start-poses"] if options.takes_start_poses else []
        arguments = ["--sink", sink, "--port", str(options.port), *taking, *reporting]
        env = {**os.environ, "IMPROV_PAGE_TOKEN": token}
        return await Stage.start([sys.executable, str(FOLDER), *arguments], env, hear, stops)
    try:
        found = await asyncio.to_thread(find_ros_python, options.ros_python)
    except InterpreterError as error:
        raise StageError(str(error)) from None
    if found:
        discovery = ["--discovery", options.discovery] if options.discovery else []
        alone = [] if options.standby else ["--no-standby"]
        named = ["--node", options.node] if options.node else []
        theirs = ["--ros-args", *options.ros_arguments] if options.ros_arguments else []  # last: it takes all the rest
        arguments = ["--sink", sink, *discovery, *alone, *reporting, *named, *theirs]
        return await Stage.start([found.python, str(FOLDER), *arguments], found.env, hear, stops)
    if options.backend == "auto":
        return None
    raise StageError(
        "no Python with rclpy was found: run `improv ros setup`, source your ROS 2 "
        "(`source /opt/ros/…/setup.bash`), or set IMPROV_ROS_PYTHON to a Python that has it"
    )
