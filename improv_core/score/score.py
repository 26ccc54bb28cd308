"""A score: a part for each robot, and the tempo. The stage plays it. Standard library only."""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import repeat, zip_longest
from typing import Literal

from improv_core.score.algebra import series, stand
from improv_core.score.faults import FaultRules
from improv_core.score.installed import Value
from improv_core.score.measured import DEGREE, Component, in_si
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement, Velocity
from improv_core.score.music import Music
from improv_core.score.osc import Osc
from improv_core.score.profiles import Profile
from improv_core.score.senses import Senses
from improv_core.score.world import EMPTY, World

NOTHING = series(())


BASE_FRAME = "base_link"
"""The frame of a robot's velocities by default, as in REP 105."""
OdomFrame = Literal["own", "world"]
"""The frame that poses are in: one of the source's own, or the world of the score, which all robots share."""
LINK_PATIENCE = 0.5
"""Seconds without a message from us after which a stage on another machine stops its robots, by default."""
UNNUMBERED = 0
"""The edition of a part that has not been compared with others."""


_HOST = re.compile(r"(?:[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}@)?[A-Za-z0-9_][A-Za-z0-9_.-]{0,252}(?::([0-9]{1,5}))?")


def is_host(name: str) -> bool:
    """Return whether a machine's name has the form `machine`, `user@machine`, or `user@machine:port`.

    Nothing else reaches ssh: no option, and no character that any shell would understand.
    """
    form = _HOST.fullmatch(name)
    return form is not None and (form[1] is None or 0 < int(form[1]) < 65_536)


_ADDRESS = re.compile(r"(?:serial|tcp|udp|usb|ble):[A-Za-z0-9_./:@-]{1,200}")


def is_address(text: str) -> bool:
    """Return whether a text has the form of a robot's address, such as `serial:/dev/ttyACM0` or `tcp:localhost:33333`.
    No host that ssh may be given has it."""
    return _ADDRESS.fullmatch(text) is not None and not is_host(text)


@dataclass(frozen=True, slots=True)
class DeviceAddress:
    """The place where an output finds a robot: the address that a person has to allow, and its number there, if several
    robots share that. `settings` are those of the output."""

    address: str
    node: int | None = None
    settings: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Host:
    """The place of a stage that moves some robots: another machine, or an `output` on this one.

    A machine has its name for ssh, and ROS's domain and middleware there (None: as they are set there); an output has
    its own name. After `patience` seconds without a message from us, that stage stops its robots.
    """

    name: str
    domain: int | None = None
    rmw: str | None = None
    patience: float = LINK_PATIENCE
    output: bool = False


@dataclass(frozen=True, slots=True)
class Part:
    """One robot's part. By itself, it performs as if the robot were alone: the beats at which scenes begin depend on
    all robots, so the `Score` sets them."""

    robot: str
    scenes: tuple[Movement, ...]
    """A movement for each scene, empty if the robot has nothing to do in it."""
    profile: Profile
    start: Pose
    topic: str
    reset: str | None = None
    """The service that moves the robot to its start pose."""
    use_sim_time: bool = False
    """True if its messages are stamped with the time on /clock."""
    odom: str | None = None
    """The topic of its poses."""
    senses: Senses = field(default_factory=dict)
    """The senses that its movements read."""
    editions: tuple[int, ...] = ()
    """A number for each scene: two parts of a robot with the same number move it alike."""
    begins: Exact = 0
    """The beat of the performance at which the part began, with `scene`."""
    entered: Pose | None = None
    """The robot's ideal pose then, unless that is the beginning of all."""
    scene: int = 0
    scene_begins: tuple[Exact, ...] = field(default=(), compare=False)
    frame: str = BASE_FRAME
    """The frame of its velocities."""
    follow: bool = False
    """True if its measured poses pull it back to its ideal path."""
    odom_frame: OdomFrame = "own"
    battery: str | None = None
    """The topic of its battery's charge."""
    namespace: str = ""
    """The namespace of the robot's own topics."""
    host: Host | None = None
    """The machine or output whose stage moves it; None stands for ROS 2 here."""
    device: DeviceAddress | None = None
    """The place where the output of its `host` finds it."""
    elsewhere: bool = False
    """True if another stage than the one that plays it moves the robot. It then has no `odom`, and the other stage
    reports its pose if its poses are in the world."""
    movement: Movement = field(init=False, compare=False)
    """All that it performs from `begins` on. In between, it stands until each scene begins."""

    def __post_init__(self) -> None:
        scenes = self.scenes[self.scene :]
        begins = self.scene_begins or scene_begins((scenes,), self.begins)
        object.__setattr__(self, "movement", performance(scenes, [0, *(begin - self.begins for begin in begins[1:])]))

    def of_scene(self, scene: int) -> Movement:
        return self.scenes[scene] if scene < len(self.scenes) else NOTHING

    def edition(self, scene: int) -> int:
        return self.editions[scene] if scene < len(self.editions) else UNNUMBERED

    @property
    def stands(self) -> bool:
        """True if its robot only stands there: it plays nothing in any scene. (A robot without scenes has to stop.)"""
        return bool(self.scenes) and not any(scene.duration or scene.open for scene in self.scenes)

    @property
    def ends(self) -> Duration:
        """The beat of the performance at which it ends."""
        return self.begins + self.movement.duration


