"""The state of a session: all that is known about its stages and the score that plays, as one value. Standard library
only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import count
from typing import Any, Literal, NamedTuple

from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import (
    Automation,
    Cue,
    Force,
    Held,
    KeySense,
    OscSense,
    Released,
    Seek,
    Silence,
    Speed,
)
from improv_core.protocol.editing import ProgramSource
from improv_core.protocol.messages import (
    Arming,
    MisplacedRobot,
    Pressed,
    ProgramMessage,
    Ready,
    SeenRobot,
    Sensed,
    TransportMessage,
    When,
)
from improv_core.protocol.robot_messages import Resumes
from improv_core.score.equality import same
from improv_core.score.movement import Movement
from improv_core.score.outside_clock import Following
from improv_core.score.score import UNNUMBERED, OutsideClock, Part, Score
from improv_core.score.takeover import Takeover
from improv_core.score.transport import BEATS_PER_BAR

HERE = ""
"""The host of this machine."""
Output = Literal["simulator", "ros", "page"]
"""The outputs of stages. `page` only shows what the others play, and `ros` moves real robots."""
Change = Seek | Speed | Silence | Held | Released | Cue | KeySense | Force | OscSense
"""The changes that people can make to playback, apart from stopping, pausing, and resuming it."""
Kept = Change | ProgramMessage | ProgramSource
"""The messages that stages that start later need, too."""
Mode = Literal["stopped", "gathering", "armed", "unplaced", "playing", "paused"]
"""`gathering` until all are ready for beat 0, `armed` while that waits for a person or a time, and `unplaced` if a
robot that is not in its place has prevented it."""

MAX_SENT = 100
"""The most scores to compare with: of hundreds of saves during a long dance, only the last will play."""


class StageKey(NamedTuple):
    """A stage: its machine, and its output. Only real robots have stages on hosts, too."""

    host: str
    output: Output


@dataclass(frozen=True, slots=True)
class StageState:
    """A stage, by its reports."""

    ready: Ready | None = None
    """Its first message; None if it has yet to start."""
    alive: bool = True
    armed: bool = False
    """True if it is ready for beat 0."""
    transport: TransportMessage | None = None
    """Its latest position."""
    lag: float = 0.0
    """Seconds by which a message must be sent ahead to reach it in time."""
    misplaced: Mapping[str, MisplacedRobot] = field(default_factory=dict)
    """Its robots that are not in their places."""
    may_move: bool = False
    """True until it has confirmed a stop."""
    died_moving: bool = False
    """True if its robots may move until another stage has stopped them."""
    only_halts: bool = False
    """True if it only stops the robots of a dead stage, until it is sent a score to play."""
    obeyed: str = ""
    """The latest stop that it has obeyed and that had not come straight to it."""
    vitals: Mapping[str, Any] = field(default_factory=dict)
    """The states of its robots."""
    pressed: Pressed = field(default_factory=lambda: Pressed(type="pressed", topics=[], count=0))
    """Its latest report about emergency stops."""


@dataclass(frozen=True, slots=True)
class PlayScore:
    """A request to play a program's score, or a score that plays after one."""

    score: Score
    name: str
    stops: int
    """The count of stops at the request."""
    when: When = "restart"
    """`restart`, or take over `now`, at the next `beat` or `bar`, or at the `end`: then, parts that are the same as in
    the score that plays are not touched."""
    beats_per_bar: int = BEATS_PER_BAR
    senses: Sequence[Sensed] | None = None
    """A recording: robots sense what is in it, and nothing else."""
    simulated: bool = False
    """True if only the simulator plays it, and real robots stop."""
    anyway: bool = False
    """True if real robots may stand anywhere."""
    arming: Arming | None = None
    """The arming with which it waits once everything is ready."""
    generation: int = 0
    """The number of the score, once it plays."""
    by: Automation | None = None
    """The automation that asks for it, unless a person does."""
    joins: bool = False
    """True if all that dance keep dancing, except for the robots in it."""
    stopped: int = 0
    """The count of stops before it that were no pauses."""


NOTHING = PlayScore(Score(Fraction(1), {}), "", 0)
"""The score of robots that have been sent none."""


