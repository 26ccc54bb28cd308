"""Code lenses above each line that robots play: commands, and how long the line takes."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import islice

from improv_core.program.analysis import Analysis, Placed
from improv_core.program.timing import in_beats, in_seconds
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS
from improv_core.text import Span

MOST_LINES = 200
"""The most lines that get lenses: editors request those of the whole program after every keystroke."""
MOST_ROBOTS = 3
"""The most robots of a line that get lenses to mute and solo them."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A few words above the line of `span`. Clicking them runs `command`: play, hush, or mute or solo a robot.

    Each lens of a line starts at a column of its own, because Neovim sorts them by column and mixes up equal ones.
    """

    span: Span
    text: str
    command: str
    robot: str | None = None


def lenses(analysis: Analysis, muted: Collection[str] = (), soloed: Collection[str] = ()) -> list[Lens]:
    """The lenses of the lines that robots play, in the order of the text, given who is muted and soloed."""
    playing = (index for index, meaning in enumerate(analysis.meanings) if meaning.robots)
    placed = [analysis.placed(index) for index in islice(playing, MOST_LINES)]
    return [
        Lens(_column(line, place), *lens)
        for line in placed
        for place, lens in enumerate(_of(analysis, line, muted, soloed))
    ]


def _column(placed: Placed, place: int) -> Span:
    """The end of a line's head, from the column for the lens at this place."""
    sign = placed.statement.sign
    assert sign
    end = placed.start + sign.span.end
    return Span(min(placed.start + place, end), end)


def _of(
    analysis: Analysis, placed: Placed, muted: Collection[str], soloed: Collection[str]
) -> Iterator[tuple[str, str] | tuple[str, str, str]]:
    robots, length = placed.meaning.robots, lengths(placed.meaning.movement)
    lasts = f" · {in_beats(length)}" if placed.meaning.ok else ""
    if lasts and length.longest != ENDLESS:
        lasts += f", {in_seconds(length, analysis.tempo)}"
    yield f"▶ play{lasts}", "play"
    yield "■ hush", "hush"
    if len(analysis.robots) > 1:
        for robot in robots[:MOST_ROBOTS]:
            of = f" {robot}" if len(robots) > 1 else ""
            yield f"{'unmute' if robot in muted else 'mute'}{of}", "mute", robot
            yield f"{'unsolo' if robot in soloed else 'solo'}{of}", "solo", robot
