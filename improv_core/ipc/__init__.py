"""The child processes of Improv, and the lines to and from them. Standard library only.

It may import `safety`, `protocol`, and `score`. Begin with `child`, which starts, feeds, and ends any child process;
`helper` is one that nobody waits for, and `stage_process` is the one that moves robots.
"""
