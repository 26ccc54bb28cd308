"""Robots in MuJoCo, whose wheels slip and are biased, as ROS 2 sees them: `python -m tests.ros.physics --help`.

Nothing here uses Improv's own motion: the physics is independent, so it can contradict what Improv believes.
MuJoCo and ROS 2 have one environment each: `__main__` starts a process in both, and passes messages.
"""
