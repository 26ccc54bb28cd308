"""One performance on one or more stages: starts them, and decides which messages each gets.

It may import `music`, `ipc`, `safety`, `protocol`, and `score`. Begin with `state`, all that a session knows; then
`on_request` and `on_report`, which decide; `session` carries out their decisions. If real robots have stages on several
machines, `on_hosts` and `host_reports` decide how these play as one, by what `together` knows.
"""
