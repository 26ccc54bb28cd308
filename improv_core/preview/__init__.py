"""The near future of a dance, computed from a stage's reports. Standard library only.

It may import `protocol` and `score`. Begin with `window`.
"""
