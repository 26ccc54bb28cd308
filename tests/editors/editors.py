"""The paths of the editors, and the processes that they have started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from tests.commands.command_line import program
from tests.needs import lacking, need
from tests.processes import wait_until_gone

ROOT = Path(__file__).parents[2]
LIMIT = 240.0
"""Seconds that a whole session in an editor may take on a busy machine."""
END_LIMIT = 60.0
"""Seconds after which no process that an editor has started may still run."""


def find(variable: str, fetched: str) -> str:
    """Return the path of the editor that the environment names, or that fetch.sh has unpacked."""
    path = os.environ.get(variable) or str(ROOT / ".cache" / fetched)
    if not Path(path).is_file():
        lacking(f"no {path}: run tests/editors/fetch.sh {fetched.split('/')[0]}, or set {variable}")
    return path


def follow(commands: str, env: Mapping[str, str]) -> None:
    """Run commands from a page of instructions in the repository, such as those that compile the grammar. This
    environment adds to the process's own."""
    need("node"), need("cc")
    tree_sitter = find("TREE_SITTER", "tree-sitter/usr/bin/tree-sitter")
    env = {**os.environ, "PATH": f"{Path(tree_sitter).parent}:{os.environ['PATH']}", **env}
    done = subprocess.run(["sh", "-euc", commands], cwd=ROOT, env=env, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr


@contextmanager
def nothing_left() -> Iterator[dict[str, str]]:
    """Yield an environment for an editor. On exit, the editor and all processes that it has started must end."""
    env = {**os.environ, "IMPROV_TEST": str(uuid4())}
    yield env
    processes = {}
    for pid in started_from(env):
        with suppress(ProcessLookupError):
            processes[pid] = os.pidfd_open(pid)
    wait_until_gone(processes, END_LIMIT)


def noting_browser(path: Path, page: Path) -> None:
    """Make a browser that only writes the address to a file."""
    program(path, f'echo "$1" >"{page}.new" && mv "{page}.new" "{page}"')


def slow_server(folder: Path) -> tuple[Path, Path]:
    """Make a server that starts only once a file, its gate, exists. Return the paths of both."""
    server, gate = folder / "slow-improv-ls", folder / "gate"
    wait = f'while [ ! -e "{gate}" ]; do kill -0 $PPID || exit; sleep 0.1; done'
    server.write_text(f'#!/bin/sh\n{wait}\nexec "{sys.executable}" -m improv_ls "$@"\n')
    server.chmod(0o755)
    return server, gate


def started_from(env: Mapping[str, str]) -> dict[int, dict[str, str]]:
    """Return the processes that have inherited this environment, each with its own environment."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            lines = os.fsdecode((process / "environ").read_bytes()).split("\0")
        except OSError:  # gone meanwhile, or another person's
            continue
        its = dict(line.split("=", 1) for line in lines if "=" in line)
        if its.get("IMPROV_TEST") == env["IMPROV_TEST"]:
            found[int(process.name)] = its
    return found


def program_of(pid: int) -> str:
    """Return the name of the program that a process runs, or an empty text if it has ended."""
    with suppress(OSError):
        return Path(f"/proc/{pid}/exe").resolve().name
    return ""


def servers_from(env: Mapping[str, str]) -> list[int]:
    """Return the language servers that have inherited this environment, even those that are only about to start."""

    def is_server(pid: int) -> bool:
        try:
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        except OSError:
            return False
        is_own = any(each.endswith((b"/improv-ls", b"slow-improv-ls")) for each in words)
        return is_own or (b"-m" in words and b"improv_ls" in words)

    return [pid for pid in started_from(env) if is_server(pid)]


def kill_servers(env: Mapping[str, str]) -> list[int]:
    """Kill the language servers of an editor. Return their process ids."""
    killed = servers_from(env)
    for pid in killed:
        os.kill(pid, signal.SIGKILL)
    return killed
