"""How long it takes to find who meets whom: at first, after an edit of one robot, and with how many robots."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from random import Random
from statistics import median

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.meetings import check_room
from improv_core.score.score import Score
from tests.benchmarks.tables import print_head, print_row

_WORDS = ("forward", "forward", "backward", "left", "right", "halfleft", "strafeleft", "straferight", "rest")


def run(quick: bool) -> None:
    rounds = 1 if quick else 5
    print("Robots 3 m apart, each with a random round of its own of 20 to 50 beats, for 1,000 beats. Processor time.\n")
    print_head("robots", "first check", "after an edit of one robot", "pairs that meet", "meetings")
    for robots in (3, 10, 30) if quick else (3, 10, 30, 60, 100):
        text = program(robots)
        score, edited = score_of(analyze(text)), score_of(analyze(text.replace("r1 $ ", "r1 $ left ", 1)))
        first = [measured(partial(check_room, score)) for _ in range(rounds)]
        again = [_again(score, edited) for _ in range(rounds)]
        checked = check_room(score)
        assert checked.end == 1_000
        print_row(
            str(robots),
            f"{median(first):.2f} s",
            f"{median(again):.2f} s",
            str(len(checked.meetings)),
            str(sum(each.more + 1 for each in checked.meetings)),
        )


def program(robots: int, seed: int = 0) -> str:
    """A dance of so many robots that never repeats itself."""
    random = Random(seed)
    return "".join(f"r{number} $ repeat ({_round(random)})\n" for number in range(robots))


def _round(random: Random) -> str:
    words = random.choices(_WORDS, k=random.randint(20, 50))
    return " ".join(word if random.random() < 0.7 else f"[{word} left {word}]" for word in words)


def measured(work: Callable[[], object]) -> float:
    """The processor time that some work takes, in seconds."""
    begun = time.process_time()
    work()
    return time.process_time() - begun


def _again(score: Score, edited: Score) -> float:
    before = check_room(score)
    return measured(partial(check_room, edited, before=before.known))
