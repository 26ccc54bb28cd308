"""Processes that we start, and the lines between them. Standard library only."""
