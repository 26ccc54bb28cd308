"""Plays a program once: in a terminal, or as fast as this machine can."""

from __future__ import annotations

import signal
import time
from pathlib import Path

from improv_core.commands.echo import echo, echo_json
from improv_core.commands.exit_codes import FAILED, INTERRUPTED, PROBLEMS, CommandError
from improv_core.commands.programs import read_to_play
from improv_core.commands.results import Results
from improv_core.commands.settings import PlaySettings
from improv_core.commands.terminal import USUAL, first, performance
from improv_core.outputs.recording.recorder import Recorder, sensed_in
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.report import summary
from improv_core.protocol.decoding import ProtocolError
from improv_core.protocol.fields import to_pose_json
from improv_core.protocol.messages import FromStage, Sensed
from improv_core.score.movement import ENDLESS
from improv_core.score.score import Score
from improv_core.session.start import Options


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
    settings: PlaySettings = USUAL,
    *,
    browser: bool,
    report: bool = False,
    stays: bool = False,
    recorder: Recorder | None = None,
) -> int:
    """Play a program without errors once. Return the exit code.

    If it `stays`, its page can play it again until an interrupt.

    Raises StageError; OSError and ValueError if the recording fails.
    """
    async with performance(
        options,
        browser=browser,
        quiet=report,
        recorder=recorder,
        settings=settings,
        begins_with=path.name,
        hosts=score_of(settings.chosen(analysis).analysis).hosts,
    ) as performing:
        performing.stays = stays
        await performing.play(analysis, path)
        await first(performing.finished.wait(), performing.refused.wait(), performing.interrupted.wait())
        if performing.refused.is_set():
            if report:
                echo_json(performing.report())
            return FAILED
        was_interrupted = performing.interrupted.is_set()
        stopped = was_interrupted or performing.stops.count > 0 or bool(performing.stops.pressed["topics"])
        results = performing.results  # lines have already given the reasons
        failed = results.state == "stopped" or any(each.fault == "joints" for each in results.errors.faults)
        if not stopped:
            await performing.settle()
        if stays and performing.has_page and not performing.interrupted.is_set() and not performing.broken.is_set():
            performing.screen.say("play it again on the page, or press Ctrl-C to end")
            await first(performing.broken.wait(), performing.interrupted.wait())
    if report:
        echo_json(performing.report())
    return INTERRUPTED if stopped else FAILED if failed or performing.broken.is_set() else 0


def check_end(score: Score, seconds: float | None) -> None:
    """Raise CommandError if neither a score nor a number of seconds ends a performance."""
    if score.beats == ENDLESS and seconds is None:
        raise CommandError("this program never ends: limit it, for example with `--for 60` (seconds)")


def play_fast(path: Path, seconds: float | None, settings: PlaySettings, *, report: bool) -> int:
    """Play a program in the simulator without the page, faster than real time. Return the exit code.

    Raises ReadError and CommandError.
    """
    from improv_core.stage.dry_run import simulate

    if not (analysis := read_to_play(path)):
        return PROBLEMS
    chosen = settings.chosen(analysis)
    analysis, score = chosen.analysis, score_of(chosen.analysis)
    check_end(score, seconds)
    results = Results()

    def tell(message: FromStage) -> None:
        if message["type"] == "transport":
            results.follow(message, leads=True)
        elif message["type"] == "measured":
            results.measure(message)
        elif message["type"] == "warning" or message["type"] == "error":
            echo(f"improv: {message['message']}", err=True)

    # Ctrl-C ends it at once, even if a shell ignores it: there is nothing to clean up, and pymunk would swallow a
    # KeyboardInterrupt raised in our functions that it calls.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    began = time.perf_counter()
    ends = simulate(score, seconds, tell, settings.senses)
    results.keep_poses({"poses": {robot: to_pose_json(pose) for robot, pose in ends.items()}})
    ended = results.as_json(score)
    if report:
        echo_json(ended)
    else:
        took = time.perf_counter() - began
        named = f"{chosen.name}: " if chosen.name else ""
        echo(f"{named}{summary(analysis)}: {ended['seconds']:.1f} s, played in {took:.2f} s")
        for line in [*([chosen.note] if chosen.note else []), *results.errors.lines()]:
            echo(line)
    return 0
