"""Robot profiles: the length of a step, speed limits, and possible motions. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from improv_core.score.body import Body, BodyGroup, BodyPart, BodyPose, Drive, Joint
from improv_core.score.motion import Twist

MOTIONS = ("forward", "turn", "strafe", "climb")
DYNAMICS = ("ideal", "motors")
LIMITED = "limits"
"""The `dynamics` of an ideal robot that is simulated beside its real one (`beside_robots`)."""
MESSAGES = ("auto", "Twist", "TwistStamped")

WHEEL_SEPARATION = 1.42
"""The distance between the wheels in radii: 0.233 m for 0.164 m, as in a Create 3 (create3_sim, create3.urdf.xacro)."""

_WHEELS = ("forward", "turn")


@dataclass(frozen=True, slots=True)
class Profile:
    """A kind of robot. Values that are not given impose no limit."""

    name: str
    step: float
    """Meters that `forward` covers."""
    quarter_turn: float = math.pi / 2
    """Radians that `left` turns."""
    linear_scale: float = 1.0
    """Meters in the real robot's command for each one that it should move."""
    angular_scale: float = 1.0
    """Radians in its command for each one that it should turn."""
    left_right: float = 1.0
    """Meters that its left wheel rolls for each meter of the right one."""
    max_linear: float | None = None
    """m/s."""
    max_angular: float | None = None
    """rad/s."""
    max_linear_acceleration: float | None = None
    """m/s²."""
    max_angular_acceleration: float | None = None
    """rad/s²."""
    turning_radius: float | None = None
    """Meters, of the tightest curve that a car can drive; None for a robot that turns on the spot."""
    motions: tuple[str, ...] = MOTIONS
    """Those of `MOTIONS` that it can make, in both directions."""
    command_rate: float = 20.0
    """Commands per second, in Hz. turtlesim stops a turtle 1 s after its last command, diff_drive_controller and
    Create 3 (release H.2.5) after 0.5 s; 20 Hz leaves room."""
    radius: float = 0.3
    """Meters, of its disc in the simulator."""
    message: str = "auto"
    """One of `MESSAGES`. A TurtleBot3 or a TurtleBot 4 expects another one in each ROS release, so no built-in profile
    fixes it."""
    dynamics: str = "ideal"
    """One of `DYNAMICS`, for the simulator: it moves exactly as the score says, or as motors would."""
    wheel_error: tuple[float, float] = (1.0, 1.0)
    """With motors: meters that its left and right wheels really roll for each meter that their encoders count."""
    noise: float = 0.0
    """The standard deviation of `wheel_error`, as a share."""
    smooth: bool = False
    """True if its movements begin and end gently, stretch by stretch."""
    near: float | None = None
    """Meters ahead of it in which it senses what is near; None stands for one step."""
    body: Body | None = None
    """Its body parts, besides its base."""
    stops_after: float | None = None
    """Seconds after its last command in which its base stops by itself; 0 if it never does, None if that isn't
    known."""
    accept_no_stop: bool = False
    """True if somebody has accepted that it never stops by itself."""
    backward_limit: float | None = None
    """Meters that it drives backward until it stops by itself; None if it has no limit."""

    @property
    def reach(self) -> float:
        """Meters ahead of it in which the simulator senses what is near."""
        return self.step if self.near is None else self.near

    @property
    def wheel_separation(self) -> float:
        """Meters between its wheels."""
        return WHEEL_SEPARATION * self.radius

    @property
    def drives_anywhere(self) -> bool:
        """True if it can turn on the spot and drive forward, so that it gets to any place."""
        return not self.turning_radius and {"forward", "turn"} <= {*self.motions}

    @property
    def needs_standby(self) -> bool:
        """True if nothing but a standby stops its base once its commands end, and nobody has accepted that."""
        return self.stops_after == 0 and not self.accept_no_stop

    def command_for(self, twist: Twist) -> Twist:
        """Return the command with which the real robot moves like this: calibrated, and within its limits."""
        return self.limited(self.calibrated(twist))

    def calibrated(self, twist: Twist) -> Twist:
        """Return the twist with which a base that drives or turns too little, or pulls to one side, moves like this."""
        if self.linear_scale != 1 or self.angular_scale != 1:
            linear = self.linear_scale
            twist = Twist(twist.x * linear, twist.y * linear, twist.z * linear, twist.yaw * self.angular_scale)
        return twist if self.left_right == 1 else twist.balanced(self.left_right, self.wheel_separation)

    def seconds_between(self, before: Twist, after: Twist) -> float:
        """Return the seconds that its accelerations need from one velocity to another."""
        change = after.plus(before.times(-1))
        linear, angular = math.hypot(change.x, change.y, change.z), abs(change.yaw)
        return max(
            linear / (self.max_linear_acceleration or math.inf), angular / (self.max_angular_acceleration or math.inf)
        )

    def limited(self, twist: Twist) -> Twist:
        """Return this twist, or a slower one if it exceeds a limit."""
        return twist.within(self.max_linear, self.max_angular)


