"""Reads an `improv.toml`: the robots, their profiles, start poses, and topics, and their world."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from improv_core.diagnostics import MAX_SHOWN, Diagnostic, Severity
from improv_core.robots.bodies import with_offsets
from improv_core.robots.formation import Formation, read_formation
from improv_core.robots.hosts import device_of, host_of, read_hosts
from improv_core.robots.profiles import read_profiles
from improv_core.robots.ros_names import ros_name
from improv_core.robots.sections import read_music, read_osc, read_safety, read_world
from improv_core.robots.senses import read_senses
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.robots.toml_text import read_toml
from improv_core.score.following import refusal
from improv_core.score.motion import Pose
from improv_core.score.music import Music
from improv_core.score.osc import Osc
from improv_core.score.profiles import BUILT_IN, DEFAULT, Profile
from improv_core.score.score import BASE_FRAME, DeviceAddress, Host, OdomFrame, OutsideClock, Safety, in_namespace
from improv_core.score.senses import BUILT_IN as BUILT_IN_SENSES
from improv_core.score.senses import CUE, NEAR, BuiltIn, Source, Topic
from improv_core.score.world import EMPTY, World
from improv_core.syntax.vocabulary import WORDS

FILE_NAME = "improv.toml"


@dataclass(frozen=True, slots=True)
class Robot:
    """One robot: its profile, its pose at beat 0 (None: next to the others), its topic, and the message type on it.

    `reset` is the service that moves it back to its start pose, and `odom` the topic of its poses, if it has them.
    `odom_frame` is the frame of these. `battery` is the topic of its charge. `frame` is the frame of its velocities.
    With `follow`, it returns to its ideal path. `namespace` is the prefix of its topics, if the file sets it. `host` is
    the place of the stage that moves it, if that isn't the one to ROS 2 here; an output finds it at its `device`.
    """

    profile: Profile
    start: Pose | None
    topic: str
    message: str
    reset: str | None = None
    odom: str | None = None
    frame: str = BASE_FRAME
    follow: bool = False
    odom_frame: OdomFrame = "own"
    battery: str | None = None
    namespace: str | None = None
    host: Host | None = None
    device: DeviceAddress | None = None

    @property
    def has_profile(self) -> bool:
        """True if the file gives it a profile, which is never the default one."""
        return self.profile != DEFAULT

    def of_kind(self, profile: Profile) -> Robot:
        """Return the same robot with this profile, which decides the message type unless the file does."""
        message = profile.message if self.message == DEFAULT.message else self.message
        return replace(self, profile=profile, message=message)


@dataclass(frozen=True)
class Robots:
    """The valid content of an `improv.toml`. `profiles` are its own and the built-in ones.

    `namespace` comes before ROS names that don't start with `/`. It is "" or, for example, "/lab". `node` is the name
    of Improv's node in ROS 2; None stands for a unique one. `senses` are the declared ones. The listed robots stand in
    the `formation` already; if there are none, it is for the robots of a program. With `publish`, others in ROS 2 can
    watch the performance; `osc` lets others do so over OSC. `music` is the song that pages play. `starts` replace the
    file's starts, and `kinds` has profiles for robots that have none in the file. A `clock` outside sets the tempo.
    """

    robots: Mapping[str, Robot] = field(default_factory=dict)
    profiles: Mapping[str, Profile] = field(default_factory=lambda: BUILT_IN)
    path: Path | None = None
    text: str = ""
    diagnostics: tuple[Diagnostic, ...] = ()
    namespace: str = ""
    use_sim_time: bool = False
    world: World = EMPTY
    safety: Safety = field(default_factory=Safety)
    node: str | None = None
    senses: Mapping[str, Source] = field(default_factory=dict)
    formation: Formation | None = None
    publish: bool = False
    clock: OutsideClock | None = None
    osc: Osc | None = None
    starts: Mapping[str, Pose] = field(default_factory=dict)
    kinds: Mapping[str, Profile] = field(default_factory=dict)
    music: Music | None = None

    @property
    def ok(self) -> bool:
        """True if robots may play. If the file has an error, a robot could be driven as if it were another kind."""
        return all(diagnostic.severity is not Severity.ERROR for diagnostic in self.diagnostics)

    def profile_of(self, name: str) -> Profile:
        """Return the profile of a robot, listed or not. A robot that is not listed has no limits."""
        listed = self.robots.get(name)
        return listed.profile if listed else self.kinds.get(name, DEFAULT)

    def robot(self, name: str) -> Robot:
        """Return a robot, listed or not."""
        profile = self.profile_of(name)
        robot = self.robots.get(name) or Robot(profile, None, _topic(f"{self.namespace}/{name}"), profile.message)
        return replace(robot, start=self.starts[name]) if name in self.starts else robot

    def namespace_of(self, name: str) -> str:
        robot = self.robots.get(name)
        return (robot and robot.namespace) or f"{self.namespace}/{name}"

    def role_of(self, name: str) -> str | None:
        """Return the listed robot that has the namespace of a robot with this name: both would be one."""
        inside = f"{self.namespace}/{name}"
        return next((each for each, robot in self.robots.items() if robot.namespace == inside), None)

    def of_kinds(self, kinds: Mapping[str, Profile]) -> Robots:
        """Return the same robots, with these profiles for those without one."""
        listed = {
            name: robot.of_kind(kinds[name]) if name in kinds and not robot.has_profile else robot
            for name, robot in self.robots.items()
        }
        return replace(self, robots=listed, kinds=kinds)

    @cached_property
    def part_words(self) -> frozenset[str]:
        """Words for body parts and groups that any profile declares."""
        return frozenset(name for each in self.profiles.values() if each.body for name in each.body.words)

    @property
    def urdfs(self) -> Sequence[Path]:
        """Files that profiles name as the URDFs of their robots."""
        names = dict.fromkeys(each.body.urdf for each in self.profiles.values() if each.body and each.body.urdf)
        return [self.path.parent / name for name in names] if self.path else []

    @property
    def sense_names(self) -> tuple[str, ...]:
        """Names of all senses: the built-in ones and the declared ones."""
        return tuple(dict.fromkeys([*BUILT_IN_SENSES, *self.senses]))

    def sense(self, robot: str, name: str) -> Source:
        """Return the source of a robot's sense, with the full name of its topic. Raises KeyError if it is unknown."""
        source = self.senses.get(name) or BUILT_IN_SENSES[name]
        if isinstance(source, Topic):
            return replace(source, topic=in_namespace(source.topic, self.namespace_of(robot)))
        return source

    def lacks(self, robot: str, name: str) -> bool:
        """True if a robot is listed, but has no source for this sense.

        Then only a simulated robot has it. A profile that sets `near` is a source for `near`. People give the cue.
        """
        if robot not in self.robots or name == CUE or not isinstance(self.sense(robot, name), BuiltIn):
            return False
        if self.robots[robot].device:  # its output may have it
            return False
        return name != NEAR or self.robots[robot].profile.near is None