Follow = Literal["ros", "midi", "link"]
"""A clock that can be followed: the time on ROS's /clock, MIDI clock, or Ableton Link."""


@dataclass(frozen=True, slots=True)
class OutsideClock:
    """The clock that robots follow; `port` is the name of the MIDI input that it comes from, or "" for the first."""

    follow: Follow
    port: str = ""


Rejoin = Literal["continue", "scene", "return", "next", "pause"]
"""The behavior of a robot that listens again: it continues with the others, or stands still until the next scene or the
next play, or first drives to the place that its part has reached, or all wait for it."""


@dataclass(frozen=True, slots=True)
class Deadman:
    """A button to hold while real robots move, counted from 0, on a topic of sensor_msgs/Joy."""

    topic: str
    button: int

    def __str__(self) -> str:
        return f"button {self.button} on {self.topic}"


@dataclass(frozen=True, slots=True)
class Preflight:
    """The distance from its place, in meters, and the angle, in radians, by which a robot may be off when it begins."""

    distance: float = 0.1
    turn: float = math.radians(10)


@dataclass(frozen=True, slots=True)
class Safety:
    """Conditions that stop real robots besides the score. `stop` is a topic of std_msgs/Bool, true in an emergency.

    `faults` has the responses to faults of a robot. With `start_without`, the dance begins although some robots don't
    listen. With `sight`, all robots stand while the pose of one of them is unknown.
    """

    stop: str | None = None
    deadman: Deadman | None = None
    rejoin: Rejoin = "continue"
    faults: FaultRules = field(default_factory=FaultRules)
    start_without: bool = True
    preflight: Preflight = Preflight()
    sight: bool = False


@dataclass(frozen=True)
class Score:
    """All parts, which play together."""

    tempo: Fraction
    """Beats per minute."""
    parts: Mapping[str, Part]
    text: str = ""
    """The program, for viewers."""
    offsets: Mapping[int, int] = field(default_factory=dict)
    """The offsets of its statements by ID, for viewers."""
    world: World = EMPTY
    """The surroundings of simulated robots."""
    safety: Safety = Safety()
    scene: int = 0
    """The scene from which on it plays, from 0."""
    since: Exact = 0
    """The beat at which that scene began."""
    publish: bool = False
    """True if others in ROS 2 may watch."""
    bar: int | None = None
    """The number of beats in a bar, if the program sets it."""
    scene_names: tuple[str, ...] = ()
    """The names of scenes: empty for those without one."""
    clock: OutsideClock | None = None
    """The clock with which it plays."""
    music: Music | None = None
    """The song that pages play."""
    osc: Osc | None = None
    """Viewers over OSC, which stages don't know."""
    count_in: bool = False
    """True if a bar is counted before beat 0."""
    scene_begins: tuple[Exact, ...] = field(init=False)
    """The beats at which that scene and the later ones begin."""

    def __post_init__(self) -> None:
        scenes = [part.scenes[self.scene :] for part in self.parts.values()]
        begins = scene_begins(scenes, self.since, [part.begins for part in self.parts.values()])
        object.__setattr__(self, "scene_begins", begins)
        parts = {
            name: part
            if (part.scene, part.scene_begins or begins[:1]) == (self.scene, begins) and len(part.scenes) <= len(begins)
            else replace(part, scene=self.scene, scene_begins=begins)
            for name, part in self.parts.items()
        }
        object.__setattr__(self, "parts", parts)

    def moving(self) -> Score:
        """Return the score without the parts whose robots only stand there: nothing of them has to be sent."""
        return replace(self, parts={name: part for name, part in self.parts.items() if not part.stands})

    @cached_property
    def hosts(self) -> frozenset[Host]:
        """The other machines whose stages move robots, regardless of the patience of each."""
        return frozenset(replace(part.host, patience=LINK_PATIENCE) for part in self.parts.values() if part.host)

    def on(self, host: str) -> Score:
        """Return the score as the stage of a host plays it ("": the one here): others move the robots elsewhere and
        measure their poses, but the beats at which scenes begin depend on all."""
        there = {
            name: part
            for name, part in self.parts.items()
            if (part.host.name if part.host else "") != host and not part.elsewhere
        }
        lost = {
            name: replace(
                each,
                elsewhere=True,
                odom=None,
                odom_frame=each.odom_frame if each.odom else "own",
                battery=None,
                reset=None,
            )
            for name, each in there.items()
        }
        return replace(self, parts={**self.parts, **lost})

    @cached_property
    def scenes(self) -> int:
        """The number of its scenes."""
        return max((len(part.scenes) for part in self.parts.values()), default=0)

    @cached_property
    def open(self) -> bool:
        """True if senses decide what is performed in it."""
        return any(scene.open for part in self.parts.values() for scene in part.scenes[self.scene :])

    @property
    def moves(self) -> bool:
        """True if there is anything to play. If not, its robots only have to be stopped."""
        return bool(self.beats or self.open)

    def scene_at(self, beat: Exact) -> tuple[int, Exact]:
        """Return the scene that plays at a beat, and the beat at which it begins, if no sense ever holds.

        Of several that begin at this beat, it is the first: senses may decide that it isn't empty.
        """
        passed = bisect_left(self.scene_begins, beat)
        if self.scene_begins[passed : passed + 1] != (beat,):
            passed = max(passed - 1, 0)
        return self.scene + passed, self.scene_begins[passed] if self.scene_begins else self.since

    def begins(self, robot: str, scene: int) -> Exact:
        """Return the beat at which a robot's part of a scene begins, if no sense ever holds."""
        part = self.parts[robot]
        return part.begins if scene <= self.scene else self.scene_begins[scene - self.scene]

    @cached_property
    def beats(self) -> Duration:
        """The beat at which the last part ends."""
        return max((part.ends for part in self.parts.values()), default=0)

    def seconds(self, beats: Duration) -> float:
        return float(beats * 60 / self.tempo)


