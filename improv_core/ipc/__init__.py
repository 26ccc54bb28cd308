"""Processes that we start, and the lines between them. Standard library only.

It may import `safety`, `protocol`, and `score`. Begin with `child`, which starts, feeds, and ends any process of ours;
`stage_process` is the one that moves robots.
"""
