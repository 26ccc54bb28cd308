"""Reads children's dances in a process of its own, so that a heavy dance delays nobody and can be given up."""

from __future__ import annotations

import asyncio
import json
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, TypedDict

from improv_core.diagnostics import Severity
from improv_core.ide.merging import Dance, MergeError, merge, renamed
from improv_core.ipc.asking import Answerer
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.program.report import mistakes, summary
from improv_core.program.timing import moment
from improv_core.robots.config import FILE_NAME, read_robots
from improv_core.score.meetings import check_room
from improv_core.score.score import Score
from improv_core.score.score_json import to_json
from improv_core.score.svg import plot

LIMIT = 10.0
"""Seconds of processor time that an answer may take, however busy the machine is. Then the process ends, and another
one answers the next question."""
QUICK = 1.0
"""Seconds of processor time in which almost every dance is read."""
PATIENCE = 1 if sys.platform == "win32" else 60
"""The factor on `LIMIT` after which the process is killed, in real time: on a busy machine, it hardly runs. On Windows,
which can't limit the processor time of a process, it is 1."""
MAX_MEMORY = 2_000_000_000
"""The most bytes of address space for the process, where the system can limit that."""
LARGEST_PICTURE = 200_000
LARGEST_SCORE = 400_000
"""The most characters of a score as JSON: about 6,000 movements. The event loop that receives the teacher's stop sends
that to a stage in less than a tenth of a second."""
_MAX_MOMENTS = 2_000
_SIZE = 320.0
LIMITS = ("too-fast",)
"""Warnings because of which a real robot performs none of a child's dance."""
MAX_WORK = 100_000
"""The work to find robots that meet: about 2 s of processor time on a slow machine."""
MAX_MEETINGS = 3
"""The most meetings of robots that a line lists."""
HEAVY = "this dance takes too long to read: make it shorter"
LONG = "this has too many movements to play in a class: make it shorter, or play fewer together"


class Impression(TypedDict):
    """The result of reading a dance: whether it can be played, a line about it, and the picture of its paths as SVG, or
    "". `spent` is the processor time in seconds."""

    ok: bool
    line: str
    picture: str
    spent: float


class Prepared(TypedDict):
    """A score, as JSON; or the reason why there is none, in one line. `notes` list the changes by merging, and robots
    that meet; `names` are those of children, for their robots."""

    score: Mapping[str, Any] | None
    problem: str
    notes: Sequence[str]
    names: Mapping[str, str]


def look(text: str) -> Impression:
    """Read a dance: check it, and draw its paths."""
    began = time.process_time()
    ok, line, picture = _looked(text)
    return {"ok": ok, "line": line, "picture": picture, "spent": time.process_time() - began}


def _looked(text: str) -> tuple[bool, str, str]:
    analysis = analyze(text)
    if not analysis.ok:
        found = mistakes(Path("dance"), analysis)
        return False, f"line {found[0].line}: {found[0].message}" if found else "it has errors", ""
    if not analysis.all_robots:
        return False, "no robot plays anything yet", ""
    picture = plot(score_of(analysis), most_moments=_MAX_MOMENTS, size=_SIZE)
    return True, summary(analysis), picture if len(picture) <= LARGEST_PICTURE else ""


def prepare(dances: Sequence[tuple[str, str]]) -> Prepared:
    """The score of one dance, or of several that play together. Each is a name and a program."""
    _, text = dances[0]
    sources = [Dance(name, analyze(text)) for name, text in dances]
    notes: Sequence[str] = ()
    robots: Sequence[Mapping[str, str]] = [{robot: robot for robot in sources[0].analysis.all_robots}]
    if len(dances) > 1:
        try:
            merged = merge(sources)
        except MergeError as problem:
            return _refused(str(problem))
        text, notes, robots = merged.text, merged.notes, merged.robots
    analysis = analyze(text)
    if not analysis.ok:
        return _refused(f"{dances[0][0]}: {look(text)['line']}")
    names = {
        new: source.name if len(own) == 1 else f"{source.name}: {old}"
        for source, own in zip(sources, robots, strict=True)
        for old, new in own.items()
    }
    return _prepared(dances[0][0], analysis, notes, names)


