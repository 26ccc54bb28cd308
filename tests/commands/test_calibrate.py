"""`improv calibrate`: a conversation in a terminal, with a simulated base whose wheels roll too little."""

from __future__ import annotations

import asyncio
import os
import pty
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from select import select

import pytest

from improv_core.commands.answers import Answers
from improv_core.commands.calibrate import check, command, offer
from improv_core.commands.exit_codes import CommandError
from improv_core.program.files import robots_near
from tests.commands.command_line import IMPROV, LIMIT

ROBOTS = """# ours
[profiles.worn]  # since spring
step = 0.2
dynamics = "motors"
max_linear_acceleration = 1000
max_angular_acceleration = 1000
wheel_error = [0.96, 0.94]

[robots.anna]
profile = "worn"
"""
FAST = ("--tempo", "600")


class Terminal:
    """A terminal in which the command runs, and what it shows."""

    def __init__(self, folder: Path, *options: str) -> None:
        self._ours, theirs = pty.openpty()
        arguments = [*IMPROV, "calibrate", "anna", "--backend", "sim", "--no-browser", *FAST, *options]
        # In a session of its own, whose terminal this is.
        self.process = subprocess.Popen(
            ["setsid", "--ctty", "--wait", *arguments], stdin=theirs, stdout=theirs, stderr=theirs, cwd=folder
        )
        os.close(theirs)
        self._unread = ""

    def wait(self, part: str) -> None:
        """Until it shows something after what was waited for before."""
        while part not in self._unread:
            assert select([self._ours], [], [], LIMIT)[0], self._unread
            self._unread += os.read(self._ours, 4096).decode(errors="replace")
        self._unread = self._unread.split(part, 1)[1]

    def answer(self, question: str, *answers: str) -> None:
        """Answer a question, and after each answer but the last, the advice to write a number."""
        self.wait(question)
        for answer in answers[:-1]:
            self.type(f"{answer}\n")
            self.wait("write a number")
        self.type(f"{answers[-1]}\n")

    def type(self, keys: str) -> None:
        os.write(self._ours, keys.encode())

    def end(self) -> tuple[int, str]:
        """The exit code, and what else was shown."""
        with suppress(OSError):  # so Linux says that the other side is closed
            while more := os.read(self._ours, 4096):
                self._unread += more.decode(errors="replace")
        return self.process.wait(LIMIT), self._unread

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._ours)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "improv.toml").write_text(ROBOTS)
    return tmp_path


@pytest.fixture
def terminals(folder: Path) -> Iterator[list[Terminal]]:
    opened: list[Terminal] = []
    yield opened
    for terminal in opened:
        terminal.close()


def test_the_simulated_base_keeps_to_its_path_afterward(folder: Path, terminals: list[Terminal]) -> None:
    terminals.append(terminal := Terminal(folder))
    terminal.wait("As improv.toml says, a step is to be 0.2 m, and a quarter turn 90°.")
    terminal.answer("How many meters of free floor are ahead of anna, at least a step of 0.2 m? [2]", "0.1", "0.6")
    for _ in range(4):
        terminal.answer("Press Enter: anna drives 0.6", "")
        terminal.answer("Press Enter: anna turns left on the spot, twice", "")
    terminal.wait("before: 0.570 m instead of 0.600 m, 1.6° to the right; 684.0° instead of 720.0°")
    terminal.wait("after:  0.600 m instead of 0.600 m, 0.0° to the ")
    terminal.wait("719.9° instead of 720.0°")
    terminal.answer("improv.toml? [y/N]", "y")
    code, said = terminal.end()
    assert (code, "was written" in said) == (0, True)
    added = "commanded_step = 0.2105\ncommanded_quarter_turn = 94.74\nleft_right = 1.0213\n"
    calibrated = ROBOTS.replace("0.94]\n", f"0.94]\n{added}")
    assert (folder / "improv.toml").read_text() == calibrated


