"""The stage: a process of its own that plays scores on one sink. Standard library only, Python 3.10 and newer."""
