"""Code actions that play a part of a program, mute or solo its robots, or stop all. They change no text."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from improv_core.ide.references import symbol_at
from improv_core.ide.rehearsal import Scenes, scene_called
from improv_core.ide.selection import uses
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.program import MAX_SCENES, Placed
from improv_core.program.timing import in_beats, in_seconds
from improv_core.robots.config import read_robots
from improv_core.robots.toml_text import read_toml
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Lengths
from improv_core.text import Span

MAX_ROBOTS = 3
"""The most robots of a line that can be muted and soloed from there."""


@dataclass(frozen=True, slots=True)
class PlayAction:
    """An action that moves or stops robots. Its `kind` is for code actions; `command` follows `improv.` in the
    command's name.

    `only` is the part of the program that plays, if not all of it; `robot` is the robot that it mutes, solos, or tries.
    """

    title: str
    kind: str
    command: str
    only: Span | Scenes | None = None
    robot: str | None = None


STOP = PlayAction("Stop all robots", "improv.stop", "stop")


def play_actions(
    analysis: Analysis, cursor: int, muted: Collection[str] = (), soloed: Collection[str] = ()
) -> Iterator[PlayAction]:
    """Yield the actions at the cursor, given the muted and soloed robots: the one that plays the least comes first."""
    placed = analysis.statement_at(cursor)
    if tried := _tried(analysis, cursor, placed):
        name = tried.statement.heads[0].text
        yield PlayAction(f"Try {name}{_lasting(analysis, tried)}", "improv.play.name", "only", _head(tried))
    if analysis.plays_nothing:
        return
    if placed and placed.meaning.robots and len(analysis.played) > 1:
        line = f"this line{_lasting(analysis, placed)}"
        yield PlayAction(f"Play {line}", "improv.play.line", "play", _head(placed))
        yield PlayAction(f"Play only {line}", "improv.play.only", "only", _head(placed))
    if analysis.breaks:
        scene = min(sum(analysis.offsets[index] <= cursor for index in analysis.breaks), MAX_SCENES - 1)
        called = f"{scene_called(analysis, scene)}{_in_brackets(scene_lasting(analysis, scene))}"
        yield PlayAction(f"Play only {called}", "improv.play.scene", "play", Scenes(scene, scene))
        last = analysis.scene_count - 1
        if 0 < scene < last:
            from_here = f"Play from {scene_called(analysis, scene)} on"
            yield PlayAction(from_here, "improv.play.from", "play", Scenes(scene, last))
    yield PlayAction("Play the program", "improv.play", "play")
    yield STOP
    if placed and len(analysis.robots) > 1:
        for robot in placed.meaning.robots[:MAX_ROBOTS]:
            yield PlayAction(f"{'Unmute' if robot in muted else 'Mute'} {robot}", "improv.mute", "mute", robot=robot)
            yield PlayAction(f"{'Unsolo' if robot in soloed else 'Solo'} {robot}", "improv.solo", "solo", robot=robot)


def lasting(parts: Iterable[Lengths], tempo: Fraction) -> str:
    """Describe the length of the longest of some parts: `8 beats, 16.0 s`; empty if there is none."""
    known = list(parts)
    if not known:
        return ""
    whole = Lengths(max(each.shortest for each in known), max(each.longest for each in known), False)
    return in_beats(whole) + (f", {in_seconds(whole, tempo)}" if whole.longest != ENDLESS else "")


def scene_lasting(analysis: Analysis, scene: int) -> str:
    """Describe the length of a scene, counted from 0, like `lasting`, or what it lacks."""
    if why := lack(analysis, scene):
        return why
    parts = [scenes[scene] for scenes in analysis.parts.values() if scene < len(scenes)]
    return lasting(map(lengths, parts), analysis.tempo)


def lack(analysis: Analysis, scene: int | None = None) -> str:
    """Return the first error because of which nobody knows what robots play in a scene, or in all; empty if none."""
    lines = ((index, analysis.played.get(index)) for index in sorted(analysis.lacks))
    return next((analysis.lacks[index] for index, line in lines if line and scene in (None, line.scene)), "")


def _tried(analysis: Analysis, cursor: int, placed: Placed | None) -> Placed | None:
    """Return the definition at the cursor, or that of the name there, if it can be played: a phrase needs arguments."""
    symbol = symbol_at(analysis, cursor)
    if symbol and symbol.definer is not None and symbol.kind == "name":
        definer = symbol.definer
    elif placed and placed.meaning.definition:
        definer = placed.index
    else:
        return None
    return analysis.placed(definer) if uses(analysis, definer) is not None else None


def _lasting(analysis: Analysis, placed: Placed) -> str:
    """Describe the length of a line or a name, in brackets; empty for a phrase, which depends on its arguments."""
    if placed.index in analysis.lacks or placed.statement.parameters:
        return ""
    return _in_brackets(lasting([lengths(placed.meaning.movement)], analysis.tempo))


def _in_brackets(text: str) -> str:
    return f" ({text})" if text else ""


def _head(placed: Placed) -> Span:
    """Return the head of a line or a definition."""
    sign = placed.statement.sign
    assert sign
    return Span(placed.start, placed.start + sign.end)


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
