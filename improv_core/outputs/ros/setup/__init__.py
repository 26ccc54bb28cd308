"""Finds a Python with rclpy, or installs one, and proves that it works."""
