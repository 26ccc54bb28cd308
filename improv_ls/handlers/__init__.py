"""One file per LSP method, named after it: converts the position, calls `ide`, converts the answer.

`server` connects them. Begin with `hover`.
"""
