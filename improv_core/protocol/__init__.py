"""The messages between processes, their checks, and the port of outputs. Standard library only.

It may import only `score` and `plain`; everything that plays imports it. Begin with `messages`, then `commands`,
which people may send; `output` lists the methods of an output that the player calls.
"""
