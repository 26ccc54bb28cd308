"""Sets up ROS 2 on another machine, through the same connection that a stage there has."""

from __future__ import annotations

import json
from collections.abc import Callable

from improv_core.hosts.connect import connect
from improv_core.outputs.ros.setup.proof import Proof
from improv_core.plain import message as in_plain_text

DONE = b"done"
"""The last frame if all went well."""


def set_up_there(host: str, proof: Proof, say: Callable[[str], object], config: str | None = None) -> None:
    """Set up ROS 2 there, and `say` its lines. Raises ConnectError. The end of our process ends it there.

    `config` is of ssh, for tests.
    """
    connection = connect(host, ["--set-up", json.dumps([proof.topic, proof.score])], config)
    try:
        while True:
            for frame in connection.hear():
                if frame.letter == "t":
                    say(in_plain_text(frame.rest.decode(errors="replace")))
                elif frame.letter == "i" and frame.rest == DONE:
                    return
    finally:
        connection.ssh.end()