@dataclass(frozen=True, slots=True)
class PartEditions:
    """Numbers the parts of the scores that are sent, so that stages need not compare them: a part that a save doesn't
    change keeps its number. Scenes are compared one by one, so a scene keeps its number no matter which scenes come
    later.

    `latest` is the highest number. `sent` has the scores that may play when another takes over, by generation, oldest
    first: the last score that a stage reported to play, and all later ones.
    """

    latest: int = 0
    sent: Mapping[int, Score] = field(default_factory=dict)

    def number(self, score: Score, generation: int) -> tuple[PartEditions, Score]:
        """Return the next value, and the score with the editions of its parts; `generation` counts scores."""
        new = count(self.latest + 1)
        parts = {robot: replace(part, editions=self._editions(part, new)) for robot, part in score.parts.items()}
        score = replace(score, parts=parts)
        sent = {**self.sent, generation: score}
        if len(sent) > MAX_SENT:
            del sent[list(sent)[1]]  # the first one plays
        return PartEditions(next(new) - 1, sent), score

    def plays(self, generation: int) -> PartEditions:
        """Return the editions after a stage has reported that a score plays: scores before it no longer matter."""
        if next(iter(self.sent), generation) == generation or generation not in self.sent:
            return self
        return replace(self, sent={number: score for number, score in self.sent.items() if number >= generation})

    def _editions(self, part: Part, new: Iterator[int]) -> tuple[int, ...]:
        """Return a number for each scene: that of an earlier part if it moves the robot in the same way there."""
        earlier = [
            known
            for score in reversed([*self.sent.values()])
            if (known := score.parts.get(part.robot)) and known.profile == part.profile
        ]
        return tuple(
            next(_alike(scene, {known.edition(index): known.of_scene(index) for known in earlier}), None) or next(new)
            for index, scene in enumerate(part.scenes)
        )


def _alike(scene: Movement, known: Mapping[int, Movement]) -> Iterator[int]:
    numbered = ((edition, movement) for edition, movement in known.items() if edition != UNNUMBERED)
    return (edition for edition, movement in numbered if movement is scene or same(movement, scene))


