"""The joints of real robots: controllers of ros2_control."""
