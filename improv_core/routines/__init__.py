"""Performances of Improv's own: robots drive to their places (`place_*`), and are calibrated (`calibration`).

It may import `robots`, `score`, and `protocol`; only `commands` uses it. Begin with `place_plan`.
"""
