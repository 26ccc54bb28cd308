"""The state of a session: all that is known about its stages and the score that plays, as one value. Standard library
only."""

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
from improv_core.session.part_versions import PartVersions
from improv_core.session.start import SinkName

Change = Seek | Speed | Silence | Held | Released | Cue | KeySense | Force | OscSense
"""The changes that people can make to playback, apart from stopping, pausing, and resuming it."""
Kept = Change | ProgramMessage | ProgramSource
"""The messages that stages that start later need, too."""


@dataclass(frozen=True, slots=True)
class PlayScore:
    """A request to play a program's score, or a score that plays after one: then its `generation` counts scores.

    `when` is `restart`, or take over `now`, at the next `beat` or `bar`, or at the `end`: parts that are the same as in
    the score that plays are not touched then. `stops` is the count of stops at the request. With `senses`, robots sense
    what is in this recording, and nothing else. If `simulated`, only the simulator plays it, and real robots stop. With
    `anyway`, real robots may stand anywhere. With `arming`, it waits once everything is ready. Unless a person asks for
    it, `by` is the automation that does.
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
    """The stages, and what they play. Only `asked`, `heard`, and the code that starts and ends stages make the next
    one.

    `stages` are those that have started, by name, and `gone` are those of them that have died. One is the `leader`; all
    others follow from that. `played` is the score that Restart plays again, and `latest` is the same if stages may
    still need it: once one has died, they don't. `entered` is the first message about its playing, and `behind` the
    seconds by which the twin plays behind the leader. `waits_for` are the conditions that must change, according to the
    leader. `halting` is a new stage that only has to stop the robots of a dead one, and `still` is true once they
    stand. `idle_score` is the latest score of an idle stage's robots.
    """

    stages: Mapping[SinkName, Ready] = field(default_factory=dict)
    gone: frozenset[SinkName] = frozenset()
    leader: SinkName | None = None
    is_on: bool = False
    """True if something plays, or is about to."""
    played: PlayScore | None = None
    latest: PlayScore | None = None
    generation: int = 0
    editions: PartVersions = field(default_factory=PartVersions)
    entered: TransportMessage | None = None
    behind: float = 0.0
    waits_for: Sequence[str] = ()
    why_still: str = ""
    """The reason why real robots stand, for pages."""
    armed: bool = False
    """True if the leader waits for nothing but a person, or its time."""
    kept: Mapping[str, Kept] = field(default_factory=dict)
    halting: SinkName | None = None
    still: bool = True
    unobeyed: frozenset[str] = frozenset()
    """The marks of pages' stops that the stage of real robots has yet to obey."""
    idle_score: Score | None = None
    clock: OutsideClock | None = None
    """The clock of music that the session follows."""

    @property
    def twin(self) -> SinkName | None:
        """The simulator, alongside real robots."""
        others = (name for name in self.stages if name not in (self.leader, "page"))
        return next((name for name in others if not self.stages[name]["real"]), None)

    @property
    def onlooker(self) -> SinkName | None:
        """The stage whose page shows what the leading one reports: the twin, or a page without a simulator."""
        others = (name for name in self.stages if name != self.leader)
        return next((name for name in others if "page" in self.stages[name]), None)

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
        """True if real robots stand once their stage reports it: it isn't one that still stops those of a dead one."""
        return self.real is not None and self.real not in self.gone and self.still

    @property
    def is_open(self) -> bool:
        """True if all stages run that are needed to play."""
        return self.leader is not None and not self.gone

    @property
    def is_real(self) -> bool:
        """True if real robots play."""
        return self.leader is not None and self.stages[self.leader]["real"]

    @property
    def status(self) -> str:
        """The backend in words."""
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
        """Return it with a robot that stands because of a fault: the robot is muted until somebody unmutes it."""
        muted, soloed = self.silenced
        silence: Silence = {"type": "silence", "muted": sorted({*muted, robot}), "soloed": sorted(soloed)}
        return replace(self, kept={**self.kept, "silence": silence})

    def halts(self, name: SinkName) -> bool:
        """Return whether a new stage has to stop the robots of a dead one first."""
        return name in self.gone and name not in (self.twin, "page") and bool(self.editions.sent or self.idle_score)

    def leads(self, name: SinkName) -> bool:
        """Return whether this stage's reports count for all."""
        return name == self.leader and name not in self.gone

    def keeping(self, message: Kept) -> SessionState:
        return replace(self, kept={**self.kept, message["type"]: message})

    def opened(self, names: Iterable[SinkName]) -> SessionState:
        """Return it after all stages that could be started have been: the first one of these leads."""
        return replace(self, leader=next(name for name in names if name in self.stages))

    def closed(self) -> SessionState:
        """Return it after all stages have ended. People's settings stay."""
        return SessionState(played=self.played, generation=self.generation, editions=self.editions, kept=self.kept)