def embody(name: str, text: str, robot: str, toml: str) -> Prepared:
    """The score of a child's dance for a real robot, by the robot's table in this `improv.toml`."""
    dance = analyze(text)
    if not dance.ok:
        return _refused(f"{name}: {look(text)['line']}")
    if (count := len(dance.all_robots)) != 1:
        return _refused(f"{name}: a real robot can perform a dance for one robot, and this is one for {count}")
    own = renamed(dance, {dance.all_robots[0]: robot})
    real = analyze(own, read_robots(toml, Path(FILE_NAME)))
    wrong = [each.message for each in real.diagnostics if each.severity is Severity.ERROR or each.code in LIMITS]
    if real.ok and not wrong:
        return _prepared(name, real, (), {})
    return _refused(f"{name}: {robot} can't perform it: {wrong[0] if wrong else 'its improv.toml has errors'}")


def _prepared(name: str, analysis: Analysis, notes: Sequence[str], names: Mapping[str, str]) -> Prepared:
    played = score_of(analysis)
    score = to_json(played)
    if len(json.dumps(score)) > LARGEST_SCORE:
        return _refused(f"{name}: {LONG}")
    return {"score": score, "problem": "", "notes": [*notes, *_meetings(played, names)], "names": names}


def _meetings(score: Score, names: Mapping[str, str]) -> list[str]:
    """Say which robots will meet, by their children's names: the first ones of them."""
    found = check_room(score, most_work=MAX_WORK).meetings
    lines = [
        f"{' and '.join(names.get(robot, robot) for robot in each.robots)} meet at {moment(each.beat)}"
        for each in found[:MAX_MEETINGS]
    ]
    more = len(found) - len(lines)
    return [*lines, f"{more} more meet"] if more else lines


def _refused(problem: str) -> Prepared:
    return {"score": None, "problem": problem, "notes": (), "names": {}}


class DanceReader:
    """Sends dances to the process that reads them, one at a time. The first one starts it."""

    def __init__(self, limit: float = LIMIT) -> None:
        self._limit = limit
        self._process = Answerer(answer)
        self._process.limit = PATIENCE * limit
        self._one = asyncio.Lock()

    async def look(self, text: str) -> Impression | None:
        """Return an impression of a dance; None if reading it takes too long."""
        found: Impression | None = await self._ask(look, text)
        return found

    async def prepare(self, dances: Sequence[tuple[str, str]]) -> Prepared:
        """The score of one dance, or of several together."""
        return await self._ask(prepare, dances) or _refused(HEAVY)

    async def embody(self, name: str, text: str, robot: str, toml: str) -> Prepared:
        """The score of a dance for a real robot."""
        return await self._ask(embody, name, text, robot, toml) or _refused(HEAVY)

    def close(self) -> None:
        """End the process."""
        self._process.give_up()

    async def _ask(self, what: Callable[..., Any], *about: object) -> Any:
        """Return the answer; None if it took too long or the process has ended. Cancelling ends the process, so that
        the next question doesn't wait for an answer that nobody needs."""
        async with self._one:
            self._process.start()  # now, so that there is a process to end
            answering = asyncio.ensure_future(asyncio.to_thread(self._answer, Question(what, about, self._limit)))
            try:
                return await asyncio.shield(answering)
            except asyncio.CancelledError:
                self._process.give_up()
                await asyncio.wait([answering])
                raise

    def _answer(self, question: Question) -> Impression | Prepared | None:
        try:
            return self._process.ask(question)
        except (OSError, EOFError):
            self._process.close()
            return None


class Question(NamedTuple):
    """A function here, its arguments, and the seconds of processor time after which its process ends."""

    what: Callable[..., Impression | Prepared]
    about: Sequence[Any]
    limit: float


def answer(question: Question) -> Impression | Prepared:
    """Answer a question, in a process of its own."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
    _end_after(question.limit)
    found = question.what(*question.about)
    _end_after(0.0)
    return found


def _end_after(limit: float) -> None:
    """End this process after this many seconds of processor time; never, for 0. A signal without a handler does that
    even in the middle of a regular expression."""
    if sys.platform != "win32":
        signal.setitimer(signal.ITIMER_PROF, limit)
