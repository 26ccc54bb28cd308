"""The proof that an installed ROS 2 works: a Twist from a real stage reaches a listener in another process."""

from __future__ import annotations

import asyncio
import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from improv_core.ipc.child import Child, Policy
from improv_core.ipc.stage_process import Heard, RunningStage, Stage, StageError
from improv_core.outputs.ros.discovery import PEERS, RANGE, limited
from improv_core.outputs.ros.setup.environment import AGAIN, ELSEWHERE, Say, SetupError
from improv_core.protocol.limits import FOLDER
from improv_core.safety.stops import Stops

LIMIT = 60.0
"""Seconds that the Twist may take to arrive, including the start of everything it needs."""
LOOK_PERIOD = 0.02
"""Seconds between two reads of the listener's reports."""
POLICY = Policy(1.0)
DOMAIN = "101"
"""The last domain that doesn't collide with Linux's ephemeral ports: few robots use it."""


@dataclass(frozen=True, slots=True)
class Proof:
    """A score, as JSON, for one robot that doesn't exist, and its topic."""

    topic: str
    score: Mapping[str, Any]


def prove(python: Path, proof: Proof, say: Say) -> None:
    """Send a Twist from a real stage to a listener in another process. Raises SetupError."""
    env = limited({**os.environ, RANGE: "LOCALHOST", PEERS: "", "ROS_DOMAIN_ID": DOMAIN})
    try:
        seconds = asyncio.run(asyncio.wait_for(_sent_and_received(str(python), env, proof), LIMIT))
    except asyncio.TimeoutError:
        raise SetupError(
            "ROS 2 starts, but a Twist does not arrive: make the firewall allow UDP on this machine's own addresses, "
            f"then {AGAIN}"
        ) from None
    except (StageError, OSError) as error:
        raise SetupError(f"ROS 2 does not start ({error}): {AGAIN}, or {ELSEWHERE}") from None
    say(f"ROS 2 works: a Twist was sent and received in {seconds:.1f} s")


async def _sent_and_received(python: str, env: Mapping[str, str], proof: Proof) -> float:
    """Return the seconds from loading the score until its first Twist arrives, including discovery."""
    failed: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def hear(_: RunningStage, message: Heard, stops: int) -> None:
        if (message["type"] == "error" or message["type"] == "gone") and not failed.done():
            failed.set_exception(StageError(message["message"]))

    receiver = Child([python, str(FOLDER), "outputs.ros.graph", "twists", proof.topic], POLICY, env)
    try:
        await _next(receiver)
        sender = await Stage.start([python, str(FOLDER), "--sink", "ros"], env, hear, Stops())
        try:
            began = time.monotonic()
            sender.send(
                {"type": "load", "generation": 1, "score": proof.score, "when": "restart", "backend": "the proof"}
            )
            received = asyncio.create_task(_moves(receiver))
            await asyncio.wait([received, failed], return_when=asyncio.FIRST_COMPLETED)
            for each in (received, failed):
                if each.done():
                    each.result()
                each.cancel()
            return time.monotonic() - began
        finally:
            await sender.close()
    finally:
        receiver.kill()
        receiver.wait()


async def _moves(receiver: Child) -> None:
    """Wait until it has received a velocity."""
    while not any(any(json.loads(each)) for each in await _next(receiver)):
        pass


async def _next(receiver: Child) -> list[bytes]:
    try:
        while not (said := receiver.read(0.0)):  # noqa: ASYNC110 (no event tells of a pipe)
            await asyncio.sleep(LOOK_PERIOD)
    except EOFError:
        raise StageError("its listener ended") from None
    return said
