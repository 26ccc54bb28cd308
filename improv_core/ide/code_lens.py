"""Code lenses: one above the program and one above each scene, to play it, with its length.

A new lens moves the lines below it, so none appears while a person types: the first line always has one, and a scene
gets its own when the program is opened or saved.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import islice

from improv_core.ide.code_action_play import lack, lasting, scene_lasting
from improv_core.ide.rehearsal import Scenes, scene_called
from improv_core.program.analysis import Analysis

MAX_SCENES = 200
"""The most scenes that get lenses: editors request those of the whole program after every key."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A few words above a line. Clicking them plays only the scenes `only`, or all if it is None."""

    line: int
    text: str
    only: Scenes | None = None


def lenses(analysis: Analysis, scenes: Collection[int]) -> Iterator[Lens]:
    """Yield the lens of a program, and those of the scenes that begin with these statements, in the order of the
    text."""
    yield Lens(0, _titled("▶ play", lack(analysis) or lasting(analysis.lengths.values(), analysis.tempo)))
    for scene, index in enumerate(islice(analysis.breaks, MAX_SCENES), 1):
        if analysis.statement_ids[index] in scenes:
            line = analysis.lines.position(analysis.offsets[index]).line
            title = _titled(f"▶ {scene_called(analysis, scene)}", scene_lasting(analysis, scene))
            yield Lens(line, title, Scenes(scene, scene))
            if scene + 1 < analysis.scene_count:
                yield Lens(line, "▶ from here", Scenes(scene, analysis.scene_count - 1))


def _titled(title: str, lasts: str) -> str:
    return f"{title} · {lasts}" if lasts else title
