"""Sources of the numbers in the built-in profiles; docs/profiles.md says more about each."""

from __future__ import annotations

from collections.abc import Mapping

SOURCES: Mapping[str, str] = {
    "turtlesim": "https://github.com/ros/ros_tutorials/pull/131",
    "turtlebot3_burger": "https://emanual.robotis.com/docs/en/platform/turtlebot3/features/#specifications",
    "turtlebot3_waffle": "https://emanual.robotis.com/docs/en/platform/turtlebot3/features/#specifications",
    "turtlebot4": "https://turtlebot.github.io/turtlebot4-user-manual/overview/features.html",
    "create3": "https://iroboteducation.github.io/create3_docs/api/safety/",
    "jackal": "https://github.com/clearpathrobotics/clearpath_common/blob/jazzy/clearpath_control/config/j100/control.yaml",
    "husky": "https://github.com/clearpathrobotics/clearpath_common/blob/jazzy/clearpath_control/config/a200/control.yaml",
    "leo_rover": "https://docs.fictionlab.pl/leo-rover/documentation/specification",
    "holonomic": "https://github.com/husarion/rosbot_ros",
    "quadrotor": "https://github.com/bitcraze/crazyflie-firmware/blob/master/src/platform/interface/platform_defaults_cf2.h",
}
