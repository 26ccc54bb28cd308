"""Code lenses above lines that robots play and above definitions: commands, and how long these take."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import islice

from improv_core.ide.selection import uses
from improv_core.program.analysis import Analysis, Placed
from improv_core.program.timing import in_beats, in_seconds
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS
from improv_core.text import LINE_END, Span

MOST_LINES = 200
"""The most lines and definitions that get lenses: editors request those of the whole program after every keystroke."""
MOST_ROBOTS = 3
"""The most robots of a line that get lenses to mute and solo them."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A few words above the line of `span`. Clicking them runs `command`: play, hush, or mute or solo a robot.

    If `only_this`, it plays only what is at `span`. Each lens of a line starts at a column of its own, because Neovim
    sorts them by column and mixes up equal ones.
    """

    span: Span
    text: str
    command: str
    robot: str | None = None
    only_this: bool = False


def lenses(analysis: Analysis, muted: Collection[str] = (), soloed: Collection[str] = ()) -> list[Lens]:
    """The lenses of lines and definitions, in the order of the text, given who is muted and soloed."""
    movable = (index for index, meaning in enumerate(analysis.meanings) if meaning.robots or meaning.definition)
    return [
        replace(lens, span=_column(placed, place))
        for placed in map(analysis.placed, islice(movable, MOST_LINES))
        for place, lens in enumerate(_of(analysis, placed, muted, soloed))
    ]


def _column(placed: Placed, place: int) -> Span:
    """The head of a line or a definition, from the column for the lens at this place."""
    sign = placed.statement.sign
    assert sign
    line = len(LINE_END.split(placed.statement.text, maxsplit=1)[0])
    begin = placed.start + min(place, line)
    return Span(begin, max(begin, placed.start + sign.end))


def _of(analysis: Analysis, placed: Placed, muted: Collection[str], soloed: Collection[str]) -> Iterator[Lens]:
    robots, lasts = placed.meaning.robots, _lasting(analysis, placed)
    if not robots:
        if uses(analysis, placed.index) is not None:  # a phrase that nothing uses has no arguments
            yield Lens(placed.span, f"▶ try{lasts}", "play", only_this=True)
        return
    if len(analysis.played) > 1:
        yield Lens(placed.span, f"▶ this line{lasts}", "play", only_this=True)
        yield Lens(placed.span, "▶ play all", "play")
    else:
        yield Lens(placed.span, f"▶ play{lasts}", "play")
    yield Lens(placed.span, "■ hush", "hush")
    if len(analysis.robots) > 1:
        for robot in robots[:MOST_ROBOTS]:
            of = f" {robot}" if len(robots) > 1 else ""
            yield Lens(placed.span, f"{'unmute' if robot in muted else 'mute'}{of}", "mute", robot)
            yield Lens(placed.span, f"{'unsolo' if robot in soloed else 'solo'}{of}", "solo", robot)


def _lasting(analysis: Analysis, placed: Placed) -> str:
    """How long a line or a name takes; nothing of a phrase, which depends on its arguments."""
    if not placed.meaning.ok or placed.statement.parameters:
        return ""
    length = lengths(placed.meaning.movement)
    seconds = f", {in_seconds(length, analysis.tempo)}" if length.longest != ENDLESS else ""
    return f" · {in_beats(length)}{seconds}"
