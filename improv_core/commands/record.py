"""`improv record`: what robots are told, as an MCAP file. Computed at once, or as it is played."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import click

from improv_core.commands import terminal
from improv_core.commands.rehearsal import perform
from improv_core.playback.playback import Options
from improv_core.program.compiler import score_of
from improv_core.program.files import analyze_file
from improv_core.score.movement import ENDLESS
from improv_core.stage.sinks.recorder import Recorder


class RecordError(Exception):
    """There can be no recording; one plain line that says why."""


def record(path: Path, output: Path, seconds: float | None) -> int:
    """Record a program as fast as it can be computed, for some seconds at most; the exit code.

    Raises ReadError and RecordError.
    """
    analysis = analyze_file(path)
    terminal.tell_diagnostics(path, analysis)
    if not analysis.ok:
        return terminal.WRONG_PROGRAM
    score = score_of(analysis)
    if score.beats == ENDLESS and seconds is None:
        raise RecordError("this program never ends: say how much of it to record, as in `--for 60` (seconds)")
    began = time.perf_counter()
    for number in (signal.SIGINT, signal.SIGTERM):  # so that nothing half-made is left, also where a shell ignores one
        signal.signal(number, signal.default_int_handler)
    try:
        with recording(output) as recorder:
            perform(score, recorder, seconds)
    except KeyboardInterrupt:
        click.echo(f"improv: interrupted: {output} is not written", err=True)
        return terminal.INTERRUPTED
    click.echo(f"{_summary(output, recorder)} (made in {time.perf_counter() - began:.2f} s)")
    return 0


async def record_live(path: Path, output: Path, options: Options, *, browser: bool) -> int:
    """Play a program, and record what is sent as it is sent; the exit code.

    Raises ReadError, StageError and RecordError.
    """
    with recording(output) as recorder:
        code = await terminal.play(path, replace(options, report_sent=True), browser=browser, recorder=recorder)
    if code != terminal.WRONG_PROGRAM:
        click.echo(_summary(output, recorder))
    return code


@contextmanager
def recording(output: Path) -> Iterator[Recorder]:
    """A recorder into a file that takes its name once it is complete, and only if robots were told anything.

    Beat 0 is now. Raises RecordError, also for what the body raises where it can't be written or performed.
    """
    target = output.resolve()  # a link stays a link
    part = target.with_name(f".{target.name}.{os.getpid()}")
    if output.suffix != ".mcap":
        raise RecordError(f"{output}: give the recording a name that ends in .mcap")
    if target.exists() and not target.is_file():
        raise RecordError(f"{output} is not written: there is something else of that name")
    if target.exists() and not os.access(target, os.W_OK):
        raise RecordError(f"{output} is not written: permission denied")
    try:
        with part.open("wb") as file:
            recorder = Recorder(file, time.time_ns())
            yield recorder
            recorder.finish()
            file.flush()
            os.fsync(file.fileno())
        if recorder.commands:
            part.replace(target)
    except (OSError, ValueError, OverflowError) as error:
        why = error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)
        raise RecordError(f"{output} is not written: {why}") from None
    finally:
        part.unlink(missing_ok=True)


def _summary(output: Path, recorder: Recorder) -> str:
    if not recorder.commands:
        raise RecordError(f"no robot was told anything: {output} is not written")
    robots = "1 robot" if recorder.robots == 1 else f"{recorder.robots} robots"
    return f"{output}: {robots}, {recorder.commands} commands, {recorder.seconds:.1f} s"
