"""`improv play`: a program, once."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from datetime import datetime
from pathlib import Path

import click

from improv_core.commands import count_in as counting
from improv_core.commands import parameters, scenes
from improv_core.commands.begin_time import moment
from improv_core.commands.count_in import CountIn
from improv_core.commands.echo import echo, echo_json
from improv_core.commands.exit_codes import FAILED, INTERRUPTED, PROBLEMS, CommandError
from improv_core.commands.programs import read_to_play
from improv_core.commands.rehearsal import perform
from improv_core.commands.scenes import WantedScenes
from improv_core.commands.terminal import first, performance, run
from improv_core.outputs.recording.recorder import Recorder, sensed_in
from improv_core.player.reports import Told
from improv_core.player.sensing import foreseen
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.errors import Errors
from improv_core.program.report import outcome, summary
from improv_core.protocol.decoding import ProtocolError
from improv_core.protocol.messages import Arming, Sensed, TransportMessage
from improv_core.score.movement import ENDLESS
from improv_core.session.start import Options


def _time(text: str) -> datetime:
    """Convert an option that is a time. Raises BadParameter."""
    try:
        return moment(text, datetime.now())
    except ValueError as problem:
        raise click.BadParameter(str(problem)) from None


@click.command("play")
@parameters.file
@parameters.backend
@parameters.port
@parameters.no_browser
@parameters.osc_network
@counting.options
@scenes.options
@click.option("--fast", is_flag=True, help="Simulate without the page, as fast as this machine can.")
@click.option("--for", "seconds", type=parameters.seconds, help="With --fast, stop after this many seconds.")
@click.option("--senses", "recording", type=parameters.RECORDING, help="Make robots sense what a recording contains.")
@parameters.force
@click.option(
    "--armed", is_flag=True, help="Get everything ready, and begin when somebody presses Space, Enter, or Play."
)
@click.option(
    "--at", "begins", metavar="TIME", type=_time, help="Armed, and begin by itself at 20:15, or at an ISO time."
)
@click.option("--once", is_flag=True, help="End when the dance ends, even in a terminal.")
@click.option("--report", type=click.Choice(["json"]), help="At the end, print where the robots are.")
def command(
    file: Path,
    backend: str,
    port: int,
    no_browser: bool,
    osc_network: bool,
    count_in: CountIn,
    wanted: WantedScenes,
    fast: bool,
    seconds: float | None,
    recording: Path | None,
    force: bool,
    armed: bool,
    begins: datetime | None,
    once: bool,
    report: str | None,
) -> None:
    """Play a program. Ctrl-C stops the robots.

    FILE is a program, or - for standard input. In a terminal, the page can play it again after it has ended, until
    Ctrl-C.
    """
    if seconds and not fast:
        raise CommandError("--for requires --fast; stop a live run with Ctrl-C")
    if fast and backend in ("ros", "both"):
        raise CommandError("--fast works only in the simulator: real robots can't be sped up")
    if fast and (count_in.wanted or count_in.bell):
        raise CommandError("--fast begins at once: leave out --count-in and --bell")
    if fast and (armed or begins):
        raise CommandError("--fast begins at once: leave out --armed and --at")
    if fast:
        sys.exit(play_fast(file, seconds, report=report is not None, senses=senses_of(recording), wanted=wanted))
    options = parameters.options(file, backend, port, osc_network=osc_network)
    senses = senses_of(recording)
    if not (analysis := read_to_play(file)):
        sys.exit(PROBLEMS)
    scenes.chosen(analysis, wanted)  # before the search for robots
    stays = sys.stdout.isatty() and not once and not report
    playing = play(
        analysis,
        file,
        options,
        browser=not no_browser,
        report=report is not None,
        stays=stays,
        senses=senses,
        wanted=wanted,
        count_in=count_in,
        anyway=force,
        arming={"begins": begins.timestamp()} if begins else {} if armed else None,
    )
    sys.exit(run(playing))


def senses_of(recording: Path | None) -> list[Sensed] | None:
    """Return the senses of robots in a recording, if there is one. Raises CommandError if it can't be read."""
    if not recording:
        return None
    try:
        with recording.open("rb") as file:
            return sensed_in(file)
    except (OSError, ValueError, ProtocolError) as error:
        why = error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)
        raise CommandError(f"{recording} can't be read: {why}") from None