def test_a_tape_measure_nonsense_and_ctrl_c_in_the_middle(folder: Path, terminals: list[Terminal]) -> None:
    terminals.append(terminal := Terminal(folder, "--tape", "--write"))
    terminal.answer("free floor", "2 m", "nan", "0.6")
    terminal.answer("Put anna on its mark, along its line, and press Enter: anna drives", "")
    terminal.answer("How many meters is it ahead", "", "57,0", "57.0")
    terminal.answer("to the left of its line", "-0.015")
    terminal.wait("57.00 m can't be right for 0.60 m: check the numbers, and that anna listens on /anna/cmd_vel")
    terminal.answer("anna drives", "")
    terminal.answer("How many meters is it ahead", "0.57")
    terminal.answer("to the left of its line", "-0.015")
    terminal.answer("anna turns left", "")
    terminal.answer("How many degrees beyond two full turns is it", "-36")
    terminal.answer("anna drives", "")
    terminal.wait("▶ anna")
    terminal.type("\x03")
    code, said = terminal.end()
    assert code == 130
    assert "improv: interrupted: improv.toml was not changed" in said
    assert (folder / "improv.toml").read_text() == ROBOTS


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (None, "there is no improv.toml here: write one with a section [robots.anna]"),
        ("[robots.bert]\n", "lists no robot `anna`: add a section [robots.anna] with its profile"),
        ("[robots.anna]\nwings = 2\n", "has errors"),
        ('[robots.anna]\nprofile = "a"\n[profiles.a]\nstep = 1\nmotions = ["climb"]\n', "lacks the motions"),
        ("[robots.anna]\n", "nobody answers: nothing was changed"),
    ],
)
def test_what_can_not_be_calibrated(
    text: str | None, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if text is not None:
        (tmp_path / "improv.toml").write_text(text)
    with (tmp_path / "nothing").open("w+") as nobody:
        monkeypatch.setattr(sys, "stdin", nobody)
        with pytest.raises(CommandError, match=re.escape(why)):
            command(["anna", "--backend", "sim", "--no-browser"], standalone_mode=False)
    assert (tmp_path / "improv.toml").exists() == (text is not None)


def offered(folder: Path, text: str, *, changed: str | None = None) -> list[str]:
    """What is said when values are offered for this improv.toml, which may have been changed meanwhile."""
    (folder / "improv.toml").write_text(text)
    robots = robots_near(folder)
    if changed:
        (folder / "improv.toml").write_text(changed)
    said: list[str] = []
    asyncio.run(offer(robots, "anna", {"commanded_step": 2.1}, Answers(said.append), write=True))
    return said


def test_the_edit_is_shown_and_made(tmp_path: Path) -> None:
    lines = "\n".join(offered(tmp_path, "[robots.anna]\n"))
    assert '+profile = "anna"\n+\n+[profiles.anna]\n+step = 2\n+commanded_step = 2.1\n' in lines
    assert (
        tmp_path / "improv.toml"
    ).read_text() == '[robots.anna]\nprofile = "anna"\n\n[profiles.anna]\nstep = 2\ncommanded_step = 2.1\n'


def test_an_unusual_form_is_left_to_its_author(tmp_path: Path) -> None:
    text = "robots.anna = {}\n"
    assert offered(tmp_path, text) == [
        f"{tmp_path}/improv.toml is written in an unusual form, so write this into the profile yourself:"
        " commanded_step = 2.1"
    ]
    assert (tmp_path / "improv.toml").read_text() == text


def test_what_somebody_else_has_written_meanwhile_stays(tmp_path: Path) -> None:
    with pytest.raises(CommandError, match="has changed since the calibration began, so it was not written"):
        offered(tmp_path, "[robots.anna]\n", changed="[robots.anna]\n# mine\n")
    assert (tmp_path / "improv.toml").read_text() == "[robots.anna]\n# mine\n"


def test_values_that_no_profile_can_have_are_refused() -> None:
    with pytest.raises(CommandError, match=r"`left_right` would be 1\.4 meters per meter, which is not from 0\.8 to"):
        check({"commanded_step": 0.2, "left_right": 1.4})