@lru_cache(maxsize=10)  # each save asks for every open program, and each key in the file several times
def read_robots(text: str, path: Path | None = None) -> Robots:
    """Read the text of an `improv.toml`. Never raises; errors are in `diagnostics`, in the order of the text."""
    toml = read_toml(text)
    reading = TomlReading(toml, list(toml.diagnostics))
    sections = {name: reading.table((name,), value) for name, value in reading.table((), toml.readable).items()}

    def section(name: str) -> Mapping[str, Any]:
        return sections.get(name, {})

    profiles = read_profiles(reading, section("profiles"))
    in_ros = reading.values(("ros",), section("ros"))
    namespace = ros_name(reading, ("ros", "namespace"), in_ros.get("namespace"), "") or ""
    safety = read_safety(reading, in_ros, namespace, section("on"), section("preflight"))
    world = read_world(reading, section("world"))
    hosts = read_hosts(reading, section("hosts"))
    listed = _Listed(reading, profiles, hosts, world, namespace, in_ros.get("odom_frame", "own"))
    robots = listed.robots(section("robots"))
    free = {name: robot.profile for name, robot in robots.items() if not robot.start}
    formation = None
    if isinstance(toml.readable.get("formation"), dict):
        formation = read_formation(reading, section("formation"), free, world)
    if formation:
        starts = dict(zip(free, formation.poses(len(free)), strict=True))
        robots = {name: replace(robot, start=robot.start or starts[name]) for name, robot in robots.items()}
    if safety.rejoin == "return" and (why := _refuses_return(robots, world)):
        reading.at_value(("ros", "rejoin"), f"`return` {why}", whole=True)
    found = Robots(
        robots,
        profiles,
        path,
        text,
        namespace=namespace,
        use_sim_time=in_ros.get("use_sim_time", False),
        world=world,
        safety=safety,
        node=in_ros.get("node"),
        senses=read_senses(reading, section("senses")),
        formation=formation,
        publish=in_ros.get("publish", False),
        clock=_clock(reading, section("clock")),
        osc=read_osc(reading, section("osc")),
        music=read_music(reading, section("music"), path) if "music" in sections else None,
    )
    diagnostics = tuple(_shown(sorted(reading.diagnostics, key=lambda diagnostic: diagnostic.span)))
    if toml.diagnostics:  # the rest may mean something else without the invalid lines
        return Robots(path=path, text=text, diagnostics=diagnostics)
    return replace(found, diagnostics=diagnostics)