def twist(velocity: Velocity, profile: Profile, tempo: Fraction) -> Twist:
    """Return a velocity in SI units: steps per beat times meters per step times beats per second."""
    per_second = tempo / 60
    return Twist(*in_axes([each and each * per_second for each in velocity], profile))


def speeds_of(profile: Profile, tempo: Fraction) -> Twist:
    """Return what `forward` and `left` move a robot in a beat (meters, radians), within its limits."""
    beat = 60 / float(tempo)
    most = [limit * beat if limit else math.inf for limit in (profile.max_linear, profile.max_angular)]
    return Twist(x=min(profile.step, most[0]), yaw=min(profile.quarter_turn, most[1]))


def in_axes(components: Iterable[Component | float], profile: Profile) -> list[float]:
    """Return the components of a velocity, or their bounds, in meters and radians."""
    step, turn = profile.step, profile.quarter_turn
    units = (step, step, step, turn)
    return [in_si(each, own, turn, DEGREE) if each else 0.0 for each, own in zip(components, units, strict=True)]


def in_namespace(topic: str, namespace: str) -> str:
    """Return a topic's full name in a robot's namespace; one that begins with `/` is already full."""
    return topic if topic.startswith("/") else f"{namespace}/{topic}"


def scene_begins(
    parts: Iterable[Sequence[Movement]], since: Exact = 0, entered: Sequence[Exact] | None = None
) -> tuple[Exact, ...]:
    """Return the beats at which scenes begin: each on the first whole beat at which all robots' scenes above are over.

    The first scene begins at beat `since`, and each robot's part of it at a beat of `entered`, if they differ. A scene
    below one that never ends does not begin.
    """
    begins: list[Exact] = []
    begin: Duration = since
    starts: Iterable[Exact] | None = entered
    for scene in zip_longest(*parts, fillvalue=NOTHING):
        assert not isinstance(begin, float)
        begins.append(begin)
        lasting = zip(starts or repeat(begin), scene)  # noqa: B905 (endless on purpose)
        end = max(start + movement.duration for start, movement in lasting)
        if end == ENDLESS:
            break
        begin, starts = math.ceil(end), None
    return tuple(begins)


def performance(scenes: Sequence[Movement], begins: Sequence[Exact]) -> Movement:
    """All scenes of one robot as one movement, in which it stands still until each of them begins, the first at 0."""
    if len(scenes) == 1:
        return scenes[0]
    items = []
    end: Duration = 0
    for scene, begin in zip(scenes, begins, strict=False):
        if scene.duration and begin > end:
            assert not isinstance(end, float)
            items.append(stand(begin - end))
            end = begin
        items.append(scene)
        end += scene.duration
    return series(items)
