"""The rules that make robots stand, and those that detect that robots or processes fail. Standard library only.

It may import `protocol` and `score`. Begin with `stops`, the count that lets a stop win over everything else,
`stop_socket`, which serves `improv stop`, and `stage_stops`, by which a stop reaches stages directly; `pending_zeros`,
and `heartbeat` are for processes that die or hang.
"""
