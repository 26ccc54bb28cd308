"""The program that runs on a Thymio: it stops the motors if no command comes, and reports what the robot senses.

It is made of words of Aseba's virtual machine (aseba/vm/vm.c). As Aseba's language would have it:

    onevent timer0   # every 90 ms
      if fed > 0 then fed -= 1 else motor.left.target = 0, motor.right.target = 0 end
      ticks += 1
      emit 0 [ticks, taps, left, right, …]

    onevent motor    # each time that the wheels are measured and regulated, 100 times a second
      left += motor.left.speed
      right += motor.right.speed
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

PERIOD = 90
"""Milliseconds between checks of the program. The simulator checks only in each step, thirty times a second."""
FED = 4
"""The checks for which a command holds: at the one after these, at most 0.5 s after the command, the motors stop."""
MOTOR_PERIOD = 0.01
"""Seconds between two measurements of the wheels, on the robot's clock."""
SPEEDS = ("motor.left.speed", "motor.right.speed")
REPORTED = (
    *(("motor.left.target", 1), ("motor.right.target", 1)),
    *(("prox.horizontal", 7), ("prox.ground.delta", 2)),
    *(("button.backward", 1), ("button.left", 1), ("button.center", 1), ("button.forward", 1), ("button.right", 1)),
)
"""The variables that it reports, with their sizes, after the checks, the taps, and the wheels' speeds, added up."""
NEEDED = (*REPORTED, *((speed, 1) for speed in SPEEDS), ("timer.period", 2))
_INIT = 0xFFFF
_STOP, _ADD, _SUB = 0x0000, 0x8002, 0x8003
_UNLESS_GREATER = 0xA00C


class RobotMemory(NamedTuple):
    """The memory of a robot: the addresses of its variables, the first free one, the codes of its local events, and
    those of its native functions."""

    variables: Mapping[str, int]
    free: int
    events: Mapping[str, int]
    natives: Mapping[str, int]

    @property
    def lacks(self) -> str | None:
        """The first thing that the program needs and the robot doesn't have."""
        wanted = [name for name, _ in NEEDED if name not in self.variables]
        wanted += [name for name in ("timer0", "motor", "tap") if name not in self.events]
        return next(iter([*wanted, *({"leds.top"} - self.natives.keys())]), None)

    @property
    def fed(self) -> int:
        """The address of the number of checks for which the latest command still holds."""
        return self.free


def program(memory: RobotMemory, color: Sequence[float]) -> list[int]:
    """Return the words of the program, for the top LED in this color: red, green, and blue, each from 0 to 1."""
    at, fed = memory.variables, memory.fed
    ticks, taps, wheels, first = fed + 1, fed + 2, fed + 3, fed + 5
    sources = [at[name] + index for name, size in REPORTED for index in range(size)]
    rgb = first + len(sources)

    init = [*_push(PERIOD), _store(at["timer.period"])]
    for index, share in enumerate(color):
        init += [*_push(round(32 * share)), _store(rgb + index)]
    for address in (rgb + 2, rgb + 1, rgb):  # a native function takes the address of each argument, the last one first
        init += _push(address)
    init += [0xC000 | memory.natives["leds.top"], _STOP]

    feed = [_load(fed), *_push(1), _SUB, _store(fed)]
    halt = [*_push(0), _store(at["motor.left.target"]), *_push(0), _store(at["motor.right.target"])]
    look = [_load(fed), *_push(0), _UNLESS_GREATER, 2 + len(feed) + 1, *feed, 0x9000 | (1 + len(halt)), *halt]
    look += _add(ticks, _push(1))
    for index, source in enumerate(sources):
        look += [_load(source), _store(first + index)]
    look += [0xB000, ticks, first - ticks + len(sources), _STOP]

    rolled = [word for index, speed in enumerate(SPEEDS) for word in _add(wheels + index, [_load(at[speed])])]
    tapped = [*_add(taps, _push(1)), _STOP]
    events = memory.events
    parts = [(_INIT, init), (events["timer0"], look), (events["motor"], [*rolled, _STOP]), (events["tap"], tapped)]
    begin = 1 + 2 * len(parts)
    vectors = [begin]
    for event, words in parts:
        vectors += [event, begin]
        begin += len(words)
    return [*vectors, *(word for _, words in parts for word in words)]


def _push(value: int) -> list[int]:
    return [0x1000 | value] if 0 <= value < 0x800 else [0x2000, value & 0xFFFF]


def _load(address: int) -> int:
    return 0x3000 | address


def _store(address: int) -> int:
    return 0x4000 | address


def _add(address: int, value: Sequence[int]) -> list[int]:
    return [_load(address), *value, _ADD, _store(address)]