SLOW_SHARE, SLOW, SLOW_TURN = 0.2, 0.1, 0.5
"""The share of its limits with which a robot drives to a place, and m/s and rad/s if it has none."""


def slow_speeds(profile: Profile) -> tuple[float, float]:
    """Return the speeds with which a robot drives and turns on its way to a place, in m/s and rad/s."""
    linear, angular = profile.max_linear, profile.max_angular
    return linear * SLOW_SHARE if linear else SLOW, angular * SLOW_SHARE if angular else SLOW_TURN


def beside_robots(profile: Profile) -> Profile:
    """Return the profile of a simulated robot beside its real one. It keeps only the limits that the real one has.

    Its speeds are sent within them, and its base limits its accelerations, so an ideal robot would be elsewhere.
    """
    speeds = (profile.max_linear, profile.max_angular)
    accelerations = (profile.max_linear_acceleration, profile.max_angular_acceleration)
    has_limits = any(limit is not None for limit in (*speeds, *accelerations))
    return replace(profile, dynamics=LIMITED) if profile.dynamics == "ideal" and has_limits else profile


# turtlesim's turtle.cpp has no speed limit and no height. It obeys `linear.y` only if its parameter `holonomic` is set,
# which is false by default (ros_tutorials#131, since turtlesim 1.5.0: Iron, Jazzy, and later; Humble always obeys it).
TURTLESIM = Profile("turtlesim", step=2.0, motions=_WHEELS, stops_after=1.0)

DEFAULT = replace(TURTLESIM, motions=MOTIONS, stops_after=None)
"""For a robot without a profile: it steps like turtlesim and, since nothing is known about it, may use all motions."""

# Robots on a floor step 0.2 m. At tempo 60 that is 0.2 m/s, within every robot's limit; a quarter turn, at 1.57 rad/s,
# is too fast for a Husky and a Leo Rover. It is the same for all of them, so a program takes up the same space with
# each. The radius is half the longer side of the body, according to the manual.
_FLOOR_STEP = 0.2

# ROBOTIS e-Manual, TurtleBot3, Specifications: Burger 0.22 m/s, 2.84 rad/s, 138 mm × 178 mm; Waffle and Waffle Pi
# 0.26 m/s, 1.82 rad/s, 281 mm × 306 mm. The same speeds are in turtlebot3_teleop. A Burger may ignore faster commands
# (turtlebot3#765, OpenCR#322). The manual gives no acceleration limit. Its ROS 2 node and firmware keep the last
# command: the firmware stops the motors only if the node dies (turtlebot3#1154).
TURTLEBOT3_BURGER = Profile(
    "turtlebot3_burger", _FLOOR_STEP, max_linear=0.22, max_angular=2.84, motions=_WHEELS, radius=0.089, stops_after=0.0
)
TURTLEBOT3_WAFFLE = Profile(
    "turtlebot3_waffle", _FLOOR_STEP, max_linear=0.26, max_angular=1.82, motions=_WHEELS, radius=0.153, stops_after=0.0
)

# iRobot Create 3 docs, API, Safety: 0.306 m/s; 0.46 m/s only if the user sets `safety_override` to `full`;
# 0.9 m/s² (`wheel_accel_limit`). TurtleBot 4 User Manual, Features: 1.90 rad/s, 342 mm × 339 mm.
# 7.725 rad/s²: both wheels at 0.9 m/s², as in create3_sim's control.yaml. create3_sim, motion_control_node: 0.5 s
# without a command, and 0.15 m backward (real ones: 0.1 to 1 m, turtlebot4#66, #11); driving forward gives that back.
TURTLEBOT4 = Profile(
    "turtlebot4",
    _FLOOR_STEP,
    max_linear=0.306,
    max_angular=1.9,
    max_linear_acceleration=0.9,
    max_angular_acceleration=7.725,
    motions=_WHEELS,
    radius=0.171,
    stops_after=0.5,
    backward_limit=0.15,
)

# The same base without its tower: 0.306 m/s, 1.9 rad/s, and both accelerations as above. The radius is that of the body
# in create3_sim's create3.urdf.xacro.
CREATE3 = replace(TURTLEBOT4, name="create3", radius=0.164)

# clearpath_common, clearpath_control/config: j100/control.yaml 2.0 m/s, 4.0 rad/s, 20 m/s², 25 rad/s², and
# a200/control.yaml 1.0 m/s, 1.0 rad/s, 1.0 m/s², 1.0 rad/s²; both 0.5 s (`cmd_vel_timeout`). Jackal User Manual:
# 508 mm × 430 mm. Husky A200 User Manual: 990 mm × 670 mm.
JACKAL = Profile(
    "jackal",
    _FLOOR_STEP,
    max_linear=2.0,
    max_angular=4.0,
    max_linear_acceleration=20.0,
    max_angular_acceleration=25.0,
    motions=_WHEELS,
    radius=0.254,
    stops_after=0.5,
)
HUSKY = Profile(
    "husky",
    _FLOOR_STEP,
    max_linear=1.0,
    max_angular=1.0,
    max_linear_acceleration=1.0,
    max_angular_acceleration=1.0,
    motions=_WHEELS,
    radius=0.495,
    stops_after=0.5,
)

