"""The language server: all of LSP, and nothing else.

It may import all of the core except `commands`. Begin with `server`, which connects each method to its handler; then
`session` and `documents`, and `performance`, which starts and conducts the one dance of a session.
"""
