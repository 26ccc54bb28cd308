"""The handlers of LSP's methods, by subject: each converts the position, calls `ide`, and converts the answer.

`FEATURES` in `server` has the handler of each method. Begin with `hover`.
"""
