"""Improv: live coding for robot motion. This package needs no editor and no robot."""

__version__ = "0.1.0"
