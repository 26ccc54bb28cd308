"""A playback whose stages are fakes that tests control."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Mapping
from inspect import signature
from typing import Any

from improv_core.ipc.stage_process import HearStage, StageError
from improv_core.music.clock_process import HeardClock
from improv_core.protocol.commands import Editing
from improv_core.protocol.messages import FromStage, Load, Ready, State, ToStage
from improv_core.safety.stops import Stops
from improv_core.score.score import OutsideClock
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import Output, PlayScore
from tests.session.story import DANCE, at

LIMIT = 60.0


class Fake:
    def __init__(self, sink: Output, options: Options, hear: HearStage, stops: Stops) -> None:
        self._hear = hear
        self._stops = stops
        self.name = options.host.name if options.host else sink
        self.alive = True
        self.sent: list[ToStage] = []
        self.moves = False
        self.hangs = False  # so it doesn't stop its robots when it is to end
        self.ready: Ready = {"type": "ready", "protocol": 3, "sink": sink, "real": sink == "ros"}
        if sink == "simulator":
            self.ready["page"] = f"http://127.0.0.1:{options.port or 8123}/"

    def send(self, message: ToStage) -> None:
        self.sent.append(message)

    def moving(self, robots: Iterable[str]) -> list[str]:
        return [*robots] if self.moves else []

    async def close(self) -> None:
        self.alive = False
        self.moves = self.moves and self.hangs

    def say(self, message: FromStage) -> None:
        self.hear(message, self._stops.arrive(message["command"]) if message["type"] == "request" else 0)

    def hear(self, message: FromStage, asked: int) -> None:
        if message["type"] == "transport":
            self.moves = message["state"] == "playing"
        self._hear(self, message, asked)

    def die(self) -> None:
        self.alive = False
        self._hear(self, {"type": "gone", "message": "the stage exited unexpectedly"}, 0)

    def tell(
        self, state: State, beat: float = 0.0, monotonic: float = 500.0, begins: Mapping[str, float] | None = None
    ) -> None:
        known = {"restarted": 1, "begins": begins} if begins else {}
        self.say(at(state, self.loads[-1]["generation"], beat, monotonic, **known))

    @property
    def loads(self) -> list[Load]:
        return [message for message in self.sent if message["type"] == "load"]

    @property
    def kinds(self) -> list[str]:
        return [message["type"] for message in self.sent]


class FakeClock:
    def __init__(self, clock: OutsideClock, tempo: float, hear: Callable[[HeardClock], None]) -> None:
        self.clock, self.tempo, self.say = clock, tempo, hear
        self.alive = True

    def close(self) -> None:
        self.alive = False


class Fakes:
    """A playback on ROS 2 and the simulator, both faked, and the messages to its listener."""

    def __init__(self) -> None:
        self.stages: list[Fake] = []
        self.news: list[News] = []
        self.edits: list[tuple[Editing, int]] = []
        self.clocks: list[FakeClock] = []
        self.fails: set[str] = set()  # these hosts and outputs
        self.failed = 0
        self.problem = "no {} here"
        self.held: set[str] = set()  # these stages only start
        self.released = asyncio.Event()  # once this is set
        self.stops = Stops()
        self.playback = Playback(
            Options("both"),
            lambda message, leads: self.news.append(message),
            self.stops,
            self._start,
            listen_to=self._listen_to,  # type: ignore[arg-type]
        )

    def edit(self, editing: Editing, asked: int) -> None:
        self.edits.append((editing, asked))

    def _listen_to(self, clock: OutsideClock, tempo: float, hear: Callable[[HeardClock], None]) -> FakeClock:
        self.clocks.append(FakeClock(clock, tempo, hear))
        return self.clocks[-1]

    async def _start(self, sink: Output, options: Options, token: str, hear: HearStage, stops: Stops) -> Fake:
        name = options.host.name if options.host else sink
        if name in self.held:
            await self.released.wait()
        if name in self.fails:
            self.failed += 1
            raise StageError(self.problem.format(name))
        self.stages.append(Fake(sink, options, hear, stops))
        return self.stages[-1]

    async def until(self, fits: Callable[[], Any]) -> None:
        async def look() -> None:
            while not fits():  # noqa: ASYNC110
                await asyncio.sleep(0)

        await asyncio.wait_for(look(), LIMIT)

    def latest(self, name: str) -> Fake:
        return next(stage for stage in reversed(self.stages) if stage.name == name)

    async def begin(self) -> int | None:
        return await self.playback.play(PlayScore(DANCE, "dance.improv", self.stops.count))

    async def play(self) -> tuple[Fake, Fake]:
        """Begin. Returns the leading stage, and its twin, which play."""
        assert await self.begin()
        leader, twin = self.latest("ros"), self.latest("simulator")
        leader.tell("playing")
        return leader, twin

    @property
    def lines(self) -> list[str]:
        return [each["message"] for each in self.news if each["type"] in ("warning", "error", "gone")]


def performed(test: Callable[..., Awaitable[None]]) -> Callable[..., None]:
    async def perform(**given: Any) -> None:
        fakes = Fakes()
        try:
            await test(fakes, **given)
        finally:
            await fakes.playback.close()
            assert not any(stage.alive for stage in fakes.stages)

    def run(**given: Any) -> None:
        asyncio.run(perform(**given))

    asked = signature(test)
    others = [parameter for name, parameter in asked.parameters.items() if name != "fakes"]
    run.__name__, run.__doc__ = test.__name__, test.__doc__
    run.__signature__ = asked.replace(parameters=others)  # type: ignore[attr-defined]
    return run
