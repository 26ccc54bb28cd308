#!/bin/sh
# Makes .cache/ros: a Python environment with the packages of our extra `ros`, and nothing of ours in it.
set -eu
cd "$(dirname "$0")/../.."
python3 -m venv .cache/ros
python3 -c '
import tomllib
print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["ros"], sep="\n")
' >.cache/ros/requirements.txt
.cache/ros/bin/pip install --quiet -r .cache/ros/requirements.txt
.cache/ros/bin/python -c 'import rclpy, geometry_msgs.msg'
