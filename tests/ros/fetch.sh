#!/bin/sh
# Makes .cache/ros: a Python environment with the packages that `improv ros setup` installs, and nothing of ours in it.
set -eu
cd "$(dirname "$0")/../.."
python3 -m venv .cache/ros
.cache/ros/bin/pip install --quiet --require-hashes --only-binary :all: --no-deps \
  --requirement improv_core/commands/ros_requirements.txt
.cache/ros/bin/python -c 'import rclpy, geometry_msgs.msg'
