"""How exact a player is when no time really passes: what is left is the arithmetic."""

from __future__ import annotations

from fractions import Fraction

from improv_core.score.motion import Twist
from improv_core.stage.player import Player
from improv_core.stage.zeros import LAST_ZEROS
from tests.benchmarks.robots import RATE
from tests.stage.test_player import Memory, score

MORNING = 30_000.0
"""What the clock says at beat 0, in seconds: nothing depends on its being a small number."""


def simulated_drift(minutes: int) -> tuple[int, float]:
    """How many commands there are in so many minutes at beat 60, in pieces of 1/3 beat, and by how much the worst is
    off its exact time, in seconds."""
    beats = minutes * 60
    sink = _Clocked()
    player = Player(sink, lambda _: None, lambda: sink.now)
    player.load(score(f"beat 60\nr $ repeat {beats} [forward left right]\n"), 1, "restart", MORNING)
    while (deadline := player.deadline(sink.now)) is not None:
        sink.now = deadline
        player.advance(deadline)
    changes = {Fraction(piece, 3) for piece in range(3 * beats)}
    repeats = {Fraction(count, RATE) for count in range(RATE * beats)}
    exact = sorted(changes | repeats)
    exact += [beats + Fraction(count, RATE) for count in range(LAST_ZEROS)]
    off = [abs(Fraction(at) - due) for at, due in zip(sink.dates, exact, strict=True)]
    return len(off), float(max(off))


class _Clocked(Memory):
    """Notes when each command is sent, by the clock."""

    def __init__(self) -> None:
        super().__init__()
        self.now = MORNING
        self.dates: list[float] = []

    def send(self, robot: str, twist: Twist, at: float) -> None:
        self.dates.append(self.now - MORNING)
