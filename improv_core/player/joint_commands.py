"""Sends commands to joints. Commands to one robot for the same time are sent together.

So a controller that moves several body parts gets one message, not one for each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from improv_core.score.joints import JointMotion


class _Command(NamedTuple):
    robot: str
    joints: Mapping[str, JointMotion]
    at: float


class JointCommands:
    """Commands to joints, sent by `send`, which may raise any exception."""

    def __init__(self, send: Callable[[str, Mapping[str, JointMotion], float], None]) -> None:
        self._send = send
        self._gathers = False
        self._held: _Command | None = None

    def tell(self, robot: str, joints: Mapping[str, JointMotion], at: float) -> None:
        """Have some of a robot's joints move from performance time `at` on."""
        before, self._held = self._held, _Command(robot, joints, at)
        if before and (before.robot, before.at) == (robot, at):
            self._held = _Command(robot, {**before.joints, **joints}, at)
        elif before:
            self._send(*before)  # if that fails, this one is still sent
        if not self._gathers:
            self._flush()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Gather commands within this context: those to joints of one robot, for the same time, are sent at once."""
        self._gathers = True
        try:
            yield
        finally:
            self._gathers = False
            self._flush()

    def _flush(self) -> None:
        held, self._held = self._held, None
        if held:
            self._send(*held)
