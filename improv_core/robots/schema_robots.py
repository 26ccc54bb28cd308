"""The keys of an `improv.toml` that describe robots and their profiles, with their bodies."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import get_args

from improv_core.robots.schema_key import Key, flag, number, table
from improv_core.score.body import Home, Interface
from improv_core.score.profiles import DYNAMICS, MESSAGES, MOTIONS
from improv_core.score.score import OdomFrame, is_host

MAX_DEGREES, MAX_METERS = 720, 10
DRIVE = '{ joint = "head_yaw", degrees = 30 }'
PLAIN_HOST = (
    "use a name as in ~/.ssh/config, `user@machine`, or `user@machine:port`: letters, digits, `_`, `.`, and `-`"
)


def place(about: str) -> Key:
    return number(about, "meters", -1000, 1000, "0")


def _amount(about: str) -> Key:
    return number(about, "degrees, or meters", -MAX_DEGREES, MAX_DEGREES)


def _direction(about: str) -> Key:
    keys = {
        "joint": Key(
            "the joint that it moves; no other direction may move it",
            example='"head_yaw"',
            form=(_is_visible, f"write the name of a joint: `{DRIVE}`"),
        ),
        "degrees": number("how far that turns in a beat", "degrees", -MAX_DEGREES, MAX_DEGREES),
        "meters": number("how far that slides in a beat, if it is a slider", "meters", -MAX_METERS, MAX_METERS),
    }
    return table(about, keys, DRIVE, ("joint",))


def _is_visible(name: str) -> bool:
    return name != "" and name.isprintable()


_DIRECTIONS = {
    "forward": _direction("what `forward` moves; `backward` is the opposite"),
    "strafeleft": _direction("what `strafeleft` moves; `straferight` is the opposite"),
    "up": _direction("what `up` moves; `down` is the opposite"),
    "left": _direction("what `left` moves; `right` is the opposite"),
}
_POSE = {name: _amount(f"where `{name}` leads") for name in _DIRECTIONS}
_BODY_PART = {
    **_DIRECTIONS,
    "mirror": Key("the body part on the other side, which `reflect YZ` exchanges with it", example='"right_arm"'),
    "poses": Key("its poses, by the names that follow `to`", "object", named=table("a pose", _POSE)),
    "parts": Key(
        "the body parts that this word stands for, instead of directions",
        "array",
        items=Key("a body part"),
        least=1,
        example='["left_arm", "right_arm"]',
    ),
}
_JOINT = {
    "min": _amount("its lower limit"),
    "max": _amount("its upper limit"),
    "max_velocity": number("its highest speed", "degrees or meters per second", 0.001, 10_000, "no limit"),
    "max_acceleration": number(
        "its highest acceleration, for the check and the trajectories of real robots",
        "degrees or meters per second²",
        0.001,
        100_000,
        "no limit",
    ),
    "smooth": flag("begin and end each movement of its body part gently"),
    "start": replace(_amount("where it is at beat 1"), default="0"),
}
_OFFSETS = Key(
    "how its joints differ from those of its profile, by name",
    "object",
    named=table("a joint", {"offset": replace(_amount("how far the real one is beyond where it says"), default="0")}),
)
_CONTROLLER = {
    "joints": Key(
        "the joints that it moves or holds", "array", items=Key("a joint"), example='["head_yaw", "head_pitch"]'
    ),
    "interface": Key(
        'what it is sent: `"trajectory"`, `"position"`, or `"velocity"`',
        default='`"trajectory"`',
        choices=get_args(Interface),
    ),
    "topic": Key("its topic, in the robot's namespace", example='"head_controller/joint_trajectory"'),
}
_BODY = {
    "joint_states": Key(
        "a topic of type `sensor_msgs/msg/JointState` that says where its joints really are, in the robot's namespace",
        default="none",
        example='"joint_states"',
    ),
    "home": Key(
        "what happens if joints of the real robot aren't at their `start` when a dance begins: "
        '`"wait"` until somebody has brought them there, or `"move"` them there first, at a fifth of `max_velocity`',
        default='`"wait"`',
        choices=get_args(Home),
    ),
    "urdf": Key(
        "a URDF of the robot, from which the page draws a figure that you can turn; the path begins in the folder of"
        " this file",
        default="none",
        example='"robot.urdf"',
    ),
    "body": Key("its body parts, by their words in programs", "object", named=table("a body part", _BODY_PART)),
    "joints": Key("the joints of its body parts, by name", "object", named=table("a joint", _JOINT)),
    "controllers": Key(
        "what moves the joints of the real robot in ROS 2, by name",
        "object",
        default="one for all joints",
        named=table("a controller", _CONTROLLER, required=("joints",)),
    ),
}
HEADING = number("the heading, counterclockwise from the x axis", "degrees", -360, 360, "0")
_START = {"x": place("the position along x"), "y": place("the position along y"), "heading": HEADING}
ROBOT = {
    "profile": Key(
        "the kind of robot: a built-in profile or one of yours",
        default="a step of 2 m, no limits, all motions",
        profile=True,
    ),
    "start": Key(
        "its pose at beat 1: `x`, `y` in meters, `heading` in degrees, counterclockwise from the x axis; each defaults"
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
    "frame": Key(
        "the `frame_id` of its `TwistStamped` messages",
        default='`"base_link"`',
        example='"anna/base_link"',
        form=(
            re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./-]{0,199}").fullmatch,  # tf2 refuses a leading `/`
            "use the letters a to z, digits, `_`, `.`, `-`, and `/`, but no `/` at the start",
        ),
    ),
    "reset": Key(
        "a service of type `std_srvs/srv/Empty` that moves it back to its start", default="none", example='"/reset"'
    ),
    "odom": Key(
        "a topic that says where it really is, of poses, odometry, or tf; without a leading `/`, the name is in the"
        " robot's namespace, which is in that of `[ros]`",
        default="none",
        example='"odom"',
    ),
    "odom_frame": Key(
        'the frame of these poses: `"own"`, which Improv aligns with the world at beat 1, or `"world"`',
        default="that of `[ros]`",
        choices=get_args(OdomFrame),
    ),
    "battery": Key(
        "a topic of type `sensor_msgs/msg/BatteryState`; names are as for `odom`",
        default="`battery_state` with `odom`, otherwise none",
        example='"battery_state"',
    ),
    "joints": _OFFSETS,
    "host": Key(
        "the machine whose own stage moves it, as ssh calls it; `improv hosts allow` has to approve it once",
        default="this machine",
        example='"pi@anna.local"',
        form=(is_host, PLAIN_HOST),
    ),
    "output": Key(
        "the output that moves it without ROS 2: `thymio`, or that of a package which you have installed",
        default="ROS 2",
    ),
    "address": Key(
        "the place where its output finds it: `serial:PORT` or `tcp:HOST:PORT`; `improv hosts allow` has to approve it"
        " once"
    ),
    "node": Key(
        "its number at that address, if several robots share it",
        "integer",
        default="the only one there, or the one with its name",
        least=0,
        most=65535,
    ),
    "settings": Key(
        "the settings of its output, in a section of their own",
        "object",
        named=Key("a setting of the output", "boolean number string"),
    ),
    "link_patience": number(
        "how long it dances on when its host hears nothing from this machine", "seconds", 0.5, 10, "0.5"
    ),
    "follow": flag("whether it is pulled back to its ideal path when it drifts, by at most 10% of its limits"),
}
# The ranges catch typical errors: 0, millimeters, an angle in radians.
PROFILE = {
    "base": Key("the profile it starts from", profile=True),
    "step": number("the distance of `forward`", "meters", 0.001, 100),
    "quarter_turn": number("the angle of `left`", "degrees", 45, 135, "90"),
    "commanded_step": number(
        "the distance to command so that the real robot drives a `step`", "meters", 0.0005, 200, "the same as `step`"
    ),
    "commanded_quarter_turn": number(
        "the angle to command so that the real robot turns a `quarter_turn`",
        "degrees",
        22.5,
        270,
        "the same as `quarter_turn`",
    ),
    "left_right": number(
        "how far the left wheel of the real robot rolls for each meter of the right one; below 1, it pulls to the left",
        "meters per meter",
        0.8,
        1.25,
        "1",
    ),
    "max_linear": number("the maximum speed in any direction", "m/s", 0.001, 100, "no limit"),
    "max_angular": number("the maximum turning speed", "rad/s", 0.001, 100, "no limit"),
    "max_linear_acceleration": number(
        "the acceleration of simulated motors and of real robots, for `keep_apart` and the check",
        "m/s²",
        0.001,
        1000,
        "no limit",
    ),
    "max_angular_acceleration": number("the same for turning", "rad/s²", 0.001, 1000, "no limit"),
    "turning_radius": number(
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
        least=1,
        items=Key("a motion that it can make, in both directions", choices=MOTIONS),
        example='["forward", "turn"]',
    ),
    "command_rate": number("how often its velocity is sent while it moves", "Hz", 1, 200, "20"),
    "radius": number("the radius of its disc in the simulator", "meters", 0.001, 100, "0.3"),
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
    "noise": number(
        "the standard deviation of that, which changes ten times a second", "shares of the speed", 0, 0.5, "0"
    ),
    "smooth": flag("begin and end each movement gently, for robots that are tall or heavy"),
    "near": number(
        "how far ahead the sense `near` looks in the simulator, from the robot's rim", "meters", 0.001, 100, "one step"
    ),
    "stops_after": number(
        "the time after its last command in which its base stops by itself; 0: never, so it plays only with"
        " `ros.standby` or `accept_no_stop`",
        "seconds",
        0,
        60,
        "not known",
    ),
    "accept_no_stop": flag("let it play without a standby although its base never stops by itself"),
    "backward_limit": number(
        "the distance that it drives backward until it stops by itself, for the check", "meters", 0, 1000, "no limit"
    ),
    **_BODY,
}
