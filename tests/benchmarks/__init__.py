"""Benchmarks: they print tables, and no test depends on their times."""
