"""The state of a group: all that is known about stages on several machines that play as one. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Literal, cast

from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import AUTOMATIONS, Automation, Speed
from improv_core.protocol.limits import MOST_AHEAD, SILENCE_LIMIT
from improv_core.protocol.messages import (
    Arming,
    CountJson,
    Load,
    MisplacedRobot,
    Pressed,
    SeenRobot,
    ToStage,
    TransportMessage,
)
from improv_core.score.outside_clock import Following
from improv_core.score.takeover import Takeover
from improv_core.score.transport import BEATS_PER_BAR

HERE = ""
"""The host of this machine."""
SPARE = 0.03
"""Seconds by which a message that is sent ahead should arrive early."""

Mode = Literal["stopped", "gathering", "armed", "unplaced", "playing", "paused"]
"""`gathering` until all are ready for beat 0, `armed` while that waits for a person or a time, and `unplaced` if a
robot that is not in its place has prevented it."""


@dataclass(frozen=True, slots=True)
class Owner:
    """The host whose stage moves a robot, and the patience of that stage in seconds."""

    host: str = HERE
    patience: float = SILENCE_LIMIT


@dataclass(frozen=True, slots=True)
class Hosted:
    """A stage of the group. `transport` is its latest position. It is `armed` if it is ready for beat 0, and a message
    takes at most `lag` seconds to reach it. `misplaced` are its robots that are not in their places. It `may_move`
    until it has confirmed a stop. If it `died_moving`, its robots may move until another one has stopped them.
    `pressed` is its latest report about emergency stops, and `vitals` are the states of its robots."""

    alive: bool = True
    armed: bool = False
    transport: TransportMessage | None = None
    lag: float = 0.0
    misplaced: Mapping[str, MisplacedRobot] = field(default_factory=dict)
    may_move: bool = False
    died_moving: bool = False
    vitals: Mapping[str, Any] = field(default_factory=dict)
    pressed: Pressed = field(default_factory=lambda: Pressed(type="pressed", topics=[], count=0))


@dataclass(frozen=True, slots=True)
class GroupState:
    """The stages, by their hosts, and the score they play. Only `rules.py` makes the next one.

    `load` has the whole score, and `robots` the owner of each robot. While beat 0 waits for a person, it may also come
    by itself: `begins` is that time, in Unix time. `paused_by` are the stages that have paused by themselves; the
    latest pause began with the one that `paused_first`. Those that are `joining` have yet to be sent the score of the
    others. Those that are `entering` have been sent that score, of this generation, and have yet to report that they
    play it.
    They play `since` a monotonic time: reports of a pause before that are old. From `drifts` on, in monotonic seconds,
    their clocks may have drifted apart. Once it `settles`, in monotonic seconds, the results of all requests to them
    are known. `kept` holds for stages that start later.
    `unobeyed` are pages' stops, each with the hosts that have yet to obey it.
    `unconfirmed_at` is the monotonic time at which a line names the stages that have not confirmed a stop. `presses`
    has, for each total count of presses, the count of each stage. `seen` are robots whose poses stages elsewhere have
    yet to get, from `passes_on` on, in monotonic seconds.

    All follow a `clock` of music, which only the parent hears. `bent` is the latest bend that they were sent, and from
    `looks` on they may be sent another one. They begin or continue when it `enters`, in monotonic seconds, at the beat
    `enters_at`. A pause during which it `stands` ends when it continues.
    """

    members: Mapping[str, Hosted]
    mode: Mode = "stopped"
    load: Load | None = None
    robots: Mapping[str, Owner] = field(default_factory=dict)
    arming: Arming | None = None
    begins: float = math.inf
    anyway: bool = False
    paused_by: frozenset[str] = frozenset()
    since: float = -math.inf
    drifts: float = math.inf
    settles: float = -math.inf
    joining: frozenset[str] = frozenset()
    entering: Mapping[str, int] = field(default_factory=dict)
    kept: Mapping[str, ToStage] = field(default_factory=dict)
    unobeyed: Mapping[str, frozenset[str]] = field(default_factory=dict)
    unconfirmed_at: float = math.inf
    presses: Mapping[int, Mapping[str, int]] = field(default_factory=dict)
    paused_first: str | None = None
    seen: Mapping[str, SeenRobot] = field(default_factory=dict)
    passes_on: float = -math.inf
    clock: Following | None = None
    bent: BendMessage | None = None
    looks: float = -math.inf
    enters: float = math.inf
    enters_at: float = 0.0
    stands: bool = False

    @property
    def alive(self) -> list[str]:
        """The hosts whose stages are alive; this machine is the first one."""
        return sorted(host for host, member in self.members.items() if member.alive)

    def others(self, host: str) -> list[str]:
        """The hosts whose stages are alive, except this one."""
        return [each for each in self.alive if each != host]

    @property
    def lead(self) -> str | None:
        """The host whose stage's position counts for all: the first one that plays and moves robots."""
        with_robots = {owner.host for owner in self.robots.values()}
        return min(self.playing, key=lambda host: (host not in with_robots, host), default=None)

    @property
    def to_obey(self) -> frozenset[str]:
        """The hosts that a stop has to reach: also those whose robots may still move, since their stage has died."""
        return frozenset(host for host, member in self.members.items() if member.alive or member.died_moving)

    @property
    def playing(self) -> list[str]:
        """The hosts whose stages are alive and play along, if anything plays."""
        return [host for host in self.alive if host not in {*self.joining, *self.entering}]

    @property
    def position(self) -> TransportMessage | None:
        """The position of the lead."""
        lead = self.lead
        return self.members[lead].transport if lead is not None else None

    @property
    def generation(self) -> int:
        """The number of the score."""
        return self.load["generation"] if self.load else 0

    @property
    def ahead(self) -> float:
        """Seconds by which all must get a command early in order to obey it at the same instant."""
        lag = max((self.members[host].lag for host in self.alive), default=0.0)
        return min(lag + SPARE, MOST_AHEAD)

    @property
    def count(self) -> CountJson | None:
        """The count of each stage before beat 0, from when it is sent the time to begin."""
        if not self.load or not self.load["score"].get("count_in") or self.clock:
            return None
        return {"beats": self.bar, "period": 60 / float(self.tempo * self.speed)}

    @property
    def bar(self) -> int:
        """The beats of a bar."""
        return (self.load["score"]["bar"] or self.load.get("beats_per_bar", BEATS_PER_BAR)) if self.load else 0

    @property
    def tempo(self) -> Fraction:
        """The tempo of the program, in beats per minute."""
        return Fraction(self.load["score"]["tempo"]) if self.load else Fraction(0)

    @property
    def speed(self) -> Fraction:
        """The speed factor that a person has set."""
        return Fraction(str(cast(Speed, self.kept.get("speed", {"factor": 1.0}))["factor"]))

    @property
    def is_led(self) -> bool:
        """True if all follow a clock that runs."""
        return self.clock is not None and self.clock.rate > 0 and not self.clock.silent

    @property
    def opens(self) -> float:
        """The time at which all have to be sent their start when they begin by themselves, in Unix time: they may count
        beats until beat 0."""
        return self.begins - (self.count["beats"] * self.count["period"] if self.count else 0.0)

    @property
    def is_on(self) -> bool:
        """True if something plays, or is about to."""
        return self.mode != "stopped"

    def may_start(self, by: Automation | None) -> bool:
        """Return whether this automation, or a person (None), may have robots begin or continue, by the reports of all
        stages."""
        said = [self.members[host].transport for host in self.alive]
        return by is None or all(by in each.get("startable_by", AUTOMATIONS) for each in said if each)

    def repeats(self, host: str) -> bool:
        """Return whether a stage has paused because of robots that another one had found too near to each other
        before."""
        first = self.members.get(self.paused_first or HERE)
        one, other = first and first.transport, self.members[host].transport
        if self.mode != "paused" or self.paused_first in (None, host) or not one or not other:
            return False
        near = {*other.get("too_near", ())}
        return bool(near) and near <= {*one.get("too_near", ())}

    def is_apart(self, host: str) -> bool:
        """Return whether a stage has begun a scene at another beat than the lead."""
        one, other = self.position, self.members[host].transport
        if not one or not other or one["generation"] != other["generation"] or other["state"] != "playing":
            return False
        known, here = one.get("scene"), other.get("scene")
        if not known or not here:
            return False
        return known["index"] == here["index"] and known["begins"] != here["begins"]

    def without(self, host: str) -> GroupState:
        """Return it without this stage among those that join: the others don't wait for it."""
        left = {host}
        entering = {each: generation for each, generation in self.entering.items() if each != host}
        return replace(self, joining=self.joining - left, entering=entering, paused_by=self.paused_by - left)

    def stopped(self) -> GroupState:
        """Return it with nothing that plays or joins."""
        none: frozenset[str] = frozenset()
        return replace(self.without_entry(), mode="stopped", joining=none, entering={}, paused_by=none)

    def without_entry(self) -> GroupState:
        """Return it with nothing that begins or continues by the clock."""
        return replace(self, enters=math.inf, stands=False)

    def owns(self, host: str, robot: str) -> bool:
        """Return whether the stage of a host moves a robot."""
        return self.robots.get(robot, Owner()).host == host

    def of(self, host: str) -> list[str]:
        """Return the robots that the stage of a host moves."""
        return [robot for robot, owner in self.robots.items() if owner.host == host]

    def with_member(self, host: str, **changes: Any) -> GroupState:
        return replace(self, members={**self.members, host: replace(self.members[host], **changes)})

    def with_all(self, hosts: Iterable[str], **changes: Any) -> GroupState:
        """Return it with the same changes to the stages of several hosts."""
        group = self
        for host in hosts:
            group = group.with_member(host, **changes)
        return group

    def loading(self, load: Load) -> GroupState:
        """Return it with a score, which may build on the one before: an unchanged part is null in it."""
        score, before = load["score"], self.load["score"] if self.load else {"movements": [], "parts": {}}
        parts = {robot: part or before["parts"].get(robot) for robot, part in score["parts"].items()}
        movements = [*(before["movements"] if score["known"] else ()), *score["movements"]]
        whole: Load = {**load, "score": {**score, "known": 0, "movements": movements, "parts": parts}}
        whole.pop("by", None)  # a stage that joins later was stopped by nobody
        return replace(self, load=whole, robots={robot: _owner(part or {}) for robot, part in parts.items()})

    def load_for(self, host: str, load: Load) -> Load:
        """Return a score as the stage of a host gets it."""
        sent: Load = {**load, "here": host}
        if "stops" in load:
            sent["stops"] = self.presses.get(load["stops"], {}).get(host, 0)
        if host != HERE:
            patiences = [owner.patience for owner in self.robots.values() if owner.host == host]
            sent["patience"] = min(patiences, default=SILENCE_LIMIT)
        return sent

    def entry_at(self, at: float) -> Takeover | None:
        """Return the position of the others at a time, for a stage that joins them; None if they don't play this
        score."""
        position = self.position
        if position is None or position["state"] != "playing" or position["generation"] != self.generation:
            return None
        entry: Takeover = {"beat": beat_at(position, at), "monotonic": at}
        if "begins" in position:
            entry["begins"] = position["begins"]
        if "scene" in position:
            entry["scene"] = position["scene"]
        if "pace" in position:
            entry["pace"] = position["pace"]
        return entry


def beat_at(transport: TransportMessage, at: float) -> float:
    """Return the beat at a time, which may be before the latest report: that was sent ahead."""
    if transport["state"] != "playing":
        return transport["beat"]
    return max(transport["beat"] + (at - transport["monotonic"]) * transport["tempo"] / 60, 0.0)


def _owner(part: Mapping[str, Any]) -> Owner:
    host = part.get("host")
    return Owner(host["name"], host["patience"]) if host else Owner()
