"""A child process as its parent sees it: its lines, and its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest

from improv_core.ipc.child import Child, Policy
from tests.processes import descendants, wait_until_gone
from tests.waiting import until

LIMIT = 60.0
PATIENT = Policy(LIMIT)
AT_ONCE = Policy(0.0)
SPEAK = "import os, subprocess, sys; from improv_core.protocol.json_lines import own_output; say = own_output()"


@contextmanager
def child(*code: str, policy: Policy = PATIENT) -> Iterator[Child]:
    started = Child([sys.executable, "-c", "\n".join(code)], policy, os.environ)
    try:
        yield started
    finally:
        started.kill()
        started.end()


def all_of(child: Child) -> list[bytes]:
    """Return all output of a child until its end."""
    lines: list[bytes] = []
    with suppress(EOFError):
        while said := child.read(LIMIT):
            lines += said
        pytest.fail("it still runs")
    return lines


def test_lines_are_whole_and_half_a_line_does_not_count() -> None:
    halves = ("print('1\\n2', end='', flush=True)", "input()", "print('3\\n4', end='')")
    with child(*halves) as speaks:
        assert speaks.read(LIMIT) == [b"1"]
        assert speaks.read(0.01) == []
        speaks.write(b"\n")
        assert all_of(speaks) == [b"23"]


def test_output_of_libraries_is_not_among_our_lines() -> None:
    prints = "os.write(1, b'no end'); print('a line', flush=True); subprocess.run(['echo', 'another'], check=True)"
    with child(SPEAK, "say(1)", prints, "say({'type': 'alive'})", prints) as speaks:
        assert all_of(speaks) == [b"1", b'{"type": "alive"}']


def test_its_last_error_is_known() -> None:
    with child("sys = 1", "raise ValueError('of\\nthis')", policy=Policy(LIMIT, errors=subprocess.PIPE)) as fails:
        assert all_of(fails) == []
        assert fails.wait() == 1
        until(lambda: fails.last_error == "this", lambda: fails.last_error)  # a thread reads it


def test_the_last_line_of_a_child_that_somebody_kills_is_no_reason() -> None:
    policy = Policy(LIMIT, errors=subprocess.PIPE)
    with child(SPEAK, "print('a log', file=sys.stderr)", "say(1)", "input()", policy=policy) as logs:
        assert logs.read(LIMIT) == [b"1"]
        os.kill(logs.pid, signal.SIGKILL)
        assert all_of(logs) == []
        assert logs.wait() == -signal.SIGKILL
        assert logs.last_error == ""


def test_a_child_that_does_not_read_delays_nobody_and_gets_everything_later() -> None:
    with child("input()", "print(len(input()))", policy=Policy(LIMIT, waits=False)) as slow:
        long = b"x" * 1_000_000
        slow.write(long[1:] + b"\n")
        slow.write(long + b"\n")
        assert until(lambda: slow.read(0.01)) == [b"1000000"]


def test_a_line_is_sent_at_once_as_far_as_the_pipe_has_room() -> None:
    with child("import sys", "print(len(sys.stdin.readline()))") as slow:
        os.kill(slow.pid, signal.SIGSTOP)
        rest = slow.write_now(long := b"x" * 1_000_000 + b"\n")
        assert 0 < len(rest) < len(long)
        assert slow.write_now(rest) == rest
        os.kill(slow.pid, signal.SIGCONT)
        slow.write(rest)
        assert slow.read() == [b"1000001"]


def test_nothing_is_sent_at_once_to_one_that_has_ended() -> None:
    with child("") as ended:
        assert ended.wait() == 0
        assert ended.write_now(b"1\n") == b"1\n"


def test_a_wider_pipe_takes_more() -> None:
    with child("input()", policy=Policy(LIMIT, waits=False, pipe_size=1 << 20)) as deaf:
        os.kill(deaf.pid, signal.SIGSTOP)
        deaf.write(b"x" * (1 << 20))
        assert not deaf._unsent


def test_writing_to_one_that_has_ended() -> None:
    for waits in (True, False):
        with child("", policy=Policy(LIMIT, waits=waits)) as ended:
            assert ended.wait() == 0
            if waits:
                with pytest.raises(OSError, match="pipe"):
                    ended.write(b"1\n")
            else:
                ended.write(b"1\n")


def test_the_end_of_its_input_ends_it_even_if_it_has_much_to_say() -> None:
    with child("import sys", "sys.stdin.read()", "print('x' * 1_000_000)", "sys.exit(3)") as talks:
        assert talks.end() == 3


def test_one_that_does_not_end_is_killed() -> None:
    with child("import time", "print(1, flush=True)", f"time.sleep({LIMIT * 10})", policy=AT_ONCE) as hangs:
        assert hangs.read(LIMIT) == [b"1"]
        hangs.end()
        assert hangs.wait() == -signal.SIGKILL


def test_a_leader_is_killed_with_all_that_it_has_started_except_other_leaders() -> None:
    start = f"subprocess.Popen(['sleep', '{LIMIT * 10}'], start_new_session="
    code = f"import subprocess; {start}False); {start}True)"
    with child(code, "print(1, flush=True)", "input()", policy=Policy(LIMIT, leads=True)) as it:
        assert it.read(LIMIT) == [b"1"]
        started = descendants(it.pid)
        survivor = next(pid for pid in started if os.getsid(pid) == pid)
        survives = started.pop(survivor)
        it.kill()
        assert it.wait() == -signal.SIGKILL
        wait_until_gone(started, LIMIT)
        os.kill(survivor, signal.SIGKILL)
        wait_until_gone({survivor: survives}, LIMIT)
