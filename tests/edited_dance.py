"""A dance in which one robot's line is saved again and again while another robot keeps dancing, for real and
recorded."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from io import BytesIO
from pathlib import Path

from improv_core.commands.record import recording
from improv_core.commands.rehearsal import perform
from improv_core.commands.terminal import performance
from improv_core.outputs.recording.recorder import Recorder
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.session.start import Options

ANNA, BERT = "/anna/cmd_vel", "/bert/cmd_vel"


def program(beats: int, edit: int = 0) -> str:
    """Write a program in which Anna dances so many beats; bert's part differs with each edit, and has ended before hers
    has."""
    bert = f"bert $ slow {edit % 9 + 1} repeat 2 (forward left)\n" if edit % 10 != 9 else ""
    return f"# edit {edit}\nbeat 240\nanna $ repeat {beats // 2} (forward [left right right])\n{bert}"


async def play(
    beats: int, saves: int, output: Path, options: Options, before_save: Callable[[], Awaitable[object]]
) -> None:
    """Play it, save it so many times, and record the commands. `before_save` waits for the time of each save."""
    with recording(output) as recorder:
        async with performance(options, browser=False, quiet=True, recorder=recorder) as performing:
            await performing.play(analyze(program(beats)), Path("dance"))
            while not performing.is_playing:  # noqa: ASYNC110
                await asyncio.sleep(0.01)
            for edit in range(1, saves + 1):
                await before_save()
                await performing.play(analyze(program(beats, edit)), Path("dance"), when="now" if edit % 2 else "beat")
            await asyncio.wait_for(performing.finished.wait(), 600)


def record_undisturbed(beats: int, output: Path) -> None:
    """Compute and record anna's commands if nobody saves anything."""
    file = BytesIO()
    recorder = Recorder(file, 0)
    perform(score_of(analyze(program(beats))), recorder)
    recorder.finish()
    output.write_bytes(file.getvalue())
