"""Performances of Improv's own: robots drive to their places (`place_*`) and are calibrated (`calibration`).

They may import `robots`, `score`, and `protocol`; only `commands` uses them. Begin with `place_plan`.
"""
