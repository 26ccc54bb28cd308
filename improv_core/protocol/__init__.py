"""The messages between processes, their checks, and the port of outputs. Standard library only.

It may import only `score` and `plain`; everything that plays imports it. Begin with `messages`, then `commands`, what
people may ask for; `output` lists what the player needs of an output.
"""
