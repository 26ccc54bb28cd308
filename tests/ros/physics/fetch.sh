#!/bin/sh
# Makes .cache/mujoco: a Python environment with MuJoCo's bindings, without its viewer.
set -eu
cd "$(dirname "$0")/../../.."
python3 -m venv .cache/mujoco
.cache/mujoco/bin/pip install --quiet --only-binary :all: 'mujoco-core>=4,<5'
.cache/mujoco/bin/python -c 'import mujoco'
