#!/bin/sh
# Renews the list of the wheels that `improv ros setup` installs, for all Pythons it supports. Needs uv.
# empy is left out: it only generates code for new messages, and PyPI has no wheel of it.
set -eu
cd "$(dirname "$0")/../.."
python3 -c '
import tomllib
extra = tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["ros"]
print(*(line.partition(";")[0] for line in extra), sep="\n")
' | uv pip compile - --quiet --universal --python-version 3.10 --no-python-downloads --upgrade --generate-hashes \
  --no-emit-package empy --no-annotate --no-emit-index-url --custom-compile-command "sh tests/ros/pin.sh" \
  --output-file improv_core/outputs/ros/setup/requirements.txt
