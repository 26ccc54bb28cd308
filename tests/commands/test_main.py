"""Features that all commands have in common."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from improv_core.commands.exit_codes import MEANINGS
from improv_core.commands.main import COMMANDS, improv, main
from tests.commands.command_line import IMPROV, LIMIT, SIMULATED, SQUARE, run, stop_within, usual_signals
from tests.stage_on_thread import USED, StageOnThread

PAGE = Path(__file__).parents[2] / "docs" / "command-line.md"


def test_check_needs_neither_the_server_nor_a_robot() -> None:
    code = "import sys; sys.argv = ['improv', 'check', sys.argv[1]]\nimport atexit\n"
    code += "atexit.register(lambda: print(*sys.modules))\nfrom improv_core.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code, str(SQUARE)], capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    packages = {name.partition(".")[0] for name in done.stdout.split()}
    assert packages.isdisjoint({"pygls", "lsprotocol", "pymunk", "aiohttp", "rclpy", "asyncio", "watchfiles"})


LIGHT = {
    *("improv_core", "improv_core.__main__", "improv_core.plain", "improv_core.commands", "improv_core.safety"),
    *(f"improv_core.commands.{name}" for name in ("main", "echo", "exit_codes", "group", "ros_arguments", "stop")),
    *(f"improv_core.commands.{name}" for name in ("begin_time", "parameters", "settings")),
    *(f"improv_core.commands.{name}" for name in ("edit", "new", "play", "watch")),
    *(f"improv_core.safety.{name}" for name in ("stop_socket", "stage_stops", "stop_request", "private_folder")),
}
"""Our modules that `improv stop`, help, and completion may import: somebody is in a hurry."""


def completing(words: str) -> dict[str, str]:
    """Return the environment in which bash asks for completions of the last word."""
    return {"_IMPROV_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}


@pytest.mark.parametrize(
    ("typed", "env"),
    [
        *[("stop", {}), ("stop --help", {}), ("--help", {}), ("", completing("improv pl"))],
        *(("", completing(f"improv {name} --")) for name in ("edit", "play", "watch")),
    ],
    ids=["stop", "help of stop", "help", "completion", "edit", "play", "watch"],
)
def test_a_command_for_people_in_a_hurry_imports_little(typed: str, env: dict[str, str], tmp_path: Path) -> None:
    code = f"import atexit, sys\natexit.register(lambda: print(*sys.modules))\nsys.argv = ['improv', *{typed.split()}]"
    command = stop_within(tmp_path, before=code)
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, env=os.environ | env)
    assert done.returncode == 0, done.stderr
    imported = set(done.stdout.splitlines()[-1].split())
    assert {name for name in imported if name.startswith("improv")} - LIGHT == set()
    assert imported.isdisjoint({"asyncio", "lark", "subprocess", "tempfile"})


def test_ctrl_c_while_the_command_is_imported_prints_no_traceback() -> None:
    code = """
import sys
from improv_core.__main__ import main
class Interrupted:
    def find_spec(self, name, *_):
        if name.startswith("improv_core.plain"):
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupted())
main()"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=LIMIT)
    assert (done.returncode, done.stderr) == (130, "")


def test_each_command_has_help_of_its_own() -> None:
    whole = run("--help").stdout
    for name in COMMANDS:
        done = run(name, "--help")
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith(f"Usage: improv {name} [OPTIONS]")
        assert f"\n  {name} " in whole
        assert COMMANDS[name][1] in " ".join(done.stdout.split())


def help_in(columns: int, *group: str) -> str:
    """Return the help in a terminal of this width."""
    shown = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(shown), suppress(SystemExit):
        patch.setenv("COLUMNS", str(columns))
        improv([*group, "--help"], prog_name="improv")
    return shown.getvalue()


def test_help_is_as_wide_as_the_terminal_and_cuts_nothing_off() -> None:
    wide, narrow = help_in(120), help_in(60)
    assert wide.split() == narrow.split()
    assert max(map(len, narrow.splitlines())) <= 60
    sentence = "Live coding for robot motion: write a few words of choreography, and robots move."
    assert f"  {sentence}\n" in wide
    for group in ([], ["history"], ["ros"]):
        assert "..." not in help_in(60, *group).partition("Options:")[2]


@pytest.mark.parametrize("group", [[], ["ros"]], ids=str)
def test_a_command_alone_shows_its_help(group: list[str]) -> None:
    shown, helped = CliRunner().invoke(improv, group), CliRunner().invoke(improv, [*group, "--help"])
    assert (shown.exit_code, shown.output) == (2, helped.output)


@pytest.mark.parametrize(
    ("typed", "advice"),
    [
        (["chek"], "no such command 'chek': did you mean `improv check`?"),
        (["ros", "setpu"], "no such command 'setpu': did you mean `improv ros setup`?"),
        ([str(SQUARE)], f"no such command '{SQUARE}': did you mean `improv play {SQUARE}`?"),
        (["\x1b"], r"No such command '\x1b'."),
    ],
)
def test_the_likely_command_is_suggested(typed: list[str], advice: str) -> None:
    done = CliRunner().invoke(improv, typed, prog_name="improv")
    assert (done.exit_code, done.output.splitlines()[-1]) == (2, f"Error: {advice}")


