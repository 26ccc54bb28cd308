"""The cue, given in the terminal by a key."""

from __future__ import annotations

import os
import pty
import subprocess
from pathlib import Path

from tests.commands.command_line import IMPROV, LIMIT


def test_a_key_in_the_terminal_gives_the_cue(tmp_path: Path) -> None:
    program = tmp_path / "wait.improv"
    program.write_text("beat 600\nr $ until cue (repeat forward)\n")
    ours, theirs = pty.openpty()
    command = [*IMPROV, "play", str(program), "--once", "--backend", "sim", "--no-browser"]
    # In a session of its own, whose terminal this is.
    process = subprocess.Popen(
        ["setsid", "--ctty", "--wait", *command], stdin=theirs, stdout=theirs, stderr=theirs, cwd=tmp_path
    )
    os.close(theirs)
    try:
        said = b""
        while "▶".encode() not in said:
            said += os.read(ours, 1024)
        os.write(ours, b"xc")
        while True:
            try:
                if not os.read(ours, 1024):
                    break
            except OSError:  # so Linux says that the other side is closed
                break
        assert process.wait(LIMIT) == 0
    finally:
        process.kill()
        process.wait()
        os.close(ours)
