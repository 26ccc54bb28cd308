"""All keys of an `improv.toml`: what they set, their units, ranges, and defaults.

The reader of the file and the editor's help use this table; a test compares the tables in the docs with it, and
`editors/generate.py` writes the JSON schema from it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import get_args

from improv_core.robots.schema_key import Key, flag, number, table
from improv_core.robots.schema_robots import HEADING, PROFILE, ROBOT, place
from improv_core.robots.toml_positions import Keys
from improv_core.score.faults import Fault, Response
from improv_core.score.osc import LAST_PORT, is_own, peer_of
from improv_core.score.score import Follow, OdomFrame, Rejoin
from improv_core.score.senses import Message

MAX_BUTTON = 99
SHAPES = "line", "circle", "grid"
FACING = "in", "out"


def find(keys: Keys) -> Key | None:
    """Look up a key or a table; None if there is no such key."""
    found: Key | None = SCHEMA
    for name in keys:
        if found:
            found = found.items if isinstance(name, int) else found.keys.get(name) or found.named
    return found


def known(keys: Keys) -> Key:
    """Look up a key that exists."""
    found = find(keys)
    assert found, keys
    return found


def _length(about: str) -> Key:
    return number(about, "meters", 0.001, 1000)


_BUTTON = Key("the button of a gamepad, counted from 0", "integer", least=0, most=MAX_BUTTON, example="4")

_ROS = {
    "namespace": Key(
        "the prefix for all names of topics and services that don't begin with `/`", default="none", example='"lab"'
    ),
    "node": Key(
        "the name of Improv's node, for its services and parameters",
        default="`improv_HOST_PID`",
        example='"conductor"',
        form=(
            re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,199}").fullmatch,  # as in rmw, where names of services come after it
            "use the letters a to z, digits, and `_`, not starting with a digit, without `/`",
        ),
    ),
    "publish": flag(
        "publish what plays, for rviz, Foxglove, and monitors: paths, markers, the position, and diagnostics"
    ),
    "use_sim_time": flag("stamp messages with the time on `/clock`, for simulated robots"),
    "odom_frame": Key(
        'the frame of the poses of all robots: `"own"`, or `"world"`, which has the coordinates of `start`',
        default='`"own"`',
        choices=get_args(OdomFrame),
    ),
    "stop": Key(
        "a topic of type `std_msgs/msg/Bool` that stops all robots while it is true",
        default="none",
        example='"/e_stop"',
    ),
    "deadman": Key(
        "a button to hold while robots move: `topic`, of type `sensor_msgs/msg/Joy`, and `button`, counted from 0",
        "object",
        default="none",
        keys={"topic": Key("the topic of the gamepad", example='"/joy"'), "button": _BUTTON},
        required=("topic", "button"),
        example='{ topic = "/joy", button = 4 }',
    ),
    "rejoin": Key(
        'what happens when a robot stops listening and comes back: it continues in the middle (`"continue"`), it stands'
        ' until the next scene (`"scene"`) or the next play (`"next"`), it drives to where it should be first'
        ' (`"return"`), or all robots pause until it is back (`"pause"`)',
        default='`"continue"`',
        choices=get_args(Rejoin),
    ),
    "start_without": flag(
        "begin although some robots don't listen, and name them; if false, nothing moves until all listen", default=True
    ),
}
_FAULTS: Mapping[Fault, str] = {
    "off_path": "a robot is farther off its path than `distance` or `angle`",
    "silent": "no pose of a robot has come for a second",
    "jumped": "the poses of a robot jump farther than it can move",
    "stuck": "a robot doesn't move although it should",
    "joints": "a robot's joints don't follow the program for a second",
    "gone": "nothing listens on a robot's topic anymore, or its output has lost it",
    "late": "commands leave more than 20 ms late",
}
_ON: Mapping[str, Key] = {
    **{
        fault: Key(f"what follows if {about}", default='`"tell"`', choices=get_args(Response))
        for fault, about in _FAULTS.items()
    },
    "distance": number("how far off its path a robot may be", "meters", 0.01, 100, "0.25"),
    "angle": number("how far it may be turned away from it", "degrees", 1, 180, "15"),
}
_CIRCLE = {"x": place("the center along x"), "y": place("the center along y"), "radius": _length("its radius")}
_BOX = {
    "x": place("the center along x"),
    "y": place("the center along y"),
    "width": _length("its size along its own x axis"),
    "height": _length("its size along its own y axis"),
    "heading": HEADING,
}
_WORLD = {
    "size": Key(
        "a floor with walls around it, in meters along x and along y, centered on the origin",
        "array",
        default="an endless floor",
        items=_length("a length of the floor"),
        count=2,
        example="[6, 4]",
    ),
    "walls": Key(
        "more walls: lines in meters, each from x, y to x, y",
        "array",
        default="none",
        items=Key(
            "a wall: 4 numbers in meters, from x, y to x, y",
            "array",
            items=place("a coordinate"),
            count=4,
            example="[0, 0, 2, 0]",
        ),
        example="[[0, 0, 2, 0]]",
    ),
    "circles": Key(
        "round obstacles, in meters: `x` and `y`, which default to 0, and `radius`",
        "array",
        default="none",
        items=table("a round obstacle", _CIRCLE, "{ x = 1, y = 0, radius = 0.3 }", ("radius",)),
        example="[{ x = 1, y = 0, radius = 0.3 }]",
    ),
    "boxes": Key(
        "rectangles, in meters: `x`, `y`, `width`, and `height`, and a `heading` in degrees; `x`, `y`, and `heading`"
        " default to 0",
        "array",
        default="none",
        items=table("a rectangle", _BOX, "{ x = 1, y = 0, width = 0.5, height = 1 }", ("width", "height")),
        example="[{ x = 1, y = 0, width = 0.5, height = 1 }]",
    ),
    "margin": number(
        "how far robots should stay from each other and from walls and obstacles: the check warns if they come nearer",
        "meters",
        0,
        1000,
        "0",
    ),
    "keep_apart": number(
        "real robots pause everything before they come nearer to each other than this, from edge to edge",
        "meters",
        0.01,
        10,
        "not guarded",
    ),
}
_SENSE = {
    "topic": Key(
        "the topic; without a leading `/`, the name is in the robot's namespace, which is in that of `[ros]`",
        example='"scan"',
    ),
    "message": Key(
        "its type: "
        + ", ".join(f'`"{name}"`' for name in get_args(Message)[:-1])
        + f', or `"{get_args(Message)[-1]}"`',
        choices=get_args(Message),
    ),
    "below": Key(
        "the sense is true while the number is less than this: the nearest reading of a scan or a range, in meters; the"
        " speed of an odometry message, in m/s; the data of a Float32",
        "number",
        example="0.5",
    ),
    "above": Key("the same, while the number is greater than this; write either of them", "number", example="0.5"),
    "from": number(
        "the start of the sector of a scan that counts, counterclockwise from straight ahead",
        "degrees",
        -360,
        360,
        "-180",
    ),
    "to": number("the end of that sector", "degrees", -360, 360, "180"),
    "button": Key(
        "the button of a gamepad, counted from 0",
        "integer",
        default="any button",
        least=0,
        most=MAX_BUTTON,
        example="0",
    ),
    "timeout": number(
        "after this time without a usable message, the sense is silent; 0, for a Bool or a Joy, if messages come only"
        " when something changes",
        "seconds",
        0.05,
        60,
        "1",
    ),
    "key": Key(
        "a letter or a digit, instead of a topic",
        example='"d"',
        form=(re.compile("[a-z0-9]").fullmatch, "write `key` as one letter, a to z, or one digit"),
    ),
    "osc": Key(
        "the word that stands for it in OSC messages, `/improv/sense WORD ROBOT 1`, instead of a topic",
        example='"kick"',
        form=(re.compile(r"[\w-]{1,100}").fullmatch, "write `osc` as one word of letters, digits, `_`, and `-`"),
    ),
}
_PREFLIGHT = {
    "distance": number("how far from its place a robot may stand", "meters", 0.001, 100, "0.1"),
    "degrees": number("by how much it may be turned", "degrees", 0.1, 180, "10"),
}
_CLOCK = {
    "follow": Key(
        'the clock that gives the tempo: `"ros"`, the time of a simulation on `/clock`; `"midi"`, MIDI clock; or'
        ' `"link"`, Ableton Link',
        default="none: beats pass at the program's tempo, by this machine's clock",
        choices=get_args(Follow),
        example='"midi"',
    ),
    "port": Key("the MIDI input to listen to, or the beginning of its name", default="the first one", example='"IAC"'),
}
_FORMATION = {
    "shape": Key(
        'how they stand: side by side in a `"line"`, in a `"circle"`, or in the rows of a `"grid"`, around the origin',
        choices=SHAPES,
    ),
    "distance": number("how far apart neighbors are, from center to center", "meters", 0.001, 1000, "3"),
    "facing": Key(
        'where robots in a circle look: `"in"`, to its center, or `"out"`; in other shapes, all look along x',
        default='`"in"`',
        choices=FACING,
    ),
}
_HOST = {
    "domain": Key("ROS_DOMAIN_ID there", "integer", default="as it is set there", least=0, most=232, example="7"),
    "rmw": Key(
        "RMW_IMPLEMENTATION there",
        default="as it is set there",
        choices=("rmw_cyclonedds_cpp", "rmw_fastrtps_cpp", "rmw_zenoh_cpp"),
    ),
}
_MUSIC = {
    "file": Key(
        "the song, in the folder of this file or deeper: WAV, MP3, Ogg, FLAC, or M4A",
        default="none: drop one onto the page",
        example='"song.mp3"',
    ),
    "first_beat": number("where in the song beat 1 of the dance is", "seconds", -3600, 3600, "0"),
    "count_in": flag("count one bar before each dance begins, with or without a song"),
    "volume": number("how loud it is, from silent to as loud as it was recorded", "shares", 0, 1, "1"),
}
_OSC = {
    "listen": Key(
        "the UDP port on which Improv hears OSC messages",
        "integer",
        default="none: it hears no messages",
        least=1,
        most=LAST_PORT,
        example="7000",
    ),
    "host": Key(
        "the IPv4 address of this machine on which it hears them; other machines reach it only with"
        " `--osc-network` or the setting `osc.network`",
        default='`"127.0.0.1"`: only programs on this machine are heard',
        form=(is_own, 'write `host` as an IPv4 address of this machine, such as `"127.0.0.1"`'),
    ),
    "send": Key(
        'where what plays is sent: each `"HOST:PORT"`; other machines get it only with `--osc-network` or the setting'
        " `osc.network`",
        "array",
        default="nowhere",
        least=1,
        items=Key(
            "a program that hears OSC: its host and its UDP port",
            example='"127.0.0.1:9000"',
            form=(peer_of, 'write a host and a port: `"127.0.0.1:9000"`'),
        ),
        example='["127.0.0.1:9000"]',
    ),
    "time_tags": flag(
        "send bundles with the time at which each thing was due; false for programs that read no bundles, such as Sonic"
        " Pi",
        default=True,
    ),
}
SCHEMA = table(
    "an `improv.toml`",
    {
        "robots": Key("the robots, by their names in programs", "object", named=table("a robot", ROBOT)),
        "profiles": Key("your own kinds of robots, by name", "object", named=table("a kind of robot", PROFILE)),
        "formation": table("where robots without a `start` start", _FORMATION, required=("shape",)),
        "ros": table("names, time, and safety in ROS 2, for all robots", _ROS),
        "hosts": Key(
            "machines that have a stage of their own, as ssh calls them", "object", named=table("a machine", _HOST)
        ),
        "on": table("what follows from the faults of real robots", _ON),
        "world": table("the simulator's walls and obstacles", _WORLD),
        "clock": table("a clock from outside that robots follow", _CLOCK),
        "preflight": table("how far from their places robots may stand when they begin", _PREFLIGHT),
        "music": table("the song that the page plays", _MUSIC),
        "senses": Key("where senses come from, by their names in programs", "object", named=table("a sense", _SENSE)),
        "osc": table("the programs with which OSC messages are exchanged", _OSC),
    },
)
