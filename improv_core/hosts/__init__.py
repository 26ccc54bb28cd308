"""The link to a stage on another machine: its near end, its far end, and what travels between them. Standard library
only, Python 3.10 and newer."""
