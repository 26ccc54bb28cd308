"""Gives each movement of a drawing whole beats: a drawing has no rhythm of its own. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate, pairwise

from improv_core.transcription.fits import VelocityFits
from improv_core.transcription.polyline import polyline
from improv_core.transcription.rhythm import TrackedRobot
from improv_core.transcription.stretches import EvenStretch
from improv_core.transcription.tempo import USUAL

_LOOSE = 1.25
"""The factor by which a drawing may take more or less time at the usual tempo than it should."""


def on_whole_beats(drawn: Mapping[str, TrackedRobot], tempo: int | None) -> tuple[int, dict[str, TrackedRobot]]:
    """Return a tempo, and robots whose lines, arcs, and turns on the spot each take whole beats at it, about in
    proportion to their times. By default, it is one at which the robots take about as long as before."""
    beats = {
        robot: [max(round(stretch.seconds * (tempo or USUAL) / 60), 1) for stretch in each.stretches]
        for robot, each in drawn.items()
    }
    tempo = tempo or max(_tempo(sum(beats[robot]), each.stretches[-1].end) for robot, each in drawn.items())
    return tempo, {robot: _retimed(each, beats[robot], 60 / tempo) for robot, each in drawn.items()}


def _tempo(beats: int, seconds: float) -> int:
    """Return a round tempo at which this many beats take about this many seconds."""
    exact = 60 * beats / seconds
    return USUAL if USUAL / _LOOSE <= exact <= USUAL * _LOOSE else max(round(exact / 10) * 10, 10)


def _retimed(robot: TrackedRobot, beats: Sequence[int], beat: float) -> TrackedRobot:
    """Return a robot whose stretches last as many beats as given, at `beat` seconds each."""
    begin = robot.track[0].time
    after = [count * beat for count in accumulate(beats, initial=0)]
    lengths = [each.seconds for each in robot.stretches]
    moved = polyline((seconds, count * beat / seconds) for seconds, count in zip(lengths, beats, strict=True))
    track = [each._replace(time=begin + moved(each.time - begin)) for each in robot.track]
    stretches = [
        EvenStretch(start, end, each.amounts.times(each.seconds / (end - start)))
        for (start, end), each in zip(pairwise(after), robot.stretches, strict=True)
    ]
    return robot._replace(track=track, fits=VelocityFits(track, robot.noise), stretches=stretches)
