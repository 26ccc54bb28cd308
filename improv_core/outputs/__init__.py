"""Where velocities go: simulated robots, real ones, and files. Each is a `protocol.output.Sink`.

It may import `ipc`, `preview`, `safety`, `protocol`, and `score`; only the stage opens an output. Begin with
`simulator`, which needs nothing else.
"""
