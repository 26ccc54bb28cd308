"""The rules that make robots stand, and those that tell whether they do. Standard library only.

It may import `protocol` and `score`. Begin with `stops`, the count that lets a stop win over all else, and
`stop_socket`, the way of `improv stop`; `pending_zeros`, `failover`, and `stage_watchdog` cover what dies or hangs.
"""
