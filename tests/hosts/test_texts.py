"""Errors of ssh and of the other end of a link, as one line. Errors of a real server are in test_ssh.py."""

from __future__ import annotations

import pytest

from improv_core.hosts.texts import of_bootstrap, of_far, of_ssh, strange


@pytest.mark.parametrize(
    ("said", "line"),
    [
        (
            ["ssh: connect to host anna port 22: Connection timed out"],
            "it can't be reached: check that it is on, in your network",
        ),
        (
            ["ssh: connect to host anna port 22: No route to host"],
            "it can't be reached: check that it is on, in your network",
        ),
        (
            ["kex_exchange_identification: read: Connection reset by peer", "Connection reset by 10.0.0.7 port 22"],
            "it has closed the connection",
        ),
        (
            ["Welcome!", "pi@anna: Permission denied (publickey,password)."],
            "it takes none of your ssh keys: run `ssh-copy-id -p 2222 pi@anna`, and `ssh-add` for a key with a "
            "passphrase",
        ),
        (
            ["@ WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED! @", "Host key verification failed."],
            "its host key has changed. If you know why, run `ssh-keygen -R '[anna]:2222'`, then `ssh -p 2222 pi@anna`",
        ),
        (["Host key verification failed."], "its host key is not known here: run `ssh -p 2222 pi@anna` once"),
        (
            ["ssh: Could not resolve hostname anna"],
            "no machine has that name: check it, and that the machine is on",
        ),
        (
            ["connect to host anna: Connection refused"],
            "nothing listens for ssh there: start its ssh server (`sudo apt install openssh-server`)",
        ),
        (["sh: 1: python3: not found"], "it has no `python3`: install Python 3.10 or newer there"),
        (["what \x1b[31mnobody\u202e knows"], "ssh has ended: what \\x1b[31mnobody\\u202e knows"),
        ([], "the connection has ended"),
    ],
)
def test_errors_of_ssh_become_advice(said: list[str], line: str) -> None:
    assert of_ssh("pi@anna:2222", said) == line


@pytest.mark.parametrize(
    ("said", "line"),
    [
        ("no-ros", "no Python there has rclpy: run `improv ros setup --host anna`, or install ROS 2 there"),
        ("hung 0.9", "its stage did not answer for 0.9 s, so it was ended"),
        ("stage {host} {0}", "its stage failed: {host} {0}"),
        ("added later", "added later"),
        ("\x1b[2J{", "\\x1b[2J{"),
    ],
)
def test_a_message_of_the_far_end_is_one_printable_line(said: str, line: str) -> None:
    assert of_far("anna", said) == line


def test_a_disk_that_is_full_is_named() -> None:
    said = {"problem": "disk", "where": "/home/pi/.cache/improv/stages", "why": "No space left on device"}
    assert of_bootstrap(said) == "/home/pi/.cache/improv/stages can't be written there: no space left on device"
    assert (
        of_bootstrap({"problem": "old", "python": [3, 8]}) == "its Python is 3.8, and Improv needs 3.10 or newer there"
    )
    assert of_bootstrap({"problem": "old", "python": "x"}) == "its Python is old, and Improv needs 3.10 or newer there"


def test_a_host_that_prints_something_else_is_named_as_ssh_reaches_it() -> None:
    assert strange("pi@anna:2222", "it prints much") == (
        "it prints much, so the link has ended: check what `ssh pi@anna true` prints"
    )
