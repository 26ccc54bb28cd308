"""Files that nobody loses: programs, saves, and their history.

It may import `program`, the packages below it, and `protocol`. Begin with `program_file`; `compare_and_swap` makes sure
that a save never overwrites a text that it hasn't seen.
"""
