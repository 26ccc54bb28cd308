"""The joints of real robots, moved by controllers of ros2_control.

Begin with `trajectories`, which computes the controllers' commands; `controller` sends them.
"""
