"""Robots in MuJoCo, whose wheels slip and are biased, as ROS 2 sees them: `python -m tests.ros.physics --help`.

Nothing here uses Improv's own motion: the physics is independent, so it can contradict what Improv believes.
MuJoCo has an environment of its own, and ROS 2 another: `__main__` starts a process in each, and passes messages.
"""
