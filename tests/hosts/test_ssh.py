"""Whatever goes wrong on another machine is one plain line here, nothing runs there, and nothing is left but the cache:
with a real ssh server on this machine."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from improv_core.hosts.bundle import boot_line, bundle
from improv_core.hosts.connect import ssh_command
from improv_core.safety.allowed import checked
from tests.hosts.sshd import LIMIT, NAME, Host, a_host
from tests.processes import descendants, wait_until_gone


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Host]:
    with a_host(tmp_path_factory.mktemp("host"), {}) as host:
        yield host


@pytest.fixture
def host(shared: Host) -> Host:
    """A host as it should be, except for ROS 2."""
    shared.allow(NAME, "off", "nowhere")
    shared.authorized.write_text((shared.folder / "ours.pub").read_text())
    shared.trust()
    shared.install_python({})
    return shared


def check(host: Host, line: str, name: str = NAME) -> None:
    """Check that a link to a host sends one line until it ends, which it does by itself, and that no process is left
    here or there. The line begins like this; test_texts.py has the whole lines."""
    before = descendants(os.getpid())
    pipe = subprocess.PIPE
    with subprocess.Popen(host.command(host=name), env=host.env, stdin=pipe, stdout=pipe, stderr=pipe) as link:
        assert link.stdout
        assert link.stderr
        told, errors = link.stdout.read(), link.stderr.read()  # its input stays open meanwhile
        assert (link.wait(LIMIT), errors) == (2, b"")
    wait_until_gone({pid: fd for pid, fd in descendants(os.getpid()).items() if pid not in before}, LIMIT)
    message = json.loads(told)
    assert message["type"] == "error"
    assert message["message"].startswith(line)


def change_key(host: Host) -> None:
    host.make_key("other")
    kind, key, _ = (host.folder / "other.pub").read_text().split()
    host.known.write_text(f"[127.0.0.1]:{host.port} {kind} {key}\n")


def runs(code: str) -> Callable[[Host], None]:
    return lambda host: host.run_first(code)


def begins(rest: str) -> Callable[[Host], None]:
    return runs(f"print('improv', '{{\"begins\": true}}'); print({rest}, flush=True); sys.exit()")


ENDS = runs("print('improv', '{\"wants\": true}', flush=True); sys.stdin.buffer.read(1000); sys.exit()")
PROBLEMS: Mapping[str, tuple[Callable[[Host], object], str]] = {
    "nobody has allowed it": (lambda host: host.allow("off"), "nobody has allowed Improv to use it: "),
    "its key is not known": (lambda host: host.known.write_text(""), "its host key is not known here: "),
    "its key has changed": (change_key, "its host key has changed. "),
    "it takes no key": (lambda host: host.authorized.write_text(""), "it takes none of your ssh keys: "),
    "it has no Python": (lambda host: (host.bin / "python3").unlink(), "it has no `python3`: "),
    "its Python is old": (runs("sys.version_info = (3, 8, 10)"), "its Python is 3.8.10, "),
    "its shell greets without end": (lambda host: host.install("python3", "exec /usr/bin/yes Hi"), "it prints much "),
    "it answers garbage": (begins("'Welcome'"), "it sent something that isn't from a stage, "),
    "it sends a line without end": (begins("'m' * 20_000_000"), "it sends a line of more than 16 MB, "),
    "it closes in the middle": (ENDS, "the connection has ended"),
    "it has no ROS": (lambda host: None, "no Python there has rclpy: "),
}


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_problem_on_a_host_is_one_line_here(host: Host, problem: str) -> None:
    cause, line = PROBLEMS[problem]
    cause(host)
    check(host, line)
    assert len(host.versions()) == (problem == "it has no ROS")


def test_a_shell_that_greets_is_no_problem(host: Host) -> None:
    host.run_first("print('Welcome to Ubuntu!\\nToday is ', end='', flush=True)")
    check(host, "no Python there has rclpy: ")


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("off", "nothing listens for ssh there: "),
        ("nowhere", "no machine has that name: "),
    ],
)
def test_a_machine_that_is_not_there(host: Host, name: str, line: str) -> None:
    with host.config.open("a") as config:
        config.write("Host off\n  HostName 127.0.0.1\n  Port 1\nHost nowhere\n  HostName a..b\n")
    check(host, line, name)


@pytest.mark.parametrize("name", ["-oProxyCommand=touch ran", "robot;touch ran", "$(touch ran)", "robot touch", ""])
def test_a_name_that_is_none_reaches_neither_ssh_nor_a_shell(host: Host, name: str) -> None:
    """Not even if somebody has written it among the hosts that are allowed."""
    host.allow(name)
    check(host, f"`{name}` is not a host: write `name`, `user@name`, or `user@name:port`", name)
    assert not [*host.folder.rglob("ran")]


def test_the_host_is_no_option_and_does_not_change_the_command_there(
    monkeypatch: pytest.MonkeyPatch, host: Host
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", host.env["XDG_CONFIG_HOME"])
    host.allow("pi@anna:2222", NAME)
    command, other = ssh_command(checked("pi@anna:2222")), ssh_command(NAME)
    assert command[-3:-1] == ["--", "pi@anna"]
    assert command[-1] == other[-1]
    assert {"ForwardAgent=no", "ForwardX11=no", "ClearAllForwardings=yes", "PermitLocalCommand=no"} <= {*command}
    assert command[command.index("-p") + 1] == "2222"


@pytest.mark.parametrize("cut", [0, 1, 1000, -1])
def test_a_bundle_that_is_sent_half_leaves_nothing(tmp_path: Path, cut: int) -> None:
    carried = bundle()
    done = started_there(tmp_path, boot_line(carried, []) + carried.data[:cut])
    assert [json.loads(line.removeprefix(b"improv ")) for line in done.splitlines()[1:]] == [{"problem": "torn"}]
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_stage_that_is_there_already_is_not_sent_again(tmp_path: Path) -> None:
    first, again = (started_there(tmp_path, boot_line(bundle(), ["--look"]) + data) for data in (bundle().data, b""))
    assert b'"wants": true' in first
    assert b'"wants": false' in again
    assert again.splitlines()[-1] == first.splitlines()[-1]


def test_a_disk_that_takes_nothing_is_named(tmp_path: Path) -> None:
    (tmp_path / "improv").write_text("")
    done = started_there(tmp_path, boot_line(bundle(), []) + bundle().data)
    problem = json.loads(done.splitlines()[-1].removeprefix(b"improv "))
    assert (problem["problem"], problem["where"]) == ("disk", str(tmp_path / "improv" / "stages"))


def test_two_earlier_versions_are_kept_and_incomplete_ones_are_not(tmp_path: Path) -> None:
    stages = tmp_path / "improv" / "stages"
    for age, name in enumerate(["a" * 64, "b" * 64, "c" * 64, "d" * 64, "e" * 64 + ".999999999"]):
        (stages / name).mkdir(parents=True)
        os.utime(stages / name, (1_000_000 - age, 1_000_000 - age))
    started_there(tmp_path, boot_line(bundle(), ["--look"]) + bundle().data)
    assert {path.name for path in stages.iterdir()} == {"a" * 64, "b" * 64, bundle().digest}


def started_there(cache: Path, data: bytes) -> bytes:
    code = "exec(open(0, 'rb', 0, closefd=False).readline())"
    env = {**os.environ, "XDG_CACHE_HOME": str(cache), "IMPROV_ROS_PYTHON": ""}
    done = subprocess.run(
        [sys.executable, "-I", "-c", code], input=data, env=env, capture_output=True, timeout=LIMIT, check=False
    )
    assert done.stderr == b""
    return b"\n".join(line for line in done.stdout.splitlines() if line)
