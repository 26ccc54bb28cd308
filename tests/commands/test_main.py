"""What all commands have in common."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from improv_core.commands.main import COMMANDS
from tests.commands.command_line import LIMIT, SQUARE, run


def test_check_needs_neither_the_server_nor_a_robot() -> None:
    code = "import sys; sys.argv = ['improv', 'check', sys.argv[1]]\nimport atexit\n"
    code += "atexit.register(lambda: print(*sys.modules))\nfrom improv_core.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code, str(SQUARE)], capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    packages = {name.partition(".")[0] for name in done.stdout.split()}
    assert packages.isdisjoint({"pygls", "lsprotocol", "pymunk", "aiohttp", "rclpy", "asyncio", "watchfiles"})


def test_each_command_has_help_of_its_own() -> None:
    whole = run("--help").stdout
    for name in COMMANDS:
        done = run(name, "--help")
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith(f"Usage: python -m improv_core {name} [OPTIONS]")
        assert f"\n  {name} " in whole


FULL, CLOSED = "/dev/full", "a closed pipe"
needs_full = pytest.mark.skipif(not Path(FULL).exists(), reason=f"no {FULL}")


def write_to(output: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command whose standard output is this file, or a pipe that nobody reads."""
    if output == CLOSED:
        reading, writing = os.pipe()
        os.close(reading)
    else:
        writing = os.open(output, os.O_WRONLY)
    try:
        command = [sys.executable, "-m", "improv_core", *map(str, arguments)]
        env = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
        return subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=LIMIT, env=env)
    finally:
        os.close(writing)


ENDLESS = "r $ repeat forward\n"
WRITING = [
    ["--help"],
    ["--version"],
    ["compile", SQUARE],
    ["check", "--format", "json", SQUARE],
    ["play", "--fast", SQUARE],
    ["play", "dance.improv", "--backend", "sim", "--no-browser"],
    ["watch", "dance.improv", "--backend", "sim", "--no-browser"],
    ["doctor", "dance.improv"],
]


@needs_full
@pytest.mark.parametrize("arguments", WRITING, ids=lambda arguments: arguments[0])
def test_output_that_can_not_be_written_is_one_line(
    arguments: list[str | Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dance.improv").write_text(ENDLESS)
    done = write_to(FULL, *arguments)
    assert (done.returncode, done.stderr) == (2, "improv: cannot write to standard output: no space left on device\n")


@pytest.mark.parametrize("arguments", WRITING, ids=lambda arguments: arguments[0])
def test_a_closed_pipe_is_quiet(arguments: list[str | Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dance.improv").write_text(ENDLESS)
    done = write_to(CLOSED, *arguments)
    assert done.returncode != 0
    assert done.stderr == ""


@needs_full
def test_a_recording_is_kept_though_nothing_can_be_printed(tmp_path: Path) -> None:
    (tmp_path / "dance.improv").write_text("beat 600\nr $ forward\n")
    path = tmp_path / "dance.mcap"
    done = write_to(FULL, "record", tmp_path / "dance.improv", "-o", path)
    assert (done.returncode, done.stderr) == (2, "improv: cannot write to standard output: no space left on device\n")
    assert path.stat().st_size
