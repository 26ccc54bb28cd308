"""Reads `improv.toml`: robots and their world."""
