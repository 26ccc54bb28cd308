"""Decides what robots do, and sends it. Standard library only.

It may import `safety`, `protocol`, and `score`. Begin with `decide`: each event makes a new `Run` and acts. `apply`
does the acts, `player` has the only loop, and `tracks` is the fast part, which sends each setpoint at its time.
"""
