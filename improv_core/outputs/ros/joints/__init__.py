"""The joints of real robots: controllers of ros2_control.

Begin with `trajectories`, which decides what controllers are sent; `controllers` sends it.
"""
