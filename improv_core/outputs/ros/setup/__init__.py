"""Finds a Python with rclpy, or installs one, and proves that it carries a Twist. Begin with `interpreter`.

Standard library only. `hosts` uses it too, to set up other machines.
"""
