"""Real robots, over ROS 2. rclpy is imported lazily, and only here.

Begin with `output`, then `topic`, which decides what one topic is sent. `joints`, `sensors`, `publisher`, and `standby`
are told by their own packages; `setup` finds a Python with rclpy and needs none.
"""
