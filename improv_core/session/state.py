"""All that is known about what plays and about the stages that play it, as one value. Standard library only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

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
from improv_core.protocol.messages import Arming, ProgramMessage, Ready, Sensed, TransportMessage, When
from improv_core.score.score import OutsideClock, Score
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.session.part_versions import Editions
from improv_core.session.start import SinkName

Change = Seek | Speed | Silence | Held | Released | Cue | KeySense | Force | OscSense
"""What people can do to what plays, apart from stopping, pausing, and resuming it."""
Kept = Change | ProgramMessage | ProgramSource
"""What stages that start later are told, too."""


@dataclass(frozen=True, slots=True)
class PlayScore:
    """Somebody asks to have a program's score played, or it is played for that: then its `generation` counts scores.

    `restart`, or take over `now`, at the next `beat` or `bar`, or at the `end`: parts that are the same as in the score
    that plays are not touched then. `stops` is the count of stops when somebody asked for it. With `senses`, robots
    sense what is in this recording, and nothing else. If `simulated`, only the simulator plays it, and real robots
    stop. With `anyway`, it doesn't matter where real robots stand. With `arming`, it waits once everything is ready.
    Unless a person asks for it, `by` is what does.
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


@dataclass(frozen=True, slots=True)
class SessionState:
    """What plays, and on what. Only `asked` and `heard` make the next one, and whoever starts and ends stages.

    `stages` are those that have started, by name, and `gone` are those of them that have died. One is the `leader`; all
    others follow from that. `played` is what Restart plays again, and `latest` is the same if stages may still need it:
    once one has died, they don't. `entered` is the first message of its playing, and `behind` how many seconds the
    twin plays behind the leader. `waits_for` is what has to change, according to the leader.

    `halting` is a new stage that only has to stop the robots of a dead one, and `still` tells whether they stand.
    `idle_score` is what the robots of an idle stage played last.
    """

    stages: Mapping[SinkName, Ready] = field(default_factory=dict)
    gone: frozenset[SinkName] = frozenset()
    leader: SinkName | None = None
    is_on: bool = False
    """Whether something plays, or is about to."""
    played: PlayScore | None = None
    latest: PlayScore | None = None
    generation: int = 0
    editions: Editions = field(default_factory=Editions)
    entered: TransportMessage | None = None
    behind: float = 0.0
    waits_for: Sequence[str] = ()
    why_still: str = ""
    """What pages say about why real robots stand."""
    armed: bool = False
    """Whether the leader waits for nothing but a person, or its time."""
    kept: Mapping[str, Kept] = field(default_factory=dict)
    halting: SinkName | None = None
    still: bool = True
    unobeyed: frozenset[str] = frozenset()
    """The marks of pages' stops that the stage of real robots has yet to obey."""
    idle_score: Score | None = None
    clock: OutsideClock | None = None
    """The clock of music that is listened to."""

    @property
    def twin(self) -> SinkName | None:
        """The simulator, alongside real robots."""
        return next((name for name, ready in self.stages.items() if name != self.leader and not ready["real"]), None)

    @property
    def idle(self) -> SinkName | None:
        """The stage of real robots, while the simulator plays alone."""
        return next((name for name, ready in self.stages.items() if name != self.leader and ready["real"]), None)

    @property
    def real(self) -> SinkName | None:
        """The stage of real robots."""
        return next((name for name, ready in self.stages.items() if ready["real"]), None)

    @property
    def obeys(self) -> bool:
        """Whether real robots stand once their stage says so: it isn't one that still stops those of a dead one."""
        return self.real is not None and self.real not in self.gone and self.still

    @property
    def is_open(self) -> bool:
        """Whether all stages run that are needed to play."""
        return self.leader is not None and not self.gone

    @property
    def is_real(self) -> bool:
        """Whether real robots play."""
        return self.leader is not None and self.stages[self.leader]["real"]

    @property
    def status(self) -> str:
        """What it plays on, in words."""
        about = self.stages[self.leader]["sink"] if self.leader else "nothing"
        return f"{about}, with the simulator alongside" if self.leader and self.twin else about

    @property
    def page(self) -> str | None:
        """The address of the simulator's page."""
        return next((ready["page"] for ready in self.stages.values() if "page" in ready), None)

    @property
    def silenced(self) -> tuple[frozenset[str], frozenset[str]]:
        """The muted robots, and the soloed ones."""
        silence = self.kept.get("silence")
        if not silence or silence["type"] != "silence":
            return frozenset(), frozenset()
        return frozenset(silence["muted"]), frozenset(silence["soloed"])

    def with_muted(self, robot: str) -> SessionState:
        """With a robot that stands because of a fault: it is muted until somebody unmutes it."""
        muted, soloed = self.silenced
        silence: Silence = {"type": "silence", "muted": sorted({*muted, robot}), "soloed": sorted(soloed)}
        return replace(self, kept={**self.kept, "silence": silence})

    def leads(self, name: SinkName) -> bool:
        """Whether what this stage says counts for all."""
        return name == self.leader and name not in self.gone

    def keeping(self, message: Kept) -> SessionState:
        return replace(self, kept={**self.kept, message["type"]: message})

    def opened(self, names: Iterable[SinkName]) -> SessionState:
        """All stages that could be started have been: the first one of these leads."""
        return replace(self, leader=next(name for name in names if name in self.stages))

    def closed(self) -> SessionState:
        """All stages have ended. What is known about people's wishes stays."""
        return SessionState(played=self.played, generation=self.generation, editions=self.editions, kept=self.kept)
