"""Puts drawings, which have no rhythm of their own, on whole beats. Standard library only."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from itertools import accumulate, pairwise

from improv_core.transcription.fits import VelocityFits
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
    return tempo, {robot: _lasting(each, beats[robot], 60 / tempo) for robot, each in drawn.items()}


def _tempo(beats: int, seconds: float) -> int:
    """Return a round tempo at which so many beats take about so long."""
    exact = 60 * beats / seconds
    return USUAL if USUAL / _LOOSE <= exact <= USUAL * _LOOSE else max(round(exact / 10) * 10, 10)


def _lasting(robot: TrackedRobot, beats: Sequence[int], beat: float) -> TrackedRobot:
    """Return a robot whose stretches last these beats, each of which takes `beat` seconds."""
    begin = robot.track[0].time
    before = [robot.stretches[0].start, *(each.end for each in robot.stretches)]
    after = [count * beat for count in accumulate(beats, initial=0)]

    def moved(time: float) -> float:
        place = min(max(bisect_right(before, time - begin) - 1, 0), len(beats) - 1)
        share = (time - begin - before[place]) / (before[place + 1] - before[place])
        return begin + after[place] + share * (after[place + 1] - after[place])

    track = [each._replace(time=moved(each.time)) for each in robot.track]
    stretches = [
        EvenStretch(start, end, each.amounts.times(each.seconds / (end - start)))
        for (start, end), each in zip(pairwise(after), robot.stretches, strict=True)
    ]
    return robot._replace(track=track, fits=VelocityFits(track, robot.noise), stretches=stretches)
