"""No text in a file, its name or an argument steers the terminal in which `improv` runs."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from improv_core.commands.main import improv
from tests.commands.command_line import shown_in_terminal, usual_signals
from tests.untrusted import EXPLOITS, FOREIGN, steering

TOML = '[robots.{0}]\nprofile = {0}\n{0} = 1\n[profiles.{0}]\nbase = "turtle"\n'
PROGRAM = "{0} $ forward {0}\n{0} = left\nr $ left\nq $ {0}\n"
COMMANDS = [
    ["check"],
    ["check", "--format", "json"],
    ["check", "--format", "github"],
    ["compile"],
    ["format", "--check"],
    ["play", "--fast"],
]


def quoted(text: str) -> str:
    """Quote a string for TOML."""
    plain = "".join(char if " " <= char not in '"\\\x7f' else f"\\U{ord(char):08x}" for char in text)
    return f'"{plain}"'


def file_name(text: str) -> str:
    return os.fsdecode(os.fsencode(text.replace("/", "_").replace("\0", ""))[:200]) + ".improv"


@given(FOREIGN, FOREIGN, FOREIGN, st.sampled_from(COMMANDS))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_input_reaches_the_terminal_as_it_is(
    tmp_path: Path, name: str, word: str, key: str, command: list[str]
) -> None:
    path = tmp_path / file_name(name)
    path.write_text(PROGRAM.format(word), encoding="utf-8", newline="")
    (tmp_path / "improv.toml").write_text(TOML.format(quoted(key)), encoding="utf-8")
    with usual_signals():
        done = CliRunner().invoke(improv, [*command, str(path)], color=True)
    path.unlink()
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert steering(without_colors(done.output)) == set()
    assert not any(line.startswith(("two", "three", "four")) for line in done.output.splitlines())


@pytest.mark.parametrize("exploit", EXPLOITS)
def test_output_does_not_steer_the_terminal(tmp_path: Path, exploit: str) -> None:
    text = EXPLOITS[exploit]
    path = tmp_path / file_name(text)
    path.write_text(PROGRAM.format(text), encoding="utf-8", newline="")
    missing = path.with_name(f"not {path.name}")
    commands: list[list[str | Path]] = [["check", path], ["format", "--diff", path], ["check", missing]]
    commands.append(["check", f"--{text}", path])
    for arguments in commands:
        shown = without_colors(shown_in_terminal(*arguments))
        assert steering(shown, "\r\n") == set(), arguments


def without_colors(shown: str) -> str:
    """Return terminal output without the colors of carets, which are our own."""
    return re.sub(r"\x1b\[3[1-6]m( +\^+)\x1b\[0m", r"\1", shown)


def test_a_diff_is_exact_for_patch_and_escaped_in_a_terminal(tmp_path: Path) -> None:
    path = tmp_path / "dance.improv"
    path.write_text("r  $ left # \x1b[2J\n", encoding="utf-8")
    assert "+r $ left  # \x1b[2J\n" in CliRunner().invoke(improv, ["format", "--diff", str(path)]).output
    assert "+r $ left  # \\x1b[2J\n" in shown_in_terminal("format", "--diff", path)
