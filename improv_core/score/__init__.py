"""Holds the scores that stages play: movements, motion, and profiles. Standard library only, Python 3.10 and newer.

It may import only `slices` and `text`, and all others may import it. Begin with `movement`, then `walk`; a `score` has
a part for each robot.
"""
