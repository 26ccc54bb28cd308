"""Code lenses in `improv.toml`: above each robot's section, to see whether the robot moves, and to stop it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from improv_core.ide.code_lens import Lens
from improv_core.program.analysis import Analysis, analyze
from improv_core.robots.config import read_robots
from improv_core.robots.toml_text import read_toml
from improv_core.text import Span

STEP = "forward"
"""What a robot does at a click: the first word of most programs."""


def trials(text: str) -> Iterator[Lens]:
    """The lenses of the robots that can move forward, in the order of the file."""
    robots = read_robots(text).robots
    for keys, (span, *_) in read_toml(text).positions.named.items():
        robot = str(keys[-1])
        if keys[:-1] == ("robots",) and robot in robots and STEP in robots[robot].profile.motions:
            yield Lens(span, f"▶ try {STEP}", "play", robot)
            yield Lens(Span(min(span.start + 1, span.end), span.end), "■ hush", "hush")


def trial(text: str, path: Path | None, robot: str) -> Analysis:
    """The program that the lens of a robot plays."""
    return analyze(f"{robot} $ {STEP}", read_robots(text, path))
