"""Reads `improv.toml`: robots, their profiles, and their world.

It may import `syntax.vocabulary`, `score`, `diagnostics`, and `text`. Begin with `schema`, the table of its keys.
"""