@dataclass(frozen=True, slots=True)
class SessionState:
    """The stages, and what they play. Only `on_request`, `on_report`, `waited`, and the code that starts and ends
    stages make the next one. Times are monotonic, in seconds.

    Real robots may have stages on several machines, which play as one, in a `mode`. They don't follow a clock of music
    by themselves: all follow it together.
    """

    stages: Mapping[StageKey, StageState] = field(default_factory=dict)
    leader: Output | None = None
    """The output of the stages whose reports count."""
    is_on: bool = False
    """True if something plays, or is about to."""
    played: PlayScore | None = None
    """The score that Restart plays again."""
    latest: PlayScore | None = None
    """The score that was `played`, if stages may still need it: once one has died, they don't."""
    on_robots: PlayScore = NOTHING
    """The latest score that real robots were sent."""
    generation: int = 0
    editions: PartEditions = field(default_factory=PartEditions)
    entered: TransportMessage | None = None
    """The first message about the playing of `latest`."""
    behind: float = 0.0
    """Seconds by which the twin plays behind the leader."""
    waits_for: Sequence[str] = ()
    """The conditions that must change, according to the leader."""
    why_still: str = ""
    """The reason why real robots stand, for pages."""
    resumes: Resumes | None = None
    """The beats from which people may have real robots continue, after a stop that nobody asked for."""
    stood: Takeover | None = None
    """The place in the score where the leading stage died, until another stage has robots resume from there."""
    pending: PlayScore | None = None
    """The score that somebody asked for before that stage was replaced."""
    kept: Mapping[str, Kept] = field(default_factory=dict)
    clock: OutsideClock | None = None
    """The clock of music that the session listens to."""

    mode: Mode = "stopped"
    paused_by: frozenset[str] = frozenset()
    """The hosts whose stages have paused by themselves."""
    paused_first: str | None = None
    """The host with which the latest pause began."""
    since: float = -math.inf
    """The time since which all play: reports of a pause before that are old."""
    drifts: float = math.inf
    """The time from which on their clocks may have drifted apart."""
    settles: float = -math.inf
    """The time from which on the results of all requests to them are known."""
    joining: frozenset[str] = frozenset()
    """The hosts whose stages have yet to be sent the score of the others."""
    entering: Mapping[str, int] = field(default_factory=dict)
    """The hosts whose stages have been sent that score, with its generation, and have yet to report that they play."""
    unconfirmed_at: float = math.inf
    """The time at which a line names the stages that have not confirmed a stop."""
    presses: Mapping[int, Mapping[str, int]] = field(default_factory=dict)
    """For each total count of presses, the count of each stage."""
    seen: Mapping[str, SeenRobot] = field(default_factory=dict)
    """Robots whose poses stages elsewhere have yet to get."""
    passes_on: float = -math.inf
    """The time from which on these poses are sent."""

    following: Following | None = None
    """The clock of music that they follow together."""
    bent: BendMessage | None = None
    """The latest bend that they were sent."""
    looks: float = -math.inf
    """The time from which on they may be sent another bend."""
    enters: float = math.inf
    """The time at which they begin or continue, at the beat `enters_at`."""
    enters_at: float = 0.0
    stands: bool = False
    """True if the clock stands during a pause, which ends when the clock runs again."""

    @property
    def twin(self) -> Output | None:
        """The simulator, alongside real robots."""
        return "simulator" if self.leader != "simulator" and StageKey(HERE, "simulator") in self.stages else None

    @property
    def onlooker(self) -> StageKey | None:
        """The stage whose page shows what the leading one reports: the twin, or a page without a simulator."""
        return next((key for key in self.pages if key.output != self.leader), None)

    @property
    def idle(self) -> Output | None:
        """The output to real robots, while the simulator plays alone."""
        return self.real if self.leader != "ros" else None

    @property
    def real(self) -> Output | None:
        """The output to real robots."""
        return "ros" if any(stage.ready for stage in self.robots.values()) else None

    @property
    def robots(self) -> dict[str, StageState]:
        return {key.host: stage for key, stage in self.stages.items() if key.output == "ros"}

    @property
    def alive(self) -> list[str]:
        """The hosts whose stages of real robots are alive; this machine is the first one."""
        return sorted(host for host, stage in self.robots.items() if stage.alive)

    @property
    def is_spread(self) -> bool:
        """True if real robots have stages on several machines."""
        return any(key.host != HERE for key in self.stages)

    @property
    def pages(self) -> list[StageKey]:
        return [key for key, stage in self.stages.items() if stage.ready and "page" in stage.ready]

    @property
    def still(self) -> bool:
        """True unless a new stage has yet to stop the robots of a dead one."""
        return not any(stage.alive and stage.died_moving for stage in self.stages.values())

    @property
    def obeys(self) -> bool:
        """True if reports that real robots stand can be trusted: no stage still stops those of a dead one."""
        return bool(self.alive) and self.still

    @property
    def is_open(self) -> bool:
        """True if all stages run that are needed to play."""
        return self.leader is not None and not any(self.is_gone(key.output) for key in self.stages)

    @property
    def is_real(self) -> bool:
        return self.leader == "ros"

    @property
    def armed(self) -> bool:
        """True if the leader waits for nothing but a person, or its time."""
        if self.is_real and self.mode in ("gathering", "armed"):
            return self.mode == "armed"
        return any(stage.armed for key, stage in self.stages.items() if key.output == self.leader)

    @property
    def status(self) -> str:
        """The backend in words."""
        ready = [(key.host, stage.ready) for key, stage in self.stages.items() if key.output == self.leader]
        about = "; ".join(f"{each['sink']} on {host}" if host else each["sink"] for host, each in ready if each)
        return f"{about}, with the simulator alongside" if self.leader and self.twin else about or "nothing"

    @property
    def page(self) -> str | None:
        """The address of the simulator's page."""
        return next((ready["page"] for key in self.pages if (ready := self.stages[key].ready)), None)

    @property
    def silenced(self) -> tuple[frozenset[str], frozenset[str]]:
        """The muted robots, and the soloed ones."""
        silence = self.kept.get("silence")
        if not silence or silence["type"] != "silence":
            return frozenset(), frozenset()
        return frozenset(silence["muted"]), frozenset(silence["soloed"])

    def with_muted(self, robot: str) -> SessionState:
        """Return the state with a robot muted that stands because of a fault, until somebody unmutes it."""
        muted, soloed = self.silenced
        silence: Silence = {"type": "silence", "muted": sorted({*muted, robot}), "soloed": sorted(soloed)}
        return self.keeping(silence)

    def is_gone(self, output: Output) -> bool:
        """Return whether no stage of an output is alive."""
        return not any(stage.alive for key, stage in self.stages.items() if key.output == output)

    def leads(self, output: Output) -> bool:
        """Return whether the reports of an output's stages count for all."""
        return output == self.leader and not self.is_gone(output)

    def keeping(self, message: Kept) -> SessionState:
        return replace(self, kept={**self.kept, message["type"]: message})

    def opening(self, hosts: Mapping[str, float]) -> SessionState:
        """Return the state before the stages start. The `lag` of each of `hosts` counts until its link is measured."""
        stages = {StageKey(host, "ros"): StageState(alive=False, lag=lag) for host, lag in hosts.items()}
        return replace(self, stages={**self.stages, **stages})

    def opened(self, outputs: Iterable[Output]) -> SessionState:
        """Return the state after all possible stages have started: the first of these outputs with a stage leads."""
        return replace(self, leader=next(output for output in outputs if not self.is_gone(output)))

    def closed(self) -> SessionState:
        """Return the state after all stages have ended. People's settings stay."""
        return SessionState(played=self.played, generation=self.generation, editions=self.editions, kept=self.kept)

    def with_stage(self, key: StageKey, **changes: Any) -> SessionState:
        return replace(self, stages={**self.stages, key: replace(self.stages[key], **changes)})
