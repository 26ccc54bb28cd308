"""Editor features for `improv.toml`, one per file. They never raise, however little of the text is typed.

It may import what `ide` may. Begin with `hover`.
"""
