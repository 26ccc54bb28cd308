"""Frames travel through ssh between both ends of a link: each is a line, and its first letter is its kind.

| letter | to the far end | to the near end |
|---|---|---|
| `s` | a line for the channel of stops | |
| `l` | the next line for standard input is a score | |
| `m`, `M` | a chunk of a line for standard input, its last chunk | `m`: a line of the stage |
| `c` | a number: asks for the time there | the number, and the times (`RemoteTimes`) |
| `a` | | this many more bytes have reached the stage |
| `h` | | the far end has begun |
| `i` | | a description of the machine, if we only look; that all is done, if we set up |
| `t` | | a line about the progress of a setup |
| `e` | | a line for people about why the link ends |

So a stop never waits behind a long message: at most `WINDOW` bytes of those are on their way.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

CHUNK = 4_096
"""The most bytes of a long line in one frame."""
WINDOW = 32_768
"""The bytes of long lines that may be on their way: more would wait in ssh, where no stop can overtake them."""
LONGEST_DOWN = 1_000_000
"""The most bytes of a line that the far end reads. Ours are shorter than `CHUNK`."""
LONGEST_UP = 16_000_000
"""The most bytes of a line that the near end reads: many times a stage's reports about a thousand robots."""
DOWN, UP = b"slmMc", b"mcahite"
"""The letters of frames to the far end, and to the near end."""


class FrameError(Exception):
    """A frame can't be from the other end of a link. The message is a plain line without a dot."""


@dataclass(frozen=True, slots=True)
class LinkFrame:
    """A frame: its letter, and the rest of the line."""

    letter: str
    rest: bytes


@dataclass(frozen=True, slots=True)
class RemoteTimes:
    """The far end's answer to the question with this number, in nanoseconds: the times of its monotonic clock at which
    the question `arrived` and was `answered`; the time of its Unix clock at the latter (`wall`); and for how long that
    machine has been `asleep`."""

    number: int
    arrived: int
    answered: int
    wall: int
    asleep: int

    def frame(self) -> bytes:
        return b"c%d %d %d %d %d\n" % (self.number, self.arrived, self.answered, self.wall, self.asleep)


def time_in(rest: bytes) -> RemoteTimes:
    """Return the times in a frame. Raises FrameError."""
    try:
        number, arrived, answered, wall, asleep = map(number_in, rest.split(b" "))
    except ValueError:
        raise FrameError("it answers with something else than times") from None
    return RemoteTimes(number, arrived, answered, wall, asleep)


_MAX_DIGITS = 20


def number_in(rest: bytes) -> int:
    """Return the number in a frame. Raises FrameError."""
    if not rest.isdigit() or len(rest) > _MAX_DIGITS:
        raise FrameError("it sends something else than a number")
    return int(rest)


class Incoming:
    """Takes bytes as they come, and returns complete frames."""

    def __init__(self, letters: bytes, longest: int) -> None:
        self._letters = letters
        self._longest = longest
        self._begun: list[bytes] = []  # of a frame
        self._length = 0

    def take(self, data: bytes) -> list[LinkFrame]:
        """Take bytes, and return the frames that they complete. Raises FrameError, and nothing can be read then."""
        frames = []
        *ends, rest = data.split(b"\n")
        for end in ends:
            self._check(end)
            line = b"".join((*self._begun, end))
            self._begun, self._length = [], 0
            if not line:
                raise FrameError("it sends an empty line")
            frames.append(LinkFrame(line[:1].decode("latin-1"), line[1:]))
        if rest:
            self._check(rest)
            self._begun.append(rest)
            self._length += len(rest)
        return frames

    def _check(self, more: bytes) -> None:
        if not self._length and more and more[0] not in self._letters:
            raise FrameError("it sent something that isn't from a stage")
        if self._length + len(more) > self._longest:
            raise FrameError(f"it sends a line of more than {self._longest // 1_000_000} MB")


class Outgoing:
    """The frames that wait for the far end: urgent ones first, then as many chunks of lines as the window allows."""

    def __init__(self) -> None:
        self._urgent: deque[bytes] = deque()
        self._lines: deque[tuple[bytes, bool]] = deque()  # true if the line is a score
        self._at = 0  # the bytes of the first line that were sent
        self._unread = 0  # the bytes of lines that the stage has yet to get

    def put_first(self, frame: bytes) -> None:
        """Send this before all chunks of lines."""
        self._urgent.append(frame)

    def put(self, line: bytes, *, is_score: bool = False) -> None:
        """Send a line, without its end, for standard input."""
        self._lines.append((line, is_score))

    def forget(self) -> None:
        """Drop the unsent rest of all lines, because all ends."""
        self._lines.clear()
        self._at = 0

    def acknowledge(self, count: int) -> None:
        """Note that this many more bytes have reached the stage."""
        self._unread = max(self._unread - count, 0)

    @property
    def rests(self) -> bool:
        """True if no line waits, and little is on its way."""
        return not self._lines and self._unread < CHUNK

    def next(self) -> bytes | None:
        """Return the frame to send now; None if nothing waits, or nothing may be sent."""
        if self._urgent:
            return self._urgent.popleft()
        if not self._lines or self._unread >= WINDOW:
            return None
        line, is_score = self._lines[0]
        if is_score and not self._at:
            self._lines[0] = line, False
            return b"l\n"
        chunk = line[self._at : self._at + CHUNK]
        self._at += len(chunk)
        self._unread += len(chunk) + 1
        if self._at < len(line):
            return b"m%b\n" % chunk
        self._lines.popleft()
        self._at = 0
        return b"M%b\n" % chunk
