"""Real robots, over ROS 2 (rclpy, imported lazily)."""
