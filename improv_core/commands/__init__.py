"""The command line. A command is in the file of its name; the other files are parts that commands share.

It may import all of the core, and only `__main__` imports it. Begin with `main`, then read any one command.
"""