# Leo Rover specification (version 1.9): 0.4 m/s, 1 rad/s, 424 mm × 445 mm. It gives no acceleration limit.
# leocore_firmware_ros2, parameters.hpp: 0.5 s (`robot_input_timeout`).
LEO_ROVER = Profile(
    "leo_rover", _FLOOR_STEP, max_linear=0.4, max_angular=1.0, motions=_WHEELS, radius=0.223, stops_after=0.5
)

# The last two are no machine in particular: step and radius are our choice, and the limits are what small machines
# of the kind keep, the lowest of each source.

# The two mecanum bases of rosbot_ros, mecanum_drive_controller.yaml: ROSbot XL 0.8 m/s, 3.14 rad/s; ROSbot 0.9 m/s,
# 3.0 rad/s; both 1.0 m/s², 4.0 rad/s², and 0.5 s (`cmd_vel_timeout`).
HOLONOMIC = Profile(
    "holonomic",
    _FLOOR_STEP,
    max_linear=0.8,
    max_angular=3.0,
    max_linear_acceleration=1.0,
    max_angular_acceleration=4.0,
    motions=(*_WHEELS, "strafe"),
    radius=0.2,
    stops_after=0.5,
)

# Crazyflie firmware, platform_defaults_cf2.h: PID_POS_VEL_X_MAX, Y and Z 1.0 m/s. Tello SDK 2.0 User Guide, `go`: at
# most 100 cm/s. PX4's defaults are faster (MPC_Z_VEL_MAX_DN 1.5 m/s is the slowest); its MPC_MAN_Y_MAX is 150°/s,
# which is 2.61 rad/s. None of them has an acceleration that fits all.
QUADROTOR = Profile("quadrotor", step=0.5, max_linear=1.0, max_angular=2.61, motions=MOTIONS, radius=0.25)


def _arm(side: str, left: float, roll: tuple[float, float]) -> tuple[BodyPart, Sequence[Joint]]:
    """Return an arm of the puppet. `left` is the sign of the way to the left, and `roll` the limits of that joint."""
    pitch, out, elbow = (f"{side}_{joint}" for joint in ("shoulder_pitch", "shoulder_roll", "elbow"))
    drives = (_drive("z", pitch, 45), _drive("yaw", out, 30), _drive("x", elbow, 40))
    poses = (BodyPose("high", {"z": 150 / 45}), BodyPose("wide", {"yaw": left * 80 / 30}))
    other = "right_arm" if side == "left" else "left_arm"
    joints = (_joint(pitch, -60, 180), _joint(out, *roll), _joint(elbow, 0, 140))
    return BodyPart(f"{side}_arm", drives, other, poses), joints


def _drive(direction: str, joint: str, degrees: float) -> Drive:
    return Drive(direction, joint, math.radians(degrees))


def _joint(name: str, least: float, most: float) -> Joint:
    return Joint(name, math.radians(least), math.radians(most))


def _puppet() -> Body:
    head = BodyPart("head", (_drive("yaw", "head_yaw", 30), _drive("z", "head_pitch", 20)))
    left, left_joints = _arm("left", 1, (-30, 120))
    right, right_joints = _arm("right", -1, (-120, 30))
    joints = (_joint("head_yaw", -90, 90), _joint("head_pitch", -45, 45), *left_joints, *right_joints)
    return Body((head, left, right), (BodyGroup("arms", ("left_arm", "right_arm")),), joints)


# No machine either: a body for a first dance, in the simulator only. All of its numbers are our choice.
PUPPET = Profile("puppet", step=1.0, body=_puppet())

# Wheels: 9.4 cm apart, at most 16.6 cm/s (Enki, robots/thymio2/Thymio2.cpp); the angular limit is that of both wheels.
# It reaches 8 cm ahead of its axle. The output's own program stops its motors after 0.5 s without a command.
THYMIO2 = Profile(
    "thymio2",
    0.1,
    max_linear=0.166,
    max_angular=3.53,
    motions=_WHEELS,
    radius=0.08,
    command_rate=10.0,
    near=0.1,
    stops_after=0.5,
)

BUILT_IN: Mapping[str, Profile] = {
    profile.name: profile
    for profile in (
        TURTLESIM,
        TURTLEBOT3_BURGER,
        TURTLEBOT3_WAFFLE,
        TURTLEBOT4,
        CREATE3,
        JACKAL,
        HUSKY,
        LEO_ROVER,
        HOLONOMIC,
        QUADROTOR,
        PUPPET,
        THYMIO2,
    )
}
