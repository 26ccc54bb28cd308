"""Programs that come back from their own paths: in how many words, how far off, and with which structure."""

from __future__ import annotations

import math
import random
import re
import time
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import NamedTuple

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import analyze_file
from improv_core.score.movement import ENDLESS
from improv_core.score.path import pose_at
from improv_core.score.score import Score
from improv_core.transcription.performing import SHIFTS
from improv_core.transcription.track import TimedPlace
from improv_core.transcription.transcribe import Tolerance, transcribe
from tests.benchmarks.tables import machine, p99, print_head, print_row

EXAMPLES = Path(__file__).parents[2] / "examples"
GALLERY = (
    *("square", "heart", "nautilus", "spiral", "meters", "canon", "phrases"),
    *("stars", "duet", "rehearsal", "dice", "ring", "hey"),
)
"""Programs of docs/gallery.md that end, that no sense decides, and in which only bases move."""
STRUCTURES = ("repeat", "canon", "reflect", "retrograde")
RATE = 20
MAX_BEATS = 200
CLEAN = Tolerance(0.001, math.radians(0.3), 0.01)
NOISE = (0.005, math.radians(1))
_WORDS = re.compile(r"[0-9.]+(?:/[0-9]+)?(?:cm|mm|m|deg)?|\w+")


class Outcome(NamedTuple):
    """A transcription compared with its program: the ratio of their words, how far it is off in meters, seconds of
    CPU, and the structures of the original that it has, of those that it could have."""

    words: float
    meters: float
    seconds: float
    structures: tuple[int, int]


def run(quick: bool = False) -> None:
    """Print the table."""
    print(machine())
    print_head(
        "programs", "noise", "number", "within 1 mm / 3 cm", "words, median", "structure found", "CPU, p50 / p99"
    )
    for noise in (None, NOISE):
        gallery = [(name, analyze_file(EXAMPLES / f"{name}.improv")) for name in GALLERY]
        _row("gallery", noise, gallery)
        _row("random", noise, list(_random(30 if quick else 300)))


def _row(label: str, noise: tuple[float, float] | None, programs: list[tuple[str, Analysis]]) -> None:
    outcomes = {name: _outcome(analysis, noise) for name, analysis in programs}
    limit = 0.001 if noise is None else 0.03
    good = sum(each.meters <= limit for each in outcomes.values())
    had, found = (sum(each.structures[at] for each in outcomes.values()) for at in (1, 0))
    seconds = [each.seconds for each in outcomes.values()]
    print_row(
        label,
        "none" if noise is None else f"{1000 * noise[0]:g} mm, {math.degrees(noise[1]):g}°",
        str(len(outcomes)),
        f"{good / len(outcomes):.1%}",
        f"{median(each.words for each in outcomes.values()):.2f}",
        f"{found} of {had}",
        f"{median(seconds):.2f} / {p99(seconds):.2f} s",
    )
    for name, each in outcomes.items():
        if each.meters > limit or label == "gallery":
            print(f"    {name}: words {each.words:.2f}, {1000 * each.meters:.1f} mm, {each.seconds:.1f} s")


def _outcome(analysis: Analysis, noise: tuple[float, float] | None) -> Outcome:
    score = score_of(analysis)
    recorded = places(score, noise)
    begin = time.process_time()
    made = transcribe(recorded, tolerance=CLEAN if noise is None else Tolerance())
    seconds = time.process_time() - begin
    compiled = analyze(made.text)
    assert compiled.ok, (made.text, compiled.diagnostics)
    again = score_of(compiled)
    exact = places(score, None)
    off = max(_off(exact[robot], again, robot, 0.0 if noise is None else 0.05) for robot in exact)
    original = re.sub(r"#.*", "", analysis.text)
    wanted = [word for word in STRUCTURES if word in original]
    found = sum(word in made.text for word in wanted)
    words = len(_WORDS.findall(made.text)) / len(_WORDS.findall(original))
    return Outcome(words, off, seconds, (found, len(wanted)))


def places(score: Score, noise: tuple[float, float] | None) -> Mapping[str, list[TimedPlace]]:
    """Return the ideal path of each robot at 20 Hz, with noise if there is any."""
    dice = random.Random(1)
    found: dict[str, list[TimedPlace]] = {}
    for robot, part in score.parts.items():
        beats = min(part.begins + part.movement.duration, MAX_BEATS)
        ends = Fraction(beats) * 60 / score.tempo
        found[robot] = []
        for number in range(int(ends * RATE) + 2):
            seconds = Fraction(number, RATE)
            pose = pose_at(part, min(seconds, ends) * score.tempo / 60)
            assert pose
            x, y, z, heading = pose.x, pose.y, pose.z, pose.heading
            if noise:
                x, y, heading = (
                    x + dice.gauss(0, noise[0]),
                    y + dice.gauss(0, noise[0]),
                    heading + dice.gauss(0, noise[1]),
                )
            found[robot].append(TimedPlace(float(seconds), x, y, z, heading))
    return found


def _off(exact: list[TimedPlace], again: Score, robot: str, early: float) -> float:
    """Return how far a robot's path is off at most, if it may be early or late by this many seconds."""
    if robot not in again.parts:
        return max(math.dist((each.x, each.y), (exact[0].x, exact[0].y)) for each in exact)
    part, worst = again.parts[robot], 0.0
    for place in exact:
        far = math.inf
        for shift in SHIFTS if early else (0.0,):
            beat = Fraction(max(place.time + shift * early, 0.0)) * again.tempo / 60
            pose = pose_at(part, beat.limit_denominator(10_000))
            assert pose
            far = min(far, math.dist((place.x, place.y, place.z), (pose.x, pose.y, pose.z)))
        worst = max(worst, far)
    return worst


def _random(count: int) -> Iterator[tuple[str, Analysis]]:
    """Yield random programs of one or two robots without senses."""
    dice = random.Random(2026)
    number = 0
    while number < count:
        robots = ["a"] if dice.random() < 0.7 else ["a", "b"]
        text = f"beat {dice.choice([60, 60, 80, 90, 100, 120])}\n"
        text += "".join(f"{robot} $ {_series(dice, 3)}\n" for robot in robots)
        analysis = analyze(text)
        score = score_of(analysis) if analysis.ok else None
        if score and all(2 <= part.movement.duration < min(ENDLESS, 60) for part in score.parts.values()):
            number += 1
            yield f"{number}: {text!r}", analysis


def _series(dice: random.Random, depth: int) -> str:
    return " ".join(_term(dice, depth) for _ in range(dice.randint(1, 4)))


def _term(dice: random.Random, depth: int) -> str:
    words = ["forward", "left", "right", "halfleft", "backward", "rest", "forward 1.5m", "left 60deg", "strafeleft"]
    words += ["left 180deg radius 50cm", "(forward || halfright)", "right 90deg radius 1m", "forward 80cm"]
    shapes = [
        "repeat {n} ({m})",
        "fast 2 ({m})",
        "slow 2 ({m})",
        "reflect sagittal ({m})",
        "retrograde ({m})",
        "ease ({m})",
    ]
    shapes += ["ease ({m})", "[{m}]", "ramp 1/2 3/2 ({m})", "repeat {n} ({m})", "scale 1/2 ({m})"]
    if not depth or dice.random() < 0.6:
        return dice.choice(words)
    return dice.choice(shapes).format(n=dice.randint(2, 4), m=_series(dice, depth - 1))
