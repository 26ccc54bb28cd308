"""All keys of an `improv.toml`: what they set, their units, ranges, and defaults.

The reader of the file, the editor's help, and `schema_tables.py` use this table.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

from improv_core.robots.schema_bodies import BODY, OFFSETS
from improv_core.robots.schema_key import Key
from improv_core.robots.schema_key import number as _number
from improv_core.robots.schema_key import table as _table
from improv_core.robots.schema_music import MUSIC
from improv_core.robots.schema_osc import OSC
from improv_core.robots.toml_positions import Keys
from improv_core.score.faults import Fault, Response
from improv_core.score.profiles import DYNAMICS, MESSAGES, MOTIONS
from improv_core.score.score import Follow, OdomFrame, Rejoin
from improv_core.score.senses import Message

MOST_BUTTON = 99
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


def _place(about: str) -> Key:
    return _number(about, "meters", -1000, 1000, "0")


def _length(about: str) -> Key:
    return _number(about, "meters", 0.001, 1000)


_HEADING = _number("the heading, counterclockwise from the x axis", "degrees", -360, 360, "0")
_BUTTON = Key("the button of a gamepad, counted from 0", "integer", least=0, most=MOST_BUTTON, example="4")

_START = {"x": _place("the position along x"), "y": _place("the position along y"), "heading": _HEADING}
_ROBOT = {
    "profile": Key(
        "the kind of robot: a built-in profile or one of yours",
        default="a step of 2 m, no limits, all motions",
        profile=True,
    ),
    "start": Key(
        "its pose at beat 0: `x`, `y` in meters, `heading` in degrees, counterclockwise from the x axis; each defaults"
        " to 0",
        "object",
        default="in the formation, or next to the other robots",
        keys=_START,
        example="{ x = 0, y = 0, heading = 0 }",
    ),
    "namespace": Key(
        "the real robot that dances its part: the prefix of all its topics that don't begin with `/`; without a leading"
        " `/`, it is in the namespace of `[ros]`",
        default="`NAME`",
        example='"tb3_07"',
    ),
    "topic": Key(
        "the topic it listens on; without a leading `/`, the name is in the namespace of `[ros]`",
        default="`cmd_vel` in the robot's namespace",
        example='"/cmd_vel"',
    ),
    "message": Key(
        '`"Twist"`, `"TwistStamped"`, or `"auto"`: the type that its subscribers expect',
        default="the profile's",
        choices=MESSAGES,
    ),
    "frame": Key("the `frame_id` of its `TwistStamped` messages", default='`"base_link"`', example='"anna/base_link"'),
    "reset": Key(
        "a service of type `std_srvs/srv/Empty` that moves it back to its start", default="none", example='"/reset"'
    ),
    "odom": Key(
        "a topic that says where it really is; without a leading `/`, the name is in the robot's namespace, which is in"
        " that of `[ros]`",
        default="none",
        example='"odom"',
    ),
    "odom_frame": Key(
        'the frame of these poses: `"own"`, which Improv aligns with the world at beat 0, or `"world"`',
        default="that of `[ros]`",
        choices=get_args(OdomFrame),
    ),
    "battery": Key(
        "a topic of type `sensor_msgs/msg/BatteryState`; names are as for `odom`",
        default="`battery_state` with `odom`, otherwise none",
        example='"battery_state"',
    ),
    "joints": OFFSETS,
    "host": Key(
        "the machine whose own stage moves it, as ssh calls it; `improv hosts allow` has to approve it once",
        default="this machine",
        example='"pi@anna.local"',
    ),
    "link_patience": _number(
        "how long it dances on when its host hears nothing from this machine", "seconds", 0.5, 10, "0.5"
    ),
    "follow": Key(
        "whether it is pulled back to its ideal path when it drifts, by at most 10% of its limits",
        "boolean",
        default="false",
        example="true",
    ),
}
# The ranges catch typical errors: 0, millimeters, an angle in radians.
_PROFILE = {
    "base": Key("the profile it starts from", profile=True),
    "step": _number("the distance of `forward`", "meters", 0.001, 100),
    "quarter_turn": _number("the angle of `left`", "degrees", 45, 135, "90"),
    "commanded_step": _number(
        "the distance to command so that the real robot drives a `step`", "meters", 0.0005, 200, "the same as `step`"
    ),
    "commanded_quarter_turn": _number(
        "the angle to command so that the real robot turns a `quarter_turn`",
        "degrees",
        22.5,
        270,
        "the same as `quarter_turn`",
    ),
    "left_right": _number(
        "how far the left wheel of the real robot rolls for each meter of the right one; below 1, it pulls to the left",
        "meters per meter",
        0.8,
        1.25,
        "1",
    ),
    "max_linear": _number("the maximum speed in any direction", "m/s", 0.001, 100, "no limit"),
    "max_angular": _number("the maximum turning speed", "rad/s", 0.001, 100, "no limit"),
    "max_linear_acceleration": _number(
        "the acceleration of simulated motors, and how hard a real robot brakes, for `keep_apart`",
        "m/s²",
        0.001,
        1000,
        "no limit",
    ),
    "max_angular_acceleration": _number("the same for turning", "rad/s²", 0.001, 1000, "no limit"),
    "turning_radius": _number(
        "the radius of the tightest curve that a car can drive; it never turns on the spot",
        "meters",
        0.001,
        100,
        "none: it turns on the spot",
    ),
    "motions": Key(
        'some of `"forward"`, `"turn"`, `"strafe"`, `"climb"`',
        "array",
        default="all four",
        items=Key("a motion that it can make, in both directions", choices=MOTIONS),
        example='["forward", "turn"]',
    ),
    "command_rate": _number("how often its velocity is sent while it moves", "Hz", 1, 200, "20"),
    "radius": _number("the radius of its disc in the simulator", "meters", 0.001, 100, "0.3"),
    "message": Key("same as for a robot", default='`"auto"`', choices=MESSAGES),
    "dynamics": Key(
        'how the simulator moves it: `"ideal"`, or like real `"motors"`', default='`"ideal"`', choices=DYNAMICS
    ),
    "wheel_error": Key(
        "how far the left and the right wheel of a simulated robot really roll for each meter that they should",
        "array",
        default="`[1, 1]`",
        least=0.5,
        most=1.5,
        items=Key("the distance for each meter", "number", least=0.5, most=1.5),
        count=2,
        example="[0.98, 1.0]",
    ),
    "noise": _number(
        "the standard deviation of that, which changes ten times a second", "shares of the speed", 0, 0.5, "0"
    ),
    "smooth": Key(
        "begin and end each movement gently, for robots that are tall or heavy",
        "boolean",
        default="false",
        example="true",
    ),
    "near": _number(
        "how far ahead the sense `near` looks in the simulator, from the robot's rim", "meters", 0.001, 100, "one step"
    ),
    **BODY,
}
_ROS = {
    "namespace": Key(
        "the prefix for all names of topics and services that don't begin with `/`", default="none", example='"lab"'
    ),
    "node": Key(
        "the name of Improv's node, for its services and parameters",
        default="`improv_HOST_PID`",
        example='"conductor"',
    ),
    "publish": Key(
        "publish what plays, for rviz, Foxglove, and monitors: paths, markers, the position, and diagnostics",
        "boolean",
        default="false",
        example="true",
    ),
    "use_sim_time": Key(
        "stamp messages with the time on `/clock`, for simulated robots", "boolean", default="false", example="true"
    ),
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
    "start_without": Key(
        "begin although some robots don't listen, and name them; if false, nothing moves until all listen",
        "boolean",
        default="true",
        example="false",
    ),
}
_FAULTS: Mapping[Fault, str] = {
    "off_path": "a robot is farther off its path than `distance` or `angle`",
    "silent": "no pose of a robot has come for a second",
    "jumped": "the poses of a robot jump farther than it can move",
    "stuck": "a robot doesn't move although it should",
    "gone": "nothing listens on a robot's topic anymore",
    "late": "commands leave more than 20 ms late",
}
_ON: Mapping[str, Key] = {
    **{
        fault: Key(f"what follows if {about}", default='`"tell"`', choices=get_args(Response))
        for fault, about in _FAULTS.items()
    },
    "distance": _number("how far off its path a robot may be", "meters", 0.01, 100, "0.25"),
    "angle": _number("how far it may be turned away from it", "degrees", 1, 180, "15"),
}
_CIRCLE = {"x": _place("the center along x"), "y": _place("the center along y"), "radius": _length("its radius")}
_BOX = {
    "x": _place("the center along x"),
    "y": _place("the center along y"),
    "width": _length("its size along its own x axis"),
    "height": _length("its size along its own y axis"),
    "heading": _HEADING,
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
        items=Key("a wall: from x, y to x, y", "array", items=_place("a coordinate"), count=4, example="[0, 0, 2, 0]"),
        example="[[0, 0, 2, 0]]",
    ),
    "circles": Key(
        "round obstacles, in meters: `x` and `y`, which default to 0, and `radius`",
        "array",
        default="none",
        items=_table("a round obstacle", _CIRCLE, "{ x = 1, y = 0, radius = 0.3 }", ("radius",)),
        example="[{ x = 1, y = 0, radius = 0.3 }]",
    ),
    "boxes": Key(
        "rectangles, in meters: `x`, `y`, `width`, and `height`, and a `heading` in degrees; `x`, `y`, and `heading`"
        " default to 0",
        "array",
        default="none",
        items=_table("a rectangle", _BOX, "{ x = 1, y = 0, width = 0.5, height = 1 }", ("width", "height")),
        example="[{ x = 1, y = 0, width = 0.5, height = 1 }]",
    ),
    "margin": _number(
        "how far robots should stay from each other and from walls and obstacles: the check warns if they come nearer",
        "meters",
        0,
        1000,
        "0",
    ),
    "keep_apart": _number(
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
    "from": _number(
        "the start of the sector of a scan that counts, counterclockwise from straight ahead",
        "degrees",
        -360,
        360,
        "-180",
    ),
    "to": _number("the end of that sector", "degrees", -360, 360, "180"),
    "button": Key(
        "the button of a gamepad, counted from 0",
        "integer",
        default="any button",
        least=0,
        most=MOST_BUTTON,
        example="0",
    ),
    "timeout": _number(
        "after this time without a usable message, the sense is silent; 0, for a Bool or a Joy, if messages come only"
        " when something changes",
        "seconds",
        0.05,
        60,
        "1",
    ),
    "key": Key("a letter or a digit, instead of a topic", example='"d"'),
    "osc": Key(
        "the word that stands for it in OSC messages, `/improv/sense WORD ROBOT 1`, instead of a topic",
        example='"kick"',
    ),
}
_PREFLIGHT = {
    "distance": _number("how far from its place a robot may stand", "meters", 0.001, 100, "0.1"),
    "degrees": _number("by how much it may be turned", "degrees", 0.1, 180, "10"),
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
    "distance": _number("how far apart neighbors are, from center to center", "meters", 0.001, 1000, "3"),
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
SCHEMA = _table(
    "an `improv.toml`",
    {
        "robots": Key("the robots, by their names in programs", "object", named=_table("a robot", _ROBOT)),
        "profiles": Key("your own kinds of robots, by name", "object", named=_table("a kind of robot", _PROFILE)),
        "formation": _table("where robots without a `start` start", _FORMATION, required=("shape",)),
        "ros": _table("names, time, and safety in ROS 2, for all robots", _ROS),
        "hosts": Key(
            "machines that have a stage of their own, as ssh calls them", "object", named=_table("a machine", _HOST)
        ),
        "on": _table("what follows from the faults of real robots", _ON),
        "world": _table("the simulator's walls and obstacles", _WORLD),
        "clock": _table("a clock from outside that robots follow", _CLOCK),
        "preflight": _table("how far from their places robots may stand when they begin", _PREFLIGHT),
        "music": MUSIC,
        "senses": Key("where senses come from, by their names in programs", "object", named=_table("a sense", _SENSE)),
        "osc": _table("the programs with which OSC messages are exchanged", OSC),
    },
)
