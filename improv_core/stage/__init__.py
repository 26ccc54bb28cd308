"""The process that moves robots: a `Player`, one output, and the lines to and from the session.

It may import `outputs`, `ipc`, `player`, `safety`, and `protocol`; `page` and `website` run it in their processes.
Begin with `process`, then `loop`. Standard library only, Python 3.10 and newer.
"""
