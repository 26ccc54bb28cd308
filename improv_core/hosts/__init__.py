"""Stages on other machines, reached through ssh.

It may import `outputs.ros.setup`, `ipc`, and the packages below them; only `commands` and the session use it. Begin
with `near`, which is a stage for its parent; `far` runs on the other machine, and `frames` travel between the two.
Standard library only, Python 3.10 and newer.
"""