async def play(
    analysis: Analysis,
    path: Path,
    options: Options,
    *,
    browser: bool,
    report: bool = False,
    stays: bool = False,
    recorder: Recorder | None = None,
    senses: Sequence[Sensed] | None = None,
    wanted: WantedScenes | None = None,
    count_in: CountIn | None = None,
    anyway: bool = False,
    arming: Arming | None = None,
) -> int:
    """Play a program without errors once, and with `arming` not before somebody begins. Return the exit code.

    If it `stays`, its page can play it again until an interrupt.

    Raises StageError; OSError and ValueError if the recording fails.
    """
    async with performance(
        options,
        browser=browser,
        quiet=report,
        recorder=recorder,
        scenes=wanted,
        count_in=count_in or CountIn(),
        begins_with=path.name,
    ) as performing:
        await performing.play(analysis, path, senses=senses, anyway=anyway, arming=arming)
        await first(performing.finished.wait(), performing.refused.wait(), performing.interrupted.wait())
        if performing.refused.is_set():
            if report:
                echo_json(performing.report())
            return FAILED
        stopped = (
            performing.interrupted.is_set() or performing.stops.count > 0 or bool(performing.stops.pressed["topics"])
        )
        failed = performing.was_stopped and not stopped  # a line has already given the reason
        if not stopped:
            await performing.settle()
        if stays and performing.has_page and not performing.interrupted.is_set() and not performing.broken.is_set():
            performing.screen.say("play it again on the page, or press Ctrl-C to end")
            await first(performing.broken.wait(), performing.interrupted.wait())
    if report:
        echo_json(performing.report())
    return INTERRUPTED if stopped else FAILED if failed or performing.broken.is_set() else 0


def play_fast(
    path: Path,
    seconds: float | None,
    *,
    report: bool,
    senses: Sequence[Sensed] | None = None,
    wanted: WantedScenes | None = None,
) -> int:
    """Play a program in the simulator without the page, faster than real time. Return the exit code.

    Raises ReadError and CommandError.
    """
    from improv_core.outputs.simulator.simulator import Simulator

    if not (analysis := read_to_play(path)):
        return PROBLEMS
    chosen = scenes.chosen(analysis, wanted or WantedScenes())
    analysis, score = chosen.analysis, score_of(chosen.analysis)
    if score.beats == ENDLESS and seconds is None:
        raise CommandError("this program never ends: limit it, for example with `--for 60` (seconds)")
    last: TransportMessage | None = None
    errors = Errors()

    def tell(message: Told) -> None:
        nonlocal last
        if message["type"] == "transport":
            last = message
        elif message["type"] == "measured":
            errors.take(message)
        elif message["type"] == "warning" or message["type"] == "error":
            echo(f"improv: {message['message']}", err=True)

    # Ctrl-C ends it at once, even if a shell ignores it: there is nothing to clean up, and pymunk would swallow a
    # KeyboardInterrupt raised in our functions that it calls.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    began = time.perf_counter()
    simulator = Simulator(period=None)
    perform(score, simulator, seconds, tell, None if senses is None else map(foreseen, senses))
    poses = {robot: asdict(pose) for robot, pose in simulator.poses().items()}
    ended = outcome(last, {"start": last.get("start", {}) if last else {}, "poses": poses}, errors, score)
    if report:
        echo_json(ended)
    else:
        took = time.perf_counter() - began
        named = f"{chosen.name}: " if chosen.name else ""
        echo(f"{named}{summary(analysis)}: {ended['seconds']:.1f} s, played in {took:.2f} s")
        for line in [*([chosen.note] if chosen.note else []), *errors.lines()]:
            echo(line)
    return 0
