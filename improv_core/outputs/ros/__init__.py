"""Real robots, over ROS 2. rclpy is imported lazily, and only here.

Begin with `output`, then `topic`, which decides which messages go to one topic. `joints`, `sensors`, `publisher`, and
`standby` have docstrings of their own; `setup` finds a Python with rclpy and needs none.
"""