def find_robots_file(folder: Path) -> Path | None:
    """Return the `improv.toml` in a folder, or in its nearest parent that has one.

    Anything with that name counts, even a broken link, a folder, or a file that we may not look at: robots whose limits
    can't be read must not move as if they had none.
    """
    folder = absolute(folder)
    for place in (folder, *folder.parents):
        try:
            (place / FILE_NAME).lstat()
        except (FileNotFoundError, NotADirectoryError, ValueError):  # ValueError: a path with a zero byte
            continue
        except OSError:
            pass
        return place / FILE_NAME
    return None


def absolute(path: Path) -> Path:
    """Return a path from the root, without `..`. A link stays as it is written; `..` after a link leads above its
    target, as everywhere in the system."""
    parts = path.absolute().parts
    above = max((place for place, part in enumerate(parts, 1) if part == ".."), default=0)
    return Path(os.path.realpath(Path(*parts[:above])), *parts[above:]) if above else Path(*parts)


def _refuses_return(robots: Mapping[str, Robot], world: World) -> str | None:
    """Return why robots can't drive back by themselves, and what to do; None if they can."""
    if world.keep_apart is None:
        return "has robots drive by themselves: add `keep_apart` under [world], so that they keep apart"
    if not robots:
        return "needs poses of robots in the world: list the robots under [robots]"
    if unseen := [name for name, robot in robots.items() if not robot.odom or robot.odom_frame != "world"]:
        return f'needs poses of `{unseen[0]}` in the world: add `odom` and `odom_frame = "world"`'
    if fixed := [name for name, robot in robots.items() if not robot.profile.drives_anywhere]:
        return f"needs robots that turn on the spot and drive forward, which `{fixed[0]}` can't"
    return None


