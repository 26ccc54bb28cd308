"""Have a robot of `improv.toml` take a step, so that people see whether it moves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from improv_core.ide.code_action_play import STOP, PlayAction
from improv_core.program.analysis import Analysis, analyze
from improv_core.robots.config import read_robots
from improv_core.robots.toml_text import read_toml
from improv_core.text import Span

STEP = "forward"
"""The movement of a robot that is tried: the first word of most programs."""


def trials(text: str, span: Span) -> Iterator[PlayAction]:
    """Yield the actions for a robot whose section's name is at the cursor, if it can move forward."""
    robots = read_robots(text).robots
    for keys, (name, *_) in read_toml(text).positions.named.items():
        robot = str(keys[-1])
        here = name.start <= span.end and span.start <= name.end
        if here and keys[:-1] == ("robots",) and robot in robots and STEP in robots[robot].profile.motions:
            yield PlayAction(f"Try {STEP} with {robot}", "improv.play.robot", "play", robot=robot)
            yield STOP


def trial(text: str, path: Path | None, robot: str) -> Analysis:
    """Return the program in which a robot takes a step."""
    return analyze(f"{robot} $ {STEP}", read_robots(text, path))
