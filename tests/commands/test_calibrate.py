"""`improv calibrate`: a conversation, with a simulated base whose wheels roll too little."""

from __future__ import annotations

import asyncio
import os
import re
import sys
from pathlib import Path

import pytest

from improv_core.commands.answers import TypedAnswers
from improv_core.commands.calibrate import check, command, offer
from improv_core.commands.exit_codes import CommandError
from improv_core.program.files import robots_near
from tests.commands.command_line import SIMULATED, Running
from tests.stage_on_thread import USED, StageOnThread

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
FAST = ("--tempo", "1000")


class Conversation(Running):
    """The command, and a person's answers."""

    def __init__(self, *options: str) -> None:
        source, self._typed = os.pipe()
        self._stdin = pytest.MonkeyPatch()
        self._stdin.setattr(sys, "stdin", os.fdopen(source))
        super().__init__("calibrate", "anna", *SIMULATED, *FAST, *options)

    def answer(self, question: str, *answers: str) -> None:
        """Answer a question, and after each answer but the last, the advice to write a number."""
        self.wait(question)
        for answer in answers[:-1]:
            os.write(self._typed, f"{answer}\n".encode())
            self.wait("write a number")
        os.write(self._typed, f"{answers[-1]}\n".encode())

    def end(self) -> tuple[object, list[str]]:
        try:
            return super().end()
        finally:
            sys.stdin.close()
            os.close(self._typed)
            self._stdin.undo()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "improv.toml").write_text(ROBOTS)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow("a robot drives the distances that are measured")
def test_the_simulated_base_keeps_to_its_path_afterward(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("improv_core.commands.calibrate.MIN_ROUNDS", 2)
    terminal = Conversation()
    terminal.wait("In improv.toml, a step is 0.2 m, and a quarter turn 90°.")
    terminal.answer("How many meters of free floor are ahead of anna, at least a step of 0.2 m? [2]", "0.1", "0.6")
    for _ in range(3):
        terminal.answer("Press Enter: anna drives 0.6", "")
        terminal.answer("Press Enter: anna turns left on the spot, twice", "")
    terminal.wait("before: 0.570 m instead of 0.600 m, 1.6° to the right; 684.0° instead of 720.0°")
    assert terminal.next().startswith("after:  0.600 m instead of 0.600 m, 0.0° to the ")
    terminal.answer("improv.toml? [y/N]", "y")
    code, said = terminal.end()
    assert (code, said) == (0, [f"{folder / 'improv.toml'} was written\n"])
    added = "commanded_step = 0.2105\ncommanded_quarter_turn = 94.74\nleft_right = 1.0213\n"
    calibrated = ROBOTS.replace("0.94]\n", f"0.94]\n{added}")
    assert (folder / "improv.toml").read_text() == calibrated


@pytest.mark.slow("a robot drives the distances that are measured")
def test_a_tape_measure_nonsense_and_ctrl_c_in_the_middle(folder: Path) -> None:
    terminal = Conversation("--tape", "--write")
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
    terminal.interrupt()
    code, said = terminal.end()
    assert (code, said[-1]) == (130, "improv: interrupted: improv.toml was not changed\n")
    assert (folder / "improv.toml").read_text() == ROBOTS


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (None, "there is no improv.toml here: write one with a section [robots.anna]"),
        ("[robots.bert]\n", "lists no robot `anna`: add a section [robots.anna] with its profile"),
        ("[robots.anna]\nwings = 2\n", "has errors"),
        ('[robots.anna]\nprofile = "a"\n[profiles.a]\nstep = 1\nmotions = ["climb"]\n', "lacks the motions"),
        ("[robots.anna]\n", "no answer: nothing was changed"),
    ],
)
def test_unsuitable_robots_are_not_calibrated(
    text: str | None, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(USED, StageOnThread)
    if text is not None:
        (tmp_path / "improv.toml").write_text(text)
    with (tmp_path / "nothing").open("w+") as nobody:
        monkeypatch.setattr(sys, "stdin", nobody)
        with pytest.raises(CommandError, match=re.escape(why)):
            command(["anna", *SIMULATED], standalone_mode=False)
    assert (tmp_path / "improv.toml").exists() == (text is not None)


def offered(folder: Path, text: str) -> list[str]:
    """Return the lines when values are offered for this improv.toml."""
    (folder / "improv.toml").write_text(text)
    said: list[str] = []
    asyncio.run(offer(robots_near(folder), "anna", {"commanded_step": 2.1}, TypedAnswers(said.append), write=True))
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


def test_values_that_no_profile_can_have_are_refused() -> None:
    with pytest.raises(CommandError, match=r"`left_right` would be 1\.4 meters per meter, which is not from 0\.8 to"):
        check({"commanded_step": 0.2, "left_right": 1.4})
