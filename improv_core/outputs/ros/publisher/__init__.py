"""The process that publishes scores and poses for other ROS 2 programs, and the stage's side of it.

Begin with `client`, the stage's side; `process` is the other side.
"""
