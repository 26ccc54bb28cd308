"""The keys of an `improv.toml` that describe the body of a profile."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from improv_core.robots.schema_key import Key, number, table
from improv_core.score.body import Home, Interface

MOST_DEGREES, MOST_METERS = 720, 10


def _amount(about: str) -> Key:
    return number(about, "degrees, or meters", -MOST_DEGREES, MOST_DEGREES)


def _direction(about: str) -> Key:
    keys = {
        "joint": Key("the joint that it moves; no other direction may move it", example='"head_yaw"'),
        "degrees": number("how far that turns in a beat", "degrees", -MOST_DEGREES, MOST_DEGREES),
        "meters": number("how far that slides in a beat, if it is a slider", "meters", -MOST_METERS, MOST_METERS),
    }
    return table(about, keys, '{ joint = "head_yaw", degrees = 30 }', ("joint",))


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
        example='["left_arm", "right_arm"]',
    ),
}
_JOINT = {
    "min": _amount("its lower limit"),
    "max": _amount("its upper limit"),
    "max_velocity": number("its highest speed", "degrees or meters per second", 0.001, 10_000, "no limit"),
    "start": replace(_amount("where it is at beat 0"), default="0"),
}
OFFSETS = Key(
    "how its joints differ from those of its profile, by name",
    "object",
    named=table("a joint", {"offset": replace(_amount("how far the real one is beyond where it says"), default="0")}),
)
_CONTROLLER = {
    "joints": Key("the joints that it moves", "array", items=Key("a joint"), example='["head_yaw", "head_pitch"]'),
    "interface": Key(
        'what it is sent: `"trajectory"`, `"position"`, or `"velocity"`',
        default='`"trajectory"`',
        choices=get_args(Interface),
    ),
    "topic": Key("its topic, in the robot's namespace", example='"head_controller/joint_trajectory"'),
}
BODY = {
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
