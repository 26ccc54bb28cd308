"""Decides what robots do, and sends it. Standard library only."""
