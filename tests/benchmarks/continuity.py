"""What a save with `continue` does to a robot whose line it does not change, and what it costs to send and to read."""

from __future__ import annotations

import asyncio
import json
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory

from improv_core.ipc.arrivals import Play
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import RowsRead, RowsWritten, to_json
from improv_core.session.part_versions import Editions
from improv_core.session.start import Options
from improv_core.stage.stdio import arrival
from tests.benchmarks.documents import improv
from tests.benchmarks.robots import ENV, PYTHON, Listener
from tests.benchmarks.tables import machine, print_head, print_row
from tests.edited_dance import ANNA, BERT, play, record_undisturbed
from tests.recordings import Velocity, read

LINES = 1_000
MEDIAN, WORST = 1.0, 5.0
"""Goals, in milliseconds: by how much a robot's command may come at another time than in an undisturbed dance."""
SAVE = 15.0
"""Goal, in milliseconds of processor time: from an analysis to the score that the stage has read."""

Commands = Sequence[tuple[float, Velocity]]


def run(quick: bool) -> None:
    """Measure and print; `quick` has fewer saves."""
    print(f"{machine()}\n")
    _print_costs(20 if quick else 100)
    _print_rhythm(20 if quick else 100)


@dataclass(frozen=True, slots=True)
class _Cost:
    """Of one save: bytes, and milliseconds of processor time of its parent and its stage."""

    size: int
    parent: float
    stage: float


def _print_costs(saves: int) -> None:
    whole, lacking = _costs(saves, whole=True), _costs(saves, whole=False)
    print(f"A save of {LINES:,} lines for nine robots, one of them edited: processor time of a save, medians\n")
    print_head("what is sent", "kB", "parent, ms", "stage reads, ms", "together, ms", "goal", "")
    for what, costs, goal in (("the whole score", whole, None), ("what the stage lacks", lacking, SAVE)):
        size, parent, stage = (median(values) for values in zip(*map(_figures, costs), strict=True))
        verdict = ("", "") if goal is None else (f"≤ {goal:g}", "met" if parent + stage <= goal else "not met")
        print_row(what, f"{size / 1000:.0f}", f"{parent:.1f}", f"{stage:.1f}", f"{parent + stage:.1f}", *verdict)


def _figures(cost: _Cost) -> tuple[float, float, float]:
    return cost.size, cost.parent, cost.stage


def _costs(saves: int, *, whole: bool) -> list[_Cost]:
    """What each save costs if the stage knows the ones before, or nothing."""
    analysis = analyze(improv(LINES - 1) + "probe $ repeat forward\n")
    editions, written, known, costs = Editions(), RowsWritten(), RowsRead(), []
    for generation, edited in enumerate(_edited(analysis, saves), 1):
        edited.robots  # noqa: B018  # computed by the diagnostics at each key
        if whole:
            editions, written, known = Editions(), RowsWritten(), RowsRead()
        began = time.thread_time()
        editions, score = editions.number(score_of(edited), generation)
        data = to_json(score, written)
        message = {"type": "load", "generation": generation, "score": data, "when": "beat", "backend": ""}
        line = json.dumps(message).encode()
        sent = time.thread_time()
        came = arrival(line, known)
        done = time.thread_time()
        assert isinstance(came, Play)
        editions = editions.plays(generation)
        costs.append(_Cost(len(line), (sent - began) * 1000, (done - sent) * 1000))
    return costs[1:]


def _edited(analysis: Analysis, times: int) -> list[Analysis]:
    """The program, and then with one line after another edited that a robot plays."""
    found = [analysis]
    random = Random(1)
    playing = [at for at, text in enumerate(analysis.text.split("\n")) if "$" in text]
    for _ in range(times):
        before = found[-1]
        lines = before.text.split("\n")
        line = random.choice(playing)
        start = sum(len(text) + 1 for text in lines[:line]) + lines[line].index("$") + 1
        found.append(before.edited(start, start, random.choice((" left", " right", " forward"))))
    return found


def _print_rhythm(saves: int) -> None:
    seconds = saves * 0.3 + 4  # longer than the saves take, or the last one would restart the dance
    beats = 2 * round(seconds * 2)
    with TemporaryDirectory() as folder:
        alone, edited, ideal = (Path(folder, f"{name}.mcap") for name in ("alone", "edited", "ideal"))
        undisturbed = _performed(beats, 0, alone)
        disturbed = _performed(beats, saves, edited)
        record_undisturbed(beats, ideal)
        due = _recorded(ideal)
        print(f"\nOne robot's commands while another one's line is saved {saves} times, beside the same dance without")
        print("saves: by how much each change of velocity comes at another time, milliseconds\n")
        print_head("where", "commands", "not in the dance", "changes", "p50", "max", "goal", "")
        _print_difference("at a subscriber", undisturbed, disturbed, due)
        _print_difference("in the recording", _recorded(alone), _recorded(edited), due)
        _print_difference("undisturbed, beside the ideal", due, undisturbed, due)
        _print_difference("with saves, beside the ideal", due, disturbed, due)


def _print_difference(where: str, one: Commands, other: Commands, due: Commands) -> None:
    """`due` is what there should be; a busy machine leaves out some that repeat a velocity."""
    pairs = list(zip(_changes(one), _changes(other), strict=False))
    wrong = _count_extra(other, due) + sum(a[1] != b[1] for a, b in pairs)
    wrong += abs(len(_changes(one)) - len(_changes(other)))
    shift = median(b[0] - a[0] for a, b in pairs)
    off = [abs(b[0] - a[0] - shift) * 1000 for a, b in pairs]
    met = not wrong and median(off) <= MEDIAN and max(off) <= WORST
    figures = str(len(other)), str(wrong), str(len(pairs)), f"{median(off):.2f}", f"{max(off):.2f}"
    print_row(where, *figures, f"p50 ≤ {MEDIAN:g}, max ≤ {WORST:g}", "met" if met else "not met")


def _changes(commands: Commands) -> Commands:
    return [next(group) for _, group in groupby(commands, key=lambda command: command[1])]


def _count_extra(commands: Commands, due: Commands) -> int:
    """How many commands are not in the dance, or not in their order."""
    rest = iter(due)
    return sum(not any(velocity == wanted for _, wanted in rest) for _, velocity in commands)


def _performed(beats: int, saves: int, output: Path) -> Commands:
    """Anna's commands as they came, while bert's line was saved so many times."""
    random = Random(1)

    async def pause() -> None:
        await asyncio.sleep(random.uniform(0, 0.4))

    os.environ.update(ENV)
    with Listener("drain", [ANNA, BERT]) as listener:
        asyncio.run(play(beats, saves, output, Options("ros", 0, PYTHON, report_sent=True), pause))
        time.sleep(0.5)
        heard = listener.end()[ANNA]
    return [(each.received, (each.x, each.y, each.z, each.yaw)) for each in heard]


def _recorded(path: Path) -> Commands:
    return [(message.time / 1e9, message.velocity) for message in read(path) if message.topic == ANNA]
