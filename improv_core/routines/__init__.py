"""Performances of our own: robots drive to their places, and are calibrated."""
