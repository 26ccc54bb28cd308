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

MOST_SENT = 100
"""The most scores to compare with: of hundreds of saves during a long dance, only the last will play."""


class StageKey(NamedTuple):
    """A stage: its machine, and its output. Only real robots have stages on hosts, too."""

    host: str
    output: Output


@dataclass(frozen=True, slots=True)
class StageState:
    """A stage, by its reports.

    `ready` is its first message (None: it has yet to start), and `transport` its latest position. It is `armed` if it
    is ready for beat 0, and gets a message in time that is sent `lag` seconds ahead. `misplaced` are its robots that
    are not in their places. It `may_move` until it has confirmed a stop. If it `died_moving`, its robots may move until
    another one has stopped them; that one `only_halts` until it is sent a score to play. `obeyed` is the latest stop
    that it has obeyed and that had not come straight to it. `pressed` is its latest report about emergency stops, and
    `vitals` are the states of its robots.
    """

    ready: Ready | None = None
    alive: bool = True
    armed: bool = False
    transport: TransportMessage | None = None
    lag: float = 0.0
    misplaced: Mapping[str, MisplacedRobot] = field(default_factory=dict)
    may_move: bool = False
    died_moving: bool = False
    only_halts: bool = False
    obeyed: str = ""
    vitals: Mapping[str, Any] = field(default_factory=dict)
    pressed: Pressed = field(default_factory=lambda: Pressed(type="pressed", topics=[], count=0))


@dataclass(frozen=True, slots=True)
class PlayScore:
    """A request to play a program's score, or a score that plays after one: then its `generation` counts scores.

    `when` is `restart`, or take over `now`, at the next `beat` or `bar`, or at the `end`: parts that are the same as in
    the score that plays are not touched then. `stops` is the count of stops at the request. With `senses`, robots sense
    what is in this recording, and nothing else. If `simulated`, only the simulator plays it, and real robots stop. With
    `anyway`, real robots may stand anywhere. With `arming`, it waits once everything is ready. Unless a person asks for
    it, `by` is the automation that does. If it `joins`, all that dance keep dancing, except for the robots in it.
    `stopped` counts the stops before it that were no pauses.
    """

    score: Score
    name: str
    stops: int
    when: When = "restart"
    beats_per_bar: int = BEATS_PER_BAR
    senses: Sequence[Sensed] | None = None
    simulated: bool = False
    anyway: bool = False
    arming: Arming | None = None
    generation: int = 0
    by: Automation | None = None
    joins: bool = False
    stopped: int = 0


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
        if len(sent) > MOST_SENT:
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
    stages make the next one.

    The output of the stages whose reports count is the `leader`. `played` is the score that Restart plays again, and
    `latest` is the same if stages may still need it: once one has died, they don't. `on_robots` is the latest score
    that real robots were sent. `entered` is the first message about the playing of `latest`, and `behind` the seconds
    by which the twin plays behind the leader. `waits_for` are the conditions that must change, according to the
    leader. `clock` is the clock of music that the session listens to.

    If real robots have stages on several machines, these play as one in a `mode`. `paused_by` are the hosts whose
    stages have paused by themselves; the latest pause began with the one that `paused_first`. Those that are `joining`
    have yet to be sent the score of the others. Those that are `entering` have been sent that score, of this
    generation, and have yet to report that they play it. They play `since` a monotonic time: reports of a pause before
    that are old. From `drifts` on, in monotonic seconds, their clocks may have drifted apart. Once it `settles`, in
    monotonic seconds, the results of all requests to them are known. `unconfirmed_at` is the monotonic time at which a
    line names the stages that have not confirmed a stop. `presses` has, for each total count of presses, the count of
    each stage. `seen` are robots whose poses stages elsewhere have yet to get, from `passes_on` on, in monotonic
    seconds.

    Such stages don't follow a clock of music by themselves: all are `following` it together. `bent` is the latest bend
    that they were sent, and from `looks` on they may be sent another one. They begin or continue when it `enters`, in
    monotonic seconds, at the beat `enters_at`. If the clock `stands` during a pause, the pause ends when the clock runs
    again.
    """

    stages: Mapping[StageKey, StageState] = field(default_factory=dict)
    leader: Output | None = None
    is_on: bool = False
    """True if something plays, or is about to."""
    played: PlayScore | None = None
    latest: PlayScore | None = None
    on_robots: PlayScore = NOTHING
    generation: int = 0
    editions: PartEditions = field(default_factory=PartEditions)
    entered: TransportMessage | None = None
    behind: float = 0.0
    waits_for: Sequence[str] = ()
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

    mode: Mode = "stopped"
    paused_by: frozenset[str] = frozenset()
    paused_first: str | None = None
    since: float = -math.inf
    drifts: float = math.inf
    settles: float = -math.inf
    joining: frozenset[str] = frozenset()
    entering: Mapping[str, int] = field(default_factory=dict)
    unconfirmed_at: float = math.inf
    presses: Mapping[int, Mapping[str, int]] = field(default_factory=dict)
    seen: Mapping[str, SeenRobot] = field(default_factory=dict)
    passes_on: float = -math.inf

    following: Following | None = None
    bent: BendMessage | None = None
    looks: float = -math.inf
    enters: float = math.inf
    enters_at: float = 0.0
    stands: bool = False

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
