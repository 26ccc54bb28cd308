"""Outputs for robots that Improv reaches directly, each a package with an entry point in the group `improv.outputs`.

Begin with `device`, which is what such a package implements (docs/outputs.md); `sink` gives it everything else. They
may import `ipc`, `safety`, `protocol`, and `score`.
"""
