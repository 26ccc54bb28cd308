"""The command line: one command per file, named after it.

It may import all of the core, and only `__main__` imports it. Begin with `main`, then read any one command.
"""