def _shown(diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    hidden = diagnostics[MAX_SHOWN:]
    if not hidden:
        return diagnostics
    message = f"fix what is marked first: {len(hidden):,} more values are wrong and aren't marked yet"
    return [*diagnostics[:MAX_SHOWN], Diagnostic("more-errors", hidden[0].span, message)]


def _topic(namespace: str) -> str:
    return f"{namespace}/cmd_vel"


_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # a token of a ROS 2 topic


@dataclass(frozen=True, slots=True)
class _Listed:
    """Reads the robots of a file, given what its other sections set for all of them."""

    reading: TomlReading
    profiles: Mapping[str, Profile]
    hosts: Mapping[str, Host]
    world: World
    namespace: str
    odom_frame: OdomFrame

    def robots(self, tables: Mapping[str, Any]) -> dict[str, Robot]:
        made = {}
        for name, value in tables.items():
            keys = ("robots", name)
            robot = self.robot(keys, self.reading.table(keys, value))
            if not _NAME.fullmatch(name):
                message = f"`{name}` is not a valid robot name: use a to z, digits, and `_`, starting with a letter"
                self.reading.at_key(keys, message)
            elif name in WORDS:
                self.reading.at_key(keys, f"`{name}` is a reserved word: choose another name")
            else:
                made[name] = robot
                self.check_room(keys, robot)
        self.one_role_each(made)
        return made

    def check_room(self, keys: Keys, robot: Robot) -> None:
        """Report a robot that is too wide for the world, or starts outside it."""
        wide = 2 * robot.profile.radius
        if self.world.size and wide > min(self.world.size):
            message = f"`{keys[-1]}` is {wide:g} m wide and doesn't fit: make the world larger"
            self.reading.at_key(keys, message, whole=True)
        if robot.start and not self.world.holds(robot.start.x, robot.start.y):
            message = "this start is outside the walls: move it inside"
            self.reading.at_value((*keys, "start"), message, whole=True)

    def one_role_each(self, robots: Mapping[str, Robot]) -> None:
        """Report robots that share a namespace or a topic: a real robot can't dance two parts at once."""
        inside = {name: each.namespace or f"{self.namespace}/{name}" for name, each in robots.items()}
        own = {name for name, each in robots.items() if each.topic != _topic(inside[name])}
        namespaces: dict[str, str] = {}
        topics: dict[str, str] = {}
        # First those whose namespace or topic isn't in the file: one in the file is the one to change.
        for name in sorted(robots, key=lambda each: robots[each].namespace is not None):
            if (other := namespaces.setdefault(inside[name], name)) != name:
                message = f"`{other}` has this namespace too: give each its own"
                self.reading.at_value(("robots", name, "namespace"), message, whole=True)
        devices: dict[tuple[str, int | None], str] = {}
        machines = {each.host.name for each in robots.values() if each.host and not each.host.output}
        for name, each in robots.items():
            at = each.device and (each.device.address, each.device.node)
            if at and (other := devices.setdefault(at, name)) != name:
                message = f"`{other}` is the robot at this address, too: give each its own `address` or `node`"
                self.reading.at_value(("robots", name, "address"), message, whole=True)
            if each.host and each.host.output and each.host.name in machines:
                message = f"`{each.host.name}` is also a host: give that another name in ~/.ssh/config"
                self.reading.at_value(("robots", name, "output"), message)
        for name in sorted(robots, key=own.__contains__):
            if (other := topics.setdefault(robots[name].topic, name)) != name and name in own:
                message = f"`{other}` listens on this topic too: give each its own"
                self.reading.at_value(("robots", name, "topic"), message, whole=True)

    def robot(self, keys: Keys, table: Mapping[str, Any]) -> Robot:
        reading, namespace, values = self.reading, self.namespace, self.reading.values(keys, table)
        kind = reading.one_of((*keys, "profile"), table.get("profile"), self.profiles, whole=True)
        profile = self.profiles[kind] if kind else DEFAULT
        if "joints" in table:
            body = with_offsets(reading, (*keys, "joints"), table["joints"], profile.body)
            profile = replace(profile, body=body)

        def name(key: str, inside: str) -> str | None:
            return ros_name(reading, (*keys, key), values.get(key), inside)

        own = name("namespace", namespace)
        inside = own or f"{namespace}/{keys[-1]}"
        odom = name("odom", inside)
        by_default = in_namespace("battery_state", inside) if odom else None
        follow = values.get("follow", False)
        if follow and not odom and profile.dynamics != "motors":
            message = "`follow` needs to know where the robot is: add `odom`"
            reading.at_key((*keys, "follow"), message, whole=True)
        elif follow and (why := refusal(profile)):
            reading.at_key((*keys, "follow"), f"`follow` {why}", whole=True)
        if "odom_frame" in values and not odom:
            message = "`odom_frame` is about the poses on `odom`: add `odom`"
            reading.at_key((*keys, "odom_frame"), message, whole=True)
        return Robot(
            profile,
            _start(values["start"]) if "start" in values else None,
            name("topic", namespace) or _topic(inside),
            values.get("message", profile.message),
            reset=name("reset", namespace),
            odom=odom,
            frame=values.get("frame", BASE_FRAME),
            follow=follow,
            odom_frame=values.get("odom_frame", self.odom_frame),
            battery=name("battery", inside) or by_default,
            namespace=own,
            host=host_of(reading, keys, values, self.hosts),
            device=device_of(reading, keys, table, values),
        )


def _start(start: Mapping[str, float]) -> Pose:
    return Pose(start.get("x", 0.0), start.get("y", 0.0), heading=math.radians(start.get("heading", 0.0)))


def _clock(reading: TomlReading, table: Mapping[str, Any]) -> OutsideClock | None:
    values = reading.values(("clock",), table)
    follow, port = values.get("follow"), values.get("port", "")
    if port and follow != "midi":
        message = '`port` is a MIDI input: it works only with `follow = "midi"`'
        reading.at_key(("clock", "port"), message, whole=True)
    return OutsideClock(follow, port) if follow else None
