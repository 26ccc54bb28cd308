"""`improv record`: the commands for robots, as an MCAP file. Computed at once, or recorded as it plays."""

from __future__ import annotations

import asyncio
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import INTERRUPTED, PROBLEMS, CommandError
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.playing import check_end, play
from improv_core.commands.programs import read_to_play
from improv_core.commands.settings import PlaySettings
from improv_core.commands.terminal import run
from improv_core.outputs.recording.recorder import Recorder
from improv_core.outputs.simulator.collisions import Collisions, NoCollisions
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import FromStage
from improv_core.score.score import Score
from improv_core.session.start import Options
from improv_core.stage.dry_run import perform
from improv_core.storage.atomic_write import replacing, why


@click.command("record")
@parameters.file
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The .mcap file to write.")
@click.option("--for", "seconds", type=parameters.SECONDS, help="Record only this many seconds.")
@click.option("--backend", type=parameters.BACKENDS, help="Play the program now, and record what is sent.")
@parameters.port
@parameters.no_browser
@parameters.force
def command(
    file: Path, output: Path, seconds: float | None, backend: str | None, port: int, no_browser: bool, force: bool
) -> None:
    """Record the commands that robots get, for `ros2 bag play` and Foxglove.

    FILE is a program, or - for standard input.
    """
    if force and not backend:
        raise CommandError("--force is for robots that are not in their places: it needs --backend")
    if not backend:
        sys.exit(record(file, output, seconds))
    if seconds:
        raise CommandError("--for cannot be combined with --backend; stop a live run with Ctrl-C")
    options = LiveOptions(backend, port, not no_browser).options(file)
    sys.exit(run(record_live(file, output, options, browser=not no_browser, anyway=force)))


def record(path: Path, output: Path, seconds: float | None) -> int:
    """Record a program, or its first seconds, as fast as it can be computed. Return the exit code.

    Raises ReadError and CommandError.
    """
    if not (analysis := read_to_play(path)):
        return PROBLEMS
    score = score_of(analysis)
    check_end(score, seconds)
    began = time.perf_counter()
    for number in (signal.SIGINT, signal.SIGTERM):  # so that no partial file is left, even where a shell ignores them
        signal.signal(number, signal.default_int_handler)
    try:
        with recording(output) as recorder:
            compute(recorder, score, seconds)
    except KeyboardInterrupt:
        return _interrupted(output)
    echo(f"{_summary(output, recorder)} (computed in {time.perf_counter() - began:.2f} s)")
    return 0


def compute(recorder: Recorder, score: Score, seconds: float | None) -> None:
    """Record a score, or its first seconds, and what robots sense and decide in the simulator."""
    from improv_core.stage.process import report_sent

    recorder.prepare(score)
    # What robots hit changes only what they sense.
    simulator = Simulator(period=None, collide=Collisions if score.open else NoCollisions)
    report_sent(simulator, recorder.take, recorder.time)
    perform(score, simulator, seconds, partial(note, recorder))


def note(recorder: Recorder, message: FromStage) -> None:
    """Record senses and decisions of a computed performance."""
    if message["type"] == "sensed" or message["type"] == "decided":
        recorder.note(message, recorder.time(message["performed"]))


async def record_live(path: Path, output: Path, options: Options, *, browser: bool, anyway: bool = False) -> int:
    """Play a program, wherever robots stand if `anyway`, and record the commands as they are sent. Return the exit
    code.

    Raises ReadError, StageError and CommandError.
    """
    if not (analysis := read_to_play(path)):
        return PROBLEMS
    code = INTERRUPTED
    with suppress(asyncio.CancelledError), recording(output) as recorder:
        options = replace(options, report_sent=True)
        code = await play(analysis, path, options, PlaySettings(anyway=anyway), browser=browser, recorder=recorder)
    if code == INTERRUPTED and not recorder.setpoints:
        return _interrupted(output)
    echo(_summary(output, recorder))
    return code


@contextmanager
def recording(output: Path) -> Iterator[Recorder]:
    """Yield a recorder into a file that gets its name once it is complete, and only if robots got any commands.

    Beat 0 is now. Raises CommandError, also for exceptions of the body if it can't be written or performed.
    """
    if output.suffix.lower() != ".mcap":
        raise CommandError(f"{output}: the recording's name must end in .mcap")
    try:
        with suppress(_NothingRecordedError), replacing(output) as file:
            recorder = Recorder(file, time.time_ns())
            yield recorder
            recorder.finish()
            if not recorder.setpoints:
                raise _NothingRecordedError
    except (OSError, ValueError, OverflowError) as error:
        reason = why(error) if isinstance(error, OSError) else str(error)
        raise CommandError(f"{output} was not written: {reason}") from None


class _NothingRecordedError(Exception):
    """Keeps an empty recording from replacing another."""


def _interrupted(output: Path) -> int:
    echo(f"improv: interrupted: {output} was not written", err=True)
    return INTERRUPTED


def _summary(output: Path, recorder: Recorder) -> str:
    if not recorder.setpoints:
        raise CommandError(f"no robot got a command: {output} was not written")
    robots = "1 robot" if recorder.robots == 1 else f"{recorder.robots} robots"
    return f"{output}: {robots}, {recorder.setpoints} messages, {recorder.seconds:.1f} s"