@pytest.mark.parametrize("command", ["check", "format", "edit"])
def test_names_that_no_file_can_have_are_reported_in_one_line(command: str) -> None:
    name = "x" * 300 + ".improv"
    done = CliRunner().invoke(improv, [command, name])
    assert (done.exit_code, done.output) == (2, f"improv: {name}: file name too long\n")


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("pl", ["plot", "play", "place"]),
        ("play --back", ["--backend"]),
        ("play --backend b", ["both"]),
        ("chek pl", ["plot", "play", "place"]),
    ],
)
def test_half_typed_words_are_completed(typed: str, completed: list[str]) -> None:
    *words, half = typed.split()
    found = ShellComplete(improv, {}, "improv", "_IMPROV_COMPLETE").get_completions(words, half)
    assert [each.value for each in found] == completed


def test_the_documents_and_the_help_list_the_exit_codes() -> None:
    rows = re.findall(r"^\| (\d+) \| (.*) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert {int(code): meaning for code, meaning in rows} == MEANINGS
    shown = help_in(120)
    assert all(f"  {code:<3}  {meaning}\n" in shown for code, meaning in MEANINGS.items())


def test_an_interrupt_is_no_traceback(tmp_path: Path) -> None:
    command = [*IMPROV, "check", "-"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdin
    process.stdin.write("r $ left\n" * 100_000)  # more than a pipe holds: once it is written, somebody reads it
    process.stdin.flush()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=LIMIT)
    assert (process.returncode, errors) == (130, "improv: interrupted\n")


FULL, CLOSED = "/dev/full", "a closed pipe"
needs_full = pytest.mark.skipif(not Path(FULL).exists(), reason=f"no {FULL}")


def opened(output: str) -> int:
    """Open this file, or a pipe that nobody reads."""
    if output != CLOSED:
        return os.open(output, os.O_WRONLY)
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def write_to(output: str, *arguments: str | Path) -> tuple[object, str]:
    """Run a command whose standard output is this: return its exit code, and its error output."""
    said = io.StringIO()
    with os.fdopen(opened(output), "w") as stream, pytest.MonkeyPatch.context() as patch, usual_signals():
        patch.setattr(USED, StageOnThread)
        patch.setattr(sys, "argv", ["improv", *map(str, arguments)])
        patch.setattr(sys, "stdout", stream)
        with redirect_stderr(said):
            try:
                main()
            except SystemExit as ended:
                sys.stdout.flush()  # as Python does at its end
                return ended.code, said.getvalue()
            finally:
                with suppress(OSError):  # nor can the stream be written
                    sys.stdout.close()
    raise AssertionError("it has not ended")


ENDLESS = "r $ repeat forward\n"
WRITING = [
    ["--help"],
    ["--version"],
    ["compile", SQUARE],
    ["check", "--format", "json", SQUARE],
    ["play", "--fast", SQUARE],
    ["play", "dance.improv", *SIMULATED],
    ["watch", "dance.improv", *SIMULATED],
    ["doctor", "dance.improv"],
]


@pytest.fixture
def dance(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("dance.improv").write_text(ENDLESS)
    return tmp_path / "dance.improv"


NO_SPACE = "improv: cannot write to standard output: no space left on device\n"


@needs_full
@pytest.mark.parametrize("arguments", WRITING, ids=lambda arguments: arguments[0])
def test_output_that_can_not_be_written_is_one_line(arguments: list[str | Path], dance: Path) -> None:
    assert write_to(FULL, *arguments) == (2, NO_SPACE)


@pytest.mark.parametrize("arguments", WRITING, ids=lambda arguments: arguments[0])
def test_a_closed_pipe_is_quiet(arguments: list[str | Path], dance: Path) -> None:
    code, said = write_to(CLOSED, *arguments)
    assert code != 0
    assert said == ""


@needs_full
@pytest.mark.parametrize(("output", "said"), [(FULL, NO_SPACE), (CLOSED, "")])
def test_the_end_of_the_process_adds_nothing(output: str, said: str) -> None:
    """Python writes the rest when it ends, and complains if it can't."""
    writing = opened(output)
    command = [sys.executable, "-m", "improv_core", "compile", str(SQUARE)]
    env = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=LIMIT, env=env)
    os.close(writing)
    assert (done.returncode, done.stderr) == (2, said)


@needs_full
def test_a_recording_is_kept_though_nothing_can_be_printed(dance: Path) -> None:
    path = dance.with_suffix(".mcap")
    assert write_to(FULL, "record", dance, "-o", path, "--for", "1") == (2, NO_SPACE)
    assert path.stat().st_size
