"""Waits for the stages of hosts to start: for a limited time, and then again and again in the background. Standard
library only."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from itertools import chain, repeat

from improv_core.ipc.stage_process import StageError
from improv_core.session.state import HERE, StageKey

PAUSES = (1.0, 2.0, 4.0, 8.0, 15.0)
"""Seconds before each attempt to reach a host again; the last one repeats."""
SLOW = 5.0
"""Seconds after which a line names the hosts that have not answered."""
LATEST = 15.0
"""Seconds after which the others begin without a host that has not answered: its stage joins them once it does."""

Say = Callable[[str], None]
"""Prints a warning."""


async def wait_for_stages(
    starting: Mapping[StageKey, asyncio.Task[bool]], any_robots: Callable[[], bool], say: Say
) -> list[StageKey]:
    """Wait until all stages have started or failed, for a limited time for those on hosts. Returns those of hosts that
    have to be tried again. Raises StageError if one here has failed, or if there are hosts and no stage has robots."""
    here = [each for key, each in starting.items() if key.host == HERE]
    robots = {key: each for key, each in starting.items() if key.output == "ros"}
    away = {key: each for key, each in starting.items() if key.host != HERE}

    def late() -> list[str]:
        return [key.host for key, each in away.items() if not each.done()]

    if away:
        await asyncio.wait(robots.values(), timeout=SLOW)
    if late():
        say(f"{', '.join(late())} has not answered for {SLOW:g} s: the others wait for up to {LATEST:g} s")
        await asyncio.wait(robots.values(), timeout=LATEST - SLOW)
    await asyncio.wait(here)  # wait for all even if one fails, so that no stage is left running unnoticed
    while late() and not any_robots():
        await asyncio.wait([each for each in away.values() if not each.done()], return_when=asyncio.FIRST_COMPLETED)
    if late():
        say(f"{', '.join(late())} has not answered for {LATEST:g} s: the others begin, and it joins them")
    failed = [key for key, each in away.items() if each.done() and each.exception()]
    for each in (*here, *(away[key] for key in failed if not any_robots())):
        each.result()
    if away and not any_robots():
        raise StageError("no stage could be started")
    return [key for key, each in away.items() if key in failed or not each.done()]


async def keep_reaching(
    host: str, start: Callable[[], Awaitable[bool]], say: Say, first: Awaitable[bool] | None = None
) -> None:
    """Try to start the stage of a host until it works, after a `first` attempt, if there is one. The same reason for
    several failures is reported once."""
    told = ""
    for pause in chain(PAUSES, repeat(PAUSES[-1])):
        if first is None:
            await asyncio.sleep(pause)
        try:
            await (first or start())
        except StageError as error:
            if str(error) != told:
                told = str(error)
                say(f"{host or 'the stage here'} can't be reached: {told} (Improv keeps trying)")
            first = None
        else:
            return
