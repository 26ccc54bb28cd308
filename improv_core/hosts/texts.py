"""Turns the output of ssh and of the far end of a link into one line with advice. The caller names the host."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from improv_core.plain import message as in_plain_text
from improv_core.safety.allowed import split

_OF_SSH = (
    ("HOST IDENTIFICATION HAS CHANGED", "its host key has changed. If you know why, run `{forget}`, then `{connect}`"),
    ("host key is known for|Host key verification failed", "its host key is not known here: run `{connect}` once"),
    (
        "Permission denied",
        "it takes none of your ssh keys: run `ssh-copy-id {to}`, and `ssh-add` for a key with a passphrase",
    ),
    ("Could not resolve hostname", "no machine has that name: check it, and that the machine is on"),
    ("Connection refused", "nothing listens for ssh there: start its ssh server (`sudo apt install openssh-server`)"),
    ("timed out|No route to host|Network is unreachable", "it can't be reached: check that it is on, in your network"),
    ("python3: (command )?not found|python3.*No such file", "it has no `python3`: install Python 3.10 or newer there"),
    ("Connection closed|Connection reset|Broken pipe|closed by remote host", "it has closed the connection"),
)
"""The meanings of ssh's own words. These are the words of OpenSSH, which are not translated."""


def of_ssh(host: str, said: Sequence[str]) -> str:
    """Return the reason why ssh has ended, from its standard error."""
    name, port = split(host)
    at = ["-p", port] if port else []
    known = f"[{name.rpartition('@')[2]}]:{port}" if port else name.rpartition("@")[2]
    advice = {
        "connect": " ".join(["ssh", *at, name]),
        "to": " ".join([*at, name]),
        "forget": f"ssh-keygen -R '{known}'" if port else f"ssh-keygen -R {known}",
    }
    for words, meaning in _OF_SSH:
        if any(re.search(words, line) for line in said):
            return in_plain_text(meaning.format(**advice))
    last = next((line for line in reversed(said) if line), "")
    return in_plain_text(f"ssh has ended: {last}" if last else "the connection has ended")


def of_bootstrap(said: Mapping[str, object]) -> str:
    """Return the reason why there is no far end, from the output of the bootstrap."""
    if said["problem"] == "old":
        version = ".".join(map(str, python)) if isinstance(python := said.get("python"), list) else "old"
        return in_plain_text(f"its Python is {version}, and Improv needs 3.10 or newer there")
    if said["problem"] == "disk":
        return in_plain_text(f"{said.get('where')} can't be written there: {str(said.get('why')).lower()}")
    return in_plain_text("what was sent has not arrived as it is: try again")


_OF_FAR = {
    "no-ros": "no Python there has rclpy: run `improv ros setup --host {host}`, or install ROS 2 there",
    "python": "{rest}",
    "taken": "{rest} plays on it, so you can't: ask them to stop. If that was you and the link was lost, it is free "
    "again after 20 s",
    "setup": "{rest}",
    "hung": "its stage did not answer for {rest} s, so it was ended",
    "stage": "its stage failed: {rest}",
    "ended": "its end of the link has ended: {rest}",
}


def of_far(host: str, said: str) -> str:
    """Return the reason why the far end ends, from its message: a word, and details."""
    word, _, rest = said.partition(" ")
    return in_plain_text(_OF_FAR[word].format(host=host, rest=rest) if word in _OF_FAR else said)


def silent(seconds: float) -> str:
    """Return the line about a link that is given up, since nothing has come from it for so long."""
    line = "its stage stops its robots by itself, but nobody has confirmed that: look at them"
    return in_plain_text(f"the link has been silent for {seconds:g} s: {line}")


def quiet(seconds: float, patience: float) -> str:
    """Return the line about robots that dance on without us: nothing has come from there for so long."""
    line = f"its robots may still be moving, and stop once it has heard nothing from here for {patience:g} s"
    return in_plain_text(f"nothing has come from it for {seconds:g} s: {line}")


def late(seconds: float) -> str:
    """Return the line about a host on which nothing of ours has begun for so long."""
    return in_plain_text(f"it did not answer within {seconds:g} s: check that it isn't too busy, then try again")


def too_long(most: int) -> str:
    """Return the line about a program that is too long to be sent."""
    return in_plain_text(f"a program of more than {most // 1_000_000} MB can't be sent")


def strange(host: str, why: str) -> str:
    """Return the line about a host that doesn't follow our protocol."""
    return in_plain_text(f"{why}, so the link has ended: check what `ssh {split(host)[0]} true` prints")
