"""Recordings of what robots were told."""
