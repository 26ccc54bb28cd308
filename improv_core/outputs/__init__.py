"""Outputs: simulated robots, real robots, and files. Each that moves robots is a `protocol.output.Sink`.

They may import `ipc`, `preview`, `safety`, `protocol`, and `score`; only the stage opens an output. Begin with
`simulator`, which needs nothing else.
"""
